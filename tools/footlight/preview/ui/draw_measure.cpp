#include "tools/footlight/preview/ui/draw_measure.h"

#include <fmt/format.h>

#include "tools/footlight/preview/ui/draw_handles.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr ImU32 kMeasureColour = IM_COL32(120, 230, 255, 255);

ImVec2 spot_of(glm::dvec2 at) { return {static_cast<float>(at.x), static_cast<float>(at.y)}; }

void draw_point(ImDrawList& draw, const StagePlace& place, const glm::dvec3& point_m, float scale) {
  const auto at = projected(place, point_m);
  if (!at) return;
  draw.AddCircleFilled(spot_of(*at), 5 * scale, IM_COL32(0, 0, 0, 150));
  draw.AddCircleFilled(spot_of(*at), 3 * scale, kMeasureColour);
}

}  // namespace

void draw_measure(const StageMeasure& measure, const std::optional<glm::dvec3>& under_m, const StagePlace& place,
                  float scale) {
  if (!measure.on) return;
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.PushClipRect(spot_of(place.origin), spot_of(place.end()));
  const std::optional<glm::dvec3>& end_m = measure.to_m ? measure.to_m : under_m;
  if (measure.from_m && end_m) {
    draw_stage_line(draw, place, *measure.from_m, *end_m, IM_COL32(0, 0, 0, 150), 4 * scale);
    draw_stage_line(draw, place, *measure.from_m, *end_m, kMeasureColour, 2 * scale);
  }
  for (const auto& point_m : {measure.from_m, end_m}) {
    if (point_m) draw_point(draw, place, *point_m, scale);
  }
  draw.PopClipRect();
  if (!measure.from_m) {
    draw_stage_text(*ImGui::GetForegroundDrawList(), place, place.origin + glm::dvec2(place.size.x / 2, 0),
                    tr("measure: click two points (Esc ends)"), scale);
  } else if (end_m) {
    if (const auto at = projected(place, *end_m)) {
      draw_stage_text(*ImGui::GetForegroundDrawList(), place, *at, text_of_distance(*measure.from_m, *end_m), scale);
    }
  }
}

void draw_floor_lines(const FloorLines& lines, const StagePlace& place, float scale) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.PushClipRect(spot_of(place.origin), spot_of(place.end()));
  for (int axis = 0; axis < 2; ++axis) {
    const int other = 1 - axis;
    for (int i = lines.low[axis]; i <= lines.high[axis]; ++i) {
      glm::dvec3 from_m(0);
      glm::dvec3 to_m(0);
      from_m[axis] = to_m[axis] = i * lines.step_m;
      from_m[other] = lines.low[other] * lines.step_m;
      to_m[other] = lines.high[other] * lines.step_m;
      // The line x = 0 is the axis Y.
      const ImU32 colour = i != 0      ? IM_COL32(255, 255, 255, i % 5 == 0 ? 90 : 40)
                           : axis == 0 ? IM_COL32(104, 204, 104, 200)
                                       : IM_COL32(240, 84, 80, 200);
      draw_stage_line(draw, place, from_m, to_m, colour, scale);
      if (i % 5 != 0) continue;
      if (const auto at = projected(place, from_m)) {
        draw.AddText(spot_of(*at), IM_COL32(255, 255, 255, 150), fmt::format("{:g}", i * lines.step_m).c_str());
      }
    }
  }
  draw.PopClipRect();
}

}  // namespace footlight::tools
