// Draws what is measured, and lines on the floor, over the picture. Dear ImGui only.
#pragma once

#include <optional>

#include "tools/footlight/preview/ui/stage_measure.h"

namespace footlight::tools {

// under_m: the point under the mouse, to which the line leads until the second click.
void draw_measure(const StageMeasure& measure, const std::optional<glm::dvec3>& under_m, const StagePlace& place,
                  float scale);
void draw_floor_lines(const FloorLines& lines, const StagePlace& place, float scale);

}  // namespace footlight::tools
