#include "tools/footlight/preview/fly_camera.h"

#include <algorithm>
#include <cmath>

namespace footlight::tools {
namespace {

struct SideRow {
  const char* name;
  glm::dvec3 way;  // of the line of sight
  double fov_deg;
};
// The plan has a long lens, so that what hangs high is little beside what stands below it. Haze hides what is far away,
// so it is not longer.
constexpr SideRow kSides[kViewSides] = {
    {"front of house", {0, 1, -0.14}, 40},  {"from above", {0, 1, -1.4}, 40}, {"from the left", {1, 0, -0.05}, 40},
    {"from the right", {-1, 0, -0.05}, 40}, {"stage plan", {0, 0, -1}, 25},
};
const SideRow& row_of(ViewSide side) { return kSides[static_cast<std::size_t>(side)]; }

}  // namespace

void FlyCamera::change_speed(double steps) {
  if (!std::isfinite(steps)) return;
  speed_m_s_ = std::clamp(speed_m_s_ * std::pow(1.25, steps), kSpeedMinMS, kSpeedMaxMS);
}

bool FlyCamera::step(OrbitCamera& camera, const FlyKeys& keys, DurationNs dt_ns) {
  begins_ = false;
  const auto axis = [](bool more, bool less) { return (more ? 1.0 : 0.0) - (less ? 1.0 : 0.0); };
  const glm::dvec3 way(axis(keys.right, keys.left), axis(keys.ahead, keys.back), axis(keys.up, keys.down));
  if (!on_ || way == glm::dvec3(0)) {
    moves_ = false;
    return false;
  }
  begins_ = !moves_;
  moves_ = true;
  const double time_s = static_cast<double>(std::clamp<DurationNs>(dt_ns, 0, kStepMaxNs)) * 1e-9;
  const double way_m = speed_m_s_ * (keys.fast ? kFastFactor : 1) * time_s / glm::length(way);
  camera.fly(way.x * way_m, way.y * way_m, way.z * way_m);
  return true;
}

std::string_view name_of(ViewSide side) { return row_of(side).name; }

OrbitCamera view_from(ViewSide side, const Bounds& bounds, double aspect, const OrbitCamera& now) {
  const SideRow& row = row_of(side);
  fixtures::Camera camera = now.camera();
  camera.name = row.name;
  camera.fov_deg = row.fov_deg;
  camera.target_m = (bounds.low_m + bounds.high_m) / 2.0;
  camera.position_m = camera.target_m - row.way;
  OrbitCamera view(camera);
  view.frame(bounds.low_m, bounds.high_m, aspect);
  return view;
}

}  // namespace footlight::tools
