// Distances between two points of the stage that are clicked, and lines on its floor. No Dear ImGui; draw_measure.h
// draws them.
#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/stage_rays.h"

namespace footlight::tools {

struct StageMeasure {
  bool on = false;  // clicks measure, and do not select
  std::optional<glm::dvec3> from_m;
  std::optional<glm::dvec3> to_m;

  // The first point, the second one, or the first one of the next measurement.
  void click(const glm::dvec3& point_m);
};

// The hanging point of the fixture under the mouse, else where the ray meets the floor or a box within 1 km.
[[nodiscard]] std::optional<glm::dvec3> measured_point(const fixtures::Rig& rig, const StagePick& pick,
                                                       const StagePlace& place, glm::dvec2 at);
// "2.24 m  x +1.00  y +2.00  z +0.00"
[[nodiscard]] std::string text_of_distance(const glm::dvec3& from_m, const glm::dvec3& to_m);

// Lines at multiples of step_m: 1 m, or 10, 100 ... m where more than kFloorLinesMax would be needed in a direction.
inline constexpr int kFloorLinesMax = 120;
struct FloorLines {
  double step_m = 1;
  glm::ivec2 low{0};  // in steps
  glm::ivec2 high{0};
};
// Around these places, with 2 m on each side.
[[nodiscard]] FloorLines floor_lines(const glm::dvec3& low_m, const glm::dvec3& high_m);

}  // namespace footlight::tools
