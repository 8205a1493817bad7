// Haze that is not even, at one moment (render/shaders/shared/haze_field.h).
#pragma once

#include <cstdint>

#include "fixtures/model/rig.h"
#include "sim/shared/shared.h"

namespace footlight::render::f32 {
using namespace ::footlight::f32;
#include "render/shaders/shared/haze_field.h"
}  // namespace footlight::render::f32

namespace footlight::render::f64 {
using namespace ::footlight::f64;
#include "render/shaders/shared/haze_field.h"
}  // namespace footlight::render::f64

namespace footlight::render {

static_assert(sizeof(f32::HazeLayer) == 48);
static_assert(sizeof(f32::HazeField) == 160);

// The field of a show that has run for so long. The drift is computed in double and in whole cubes of the lattice, so
// the clouds are as exact after a year as after a second. Without the part of the rays that a table has.
[[nodiscard]] f64::HazeField haze_field(const fixtures::Haze& haze, std::int64_t time_ns);
// The same as the GPU has it.
[[nodiscard]] f32::HazeField haze_field_in_float(const f64::HazeField& field);

// The sphere that a rig's light in the air lies in.
struct HazeReach {
  glm::dvec3 center_m{0};
  double radius_m = 0;
};
[[nodiscard]] HazeReach haze_reach(const fixtures::Rig& rig, double range_m);

}  // namespace footlight::render
