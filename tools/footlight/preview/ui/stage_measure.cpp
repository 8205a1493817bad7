#include "tools/footlight/preview/ui/stage_measure.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fixtures/edit/rig_edits.h"

namespace footlight::tools {

void StageMeasure::click(const glm::dvec3& point_m) {
  if (from_m && !to_m) {
    to_m = point_m;
    return;
  }
  from_m = point_m;
  to_m.reset();
}

std::optional<glm::dvec3> measured_point(const fixtures::Rig& rig, const StagePick& pick, const StagePlace& place,
                                         glm::dvec2 at) {
  constexpr double kMeasureReachM = 1000;
  if (const int fixture = pick.fixture_at(place, at, 0); fixture >= 0) {
    return fixtures::position_of(rig.fixtures[static_cast<std::size_t>(fixture)]);
  }
  return surface_on(rig, ray_through(place, at), kMeasureReachM);
}

std::string text_of_distance(const glm::dvec3& from_m, const glm::dvec3& to_m) {
  const glm::dvec3 by_m = to_m - from_m;
  return fmt::format("{:.2f} m  x {:+.2f}  y {:+.2f}  z {:+.2f}", glm::length(by_m), by_m.x + 0.0, by_m.y + 0.0,
                     by_m.z + 0.0);
}

FloorLines floor_lines(const glm::dvec3& low_m, const glm::dvec3& high_m) {
  constexpr double kAroundM = 2;
  constexpr double kFarM = 1e7;  // beyond what a rig file holds
  FloorLines lines;
  for (; lines.step_m < kFarM; lines.step_m *= 10) {
    bool few = true;
    for (int axis = 0; axis < 2; ++axis) {
      const double low = std::floor((std::max(low_m[axis], -kFarM) - kAroundM) / lines.step_m);
      const double high = std::ceil((std::min(high_m[axis], kFarM) + kAroundM) / lines.step_m);
      few = few && high - low < kFloorLinesMax;
      lines.low[axis] = static_cast<int>(low);
      lines.high[axis] = static_cast<int>(high);
    }
    if (few) break;
  }
  return lines;
}

}  // namespace footlight::tools
