#include "render/haze.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace footlight::render {

f64::HazeField haze_field(const fixtures::Haze& haze, std::int64_t time_ns) {
  // Smaller clouds are faster by this much each: all of them in step would be a picture that is pushed along.
  constexpr double kFaster = 0.3;
  constexpr double kLighter = 0.7;
  f64::HazeField field{};
  glm::dvec3 way_m = haze.wind_m_s * (static_cast<double>(time_ns) * 1e-9);
  double weights = 0;
  for (std::uint32_t i = 0; i < FL_HAZE_LAYERS; ++i) weights += std::pow(kLighter, i);
  for (std::uint32_t i = 0; i < FL_HAZE_LAYERS; ++i) {
    f64::HazeLayer& layer = field.layers[i];
    way_m = f64::haze_turned(way_m);
    layer.per_m = std::exp2(static_cast<double>(i)) / haze.size_m;
    const glm::dvec3 cells = way_m * ((1 + kFaster * i) * layer.per_m);
    const glm::dvec3 whole = glm::floor(cells);
    layer.drift = cells - whole;
    const auto count = [](double n) { return static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::llround(n))); };
    layer.cell_x = count(whole.x);
    layer.cell_y = count(whole.y);
    layer.cell_z = count(whole.z);
    layer.seed = f64::haze_hash(haze.seed * FL_HAZE_LAYERS + i);
    layer.weight = std::pow(kLighter, i) / weights;
  }
  field.noise = haze.noise;
  field.per_height = haze.height_m > 0 ? 1 / haze.height_m : 0;
  return field;
}

f32::HazeField haze_field_in_float(const f64::HazeField& field) {
  f32::HazeField single{};
  for (std::uint32_t i = 0; i < FL_HAZE_LAYERS; ++i) {
    const f64::HazeLayer& layer = field.layers[i];
    single.layers[i] = {.drift = layer.drift,
                        .per_m = static_cast<float>(layer.per_m),
                        .cell_x = layer.cell_x,
                        .cell_y = layer.cell_y,
                        .cell_z = layer.cell_z,
                        .seed = layer.seed,
                        .weight = static_cast<float>(layer.weight),
                        .pad_0 = 0,
                        .pad_1 = 0,
                        .pad_2 = 0};
  }
  single.noise = static_cast<float>(field.noise);
  single.per_height = static_cast<float>(field.per_height);
  single.from_m = static_cast<float>(field.from_m);
  single.length_m = static_cast<float>(field.length_m);
  return single;
}

PlumeField plume_field(std::span<const fixtures::PlumePuff> puffs, double scattering_per_m, std::int64_t time_ns) {
  PlumeField field;
  puffs = puffs.first(std::min(puffs.size(), std::size_t{FL_PUFFS_MAX}));
  f64::HazePlumes& head = field.head;
  head.scattering_per_m = puffs.empty() ? scattering_per_m : std::max(scattering_per_m, kLeastScatteringPerM);
  head.even_share = head.scattering_per_m > 0 ? scattering_per_m / head.scattering_per_m : 1;
  // The lattice of the noise repeats after 32 cubes along the axis, where the noise begins again.
  head.shift_m = std::fmod(f64::kPlumeNoiseMS * (static_cast<double>(time_ns) * 1e-9), 32 * f64::kPlumeCubeM);
  head.count = static_cast<std::uint32_t>(puffs.size());
  for (const fixtures::PlumePuff& puff : puffs) {
    const double volume_m3 = std::pow(2 * std::numbers::pi, 1.5) * puff.across_m * puff.across_m * puff.along_m;
    field.puffs.push_back({.center = puff.center_m,
                           .per_across = 1 / puff.across_m,
                           .axis = puff.axis,
                           .per_along = 1 / puff.along_m,
                           .peak = puff.area_m2 / (volume_m3 * head.scattering_per_m),
                           .plume = puff.plume,
                           .pad_0 = 0,
                           .pad_1 = 0});
  }
  return field;
}

PlumeRows plume_rows(const PlumeField& field) {
  PlumeRows rows;
  rows.head = {static_cast<float>(field.head.even_share), static_cast<float>(field.head.scattering_per_m),
               static_cast<float>(field.head.shift_m), field.head.count};
  for (const f64::HazePuff& puff : field.puffs) {
    rows.puffs.push_back({.center = puff.center,
                          .per_across = static_cast<float>(puff.per_across),
                          .axis = puff.axis,
                          .per_along = static_cast<float>(puff.per_along),
                          .peak = static_cast<float>(puff.peak),
                          .plume = puff.plume,
                          .pad_0 = 0,
                          .pad_1 = 0});
  }
  return rows;
}

HazeReach haze_reach(const fixtures::Rig& rig, double range_m) {
  if (rig.fixtures.empty() && rig.panes.empty() && rig.displays.empty()) return {};
  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high = -low;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    low = glm::min(low, fixture.position_m);
    high = glm::max(high, fixture.position_m);
  }
  for (const fixtures::Pane& pane : rig.panes) {
    const glm::dvec3 radius_m(std::hypot(pane.width_m, pane.height_m) / 2);
    low = glm::min(low, pane.position_m - radius_m);
    high = glm::max(high, pane.position_m + radius_m);
  }
  for (const fixtures::Display& display : rig.displays) {
    const glm::dvec3 radius_m(std::hypot(display.width_m, display.height_m) / 2);
    low = glm::min(low, display.position_m - radius_m);
    high = glm::max(high, display.position_m + radius_m);
  }
  return {0.5 * (low + high), 0.5 * glm::length(high - low) + range_m};
}

}  // namespace footlight::render
