// Draws the handles of the selected fixtures over the picture. Dear ImGui only.
#pragma once

#include <string>

#include <glm/glm.hpp>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/stage_handles.h"
#include "tools/footlight/preview/ui/stage_pick.h"

namespace footlight::tools {

// Under the panels. While fixtures are dragged, boxes are where they would be: of at most 100 fixtures.
void draw_handles(const StageHandles& handles, const UiDesk& desk, const StagePick& pick, const StagePlace& place,
                  float scale);

// A line between two points of the stage, the part of it that is in front of the camera.
void draw_stage_line(ImDrawList& draw, const StagePlace& place, const glm::dvec3& from_m, const glm::dvec3& to_m,
                     unsigned colour, float width);
// A text with a dark ground, beside a point of the picture and within it.
void draw_stage_text(ImDrawList& draw, const StagePlace& place, glm::dvec2 at, const std::string& words, float scale);

}  // namespace footlight::tools
