// Haze that is not even, at one moment (render/shaders/shared/haze_field.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/plume.h"
#include "render/frame_io.h"
#include "sim/shared/shared.h"

namespace footlight::render::f32 {
using namespace ::footlight::f32;
#include "render/shaders/shared/haze_field.h"
#include "render/shaders/shared/haze_plume.h"
}  // namespace footlight::render::f32

namespace footlight::render::f64 {
using namespace ::footlight::f64;
#include "render/shaders/shared/haze_field.h"
#include "render/shaders/shared/haze_plume.h"
}  // namespace footlight::render::f64

namespace footlight::render {

static_assert(sizeof(f32::HazeLayer) == 48);
static_assert(sizeof(f32::HazeField) == 160);
static_assert(sizeof(f32::HazePuff) == 48);
static_assert(sizeof(f32::HazePlumes) == 16);

// The field of a show that has run for so long. The drift is computed in double and in whole cubes of the lattice, so
// the clouds are as exact after a year as after a second. Without the part of the rays that a table has.
[[nodiscard]] f64::HazeField haze_field(const fixtures::Haze& haze, std::int64_t time_ns);
// The same as the GPU has it.
[[nodiscard]] f32::HazeField haze_field_in_float(const f64::HazeField& field);

// The plumes of machines at one moment. Where they have haze, the air scatters by head.scattering_per_m per density of
// 1. That is at least kLeastScatteringPerM, so clear air with plumes in it counts as haze of that little.
inline constexpr double kLeastScatteringPerM = 1e-5;
struct PlumeField {
  f64::HazePlumes head{};
  std::vector<f64::HazePuff> puffs;
};
// Of the first FL_PUFFS_MAX puffs, which is what the GPU has room for. scattering_per_m: of the haze in the room.
[[nodiscard]] PlumeField plume_field(std::span<const fixtures::PlumePuff> puffs, double scattering_per_m,
                                     std::int64_t time_ns);
// What the GPU has of it: the head, then the puffs.
struct PlumeRows {
  f32::HazePlumes head{};
  std::vector<f32::HazePuff> puffs;
};
[[nodiscard]] PlumeRows plume_rows(const PlumeField& field);

// The sphere that a rig's light in the air lies in.
struct HazeReach {
  glm::dvec3 center_m{0};
  double radius_m = 0;
};
[[nodiscard]] HazeReach haze_reach(const fixtures::Rig& rig, double range_m);

}  // namespace footlight::render
