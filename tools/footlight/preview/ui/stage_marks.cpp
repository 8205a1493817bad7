#include "tools/footlight/preview/ui/stage_marks.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kNamesMax = 24;  // with more of them selected, names would hide the picture
constexpr float kSmallestUnits = 10;

ImVec2 units_of(glm::dvec2 at) { return {static_cast<float>(at.x), static_cast<float>(at.y)}; }

// The four corners of a rectangle.
void draw_corners(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float width) {
  const float arm = std::max(std::min(high.x - low.x, high.y - low.y) * 0.3f, 3.0f);
  for (int corner = 0; corner < 4; ++corner) {
    const bool right = (corner & 1) != 0;
    const bool down = (corner & 2) != 0;
    const ImVec2 at{right ? high.x : low.x, down ? high.y : low.y};
    const float along = right ? -arm : arm;
    const float up = down ? -arm : arm;
    draw.AddLine(at, {at.x + along, at.y}, colour, width);
    draw.AddLine(at, {at.x, at.y + up}, colour, width);
  }
}

}  // namespace

void draw_marks(const fixtures::Rig& rig, const StagePick& pick, const StagePlace& place, const Selection& selection,
                float scale) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.PushClipRect(units_of(place.origin), units_of(place.end()));
  const ImU32 shade = IM_COL32(0, 0, 0, 160);
  const bool names = selection.fixtures.size() <= kNamesMax;
  for (std::size_t i = 0; i < std::min(selection.fixtures.size(), kMarksMax); ++i) {
    const int fixture = selection.fixtures[i];
    const auto mark = pick.mark_of(place, fixture);
    if (!mark) continue;
    const glm::dvec2 middle = (mark->low + mark->high) / 2.0;
    const glm::dvec2 half =
        glm::max((mark->high - mark->low) / 2.0, glm::dvec2(static_cast<double>(kSmallestUnits * scale / 2)));
    const ImVec2 low(static_cast<float>(middle.x - half.x) - 2, static_cast<float>(middle.y - half.y) - 2);
    const ImVec2 high(static_cast<float>(middle.x + half.x) + 2, static_cast<float>(middle.y + half.y) + 2);
    const bool lead = fixture == selection.lead;
    const ImU32 colour = ImGui::GetColorU32(lead ? kStageColours.accent : ImVec4{0.85f, 0.86f, 0.88f, 0.9f});
    draw_corners(draw, {low.x + 1, low.y + 1}, {high.x + 1, high.y + 1}, shade, 2 * scale);
    draw_corners(draw, low, high, colour, 1.5f * scale);
    if (!names) continue;
    const std::string& name = rig.fixtures[static_cast<std::size_t>(fixture)].name;
    const ImVec2 needed = ImGui::CalcTextSize(name.c_str());
    const ImVec2 at((low.x + high.x - needed.x) / 2, high.y + 2);
    draw.AddText({at.x + 1, at.y + 1}, shade, name.c_str());
    draw.AddText(at, colour, name.c_str());
  }
  draw.PopClipRect();
}

void draw_box(const StageBox& box, float scale) {
  if (!box.dragging()) return;
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const ImVec2 low(static_cast<float>(box.low().x), static_cast<float>(box.low().y));
  const ImVec2 high(static_cast<float>(box.high().x), static_cast<float>(box.high().y));
  const ImVec4& colour = box.mode() == BoxMode::kTakesAway ? kStageColours.bad : kStageColours.accent;
  draw.AddRectFilled(low, high, ImGui::GetColorU32({colour.x, colour.y, colour.z, 0.14f}));
  draw.AddRect(low, high, ImGui::GetColorU32(colour), 0, 0, 1.5f * scale);
  const char* words = box.mode() == BoxMode::kAdds        ? tr("add")
                      : box.mode() == BoxMode::kTakesAway ? tr("take away")
                                                          : tr("select");
  draw.AddText({high.x + 4 * scale, high.y + 2 * scale}, ImGui::GetColorU32(colour), words);
}

void draw_fly(const FlyCamera& fly, const StagePlace& place, float scale) {
  if (!fly.on()) return;
  const std::string words =
      trf("FLY {:.1f} m/s   W A S D, E up, Q down, Shift: faster   drag: look   wheel: speed   V or Esc: end",
          fly.speed_m_s());
  const float width = static_cast<float>(place.size.x) - 24 * scale;
  const ImVec2 needed = ImGui::CalcTextSize(words.c_str(), nullptr, false, std::max(width, 40.0f));
  const ImVec2 low = units_of(place.origin);
  const ImVec2 at(low.x + (static_cast<float>(place.size.x) - needed.x) / 2,
                  low.y + static_cast<float>(place.size.y) - needed.y - 36 * scale);
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.AddRectFilled({at.x - 8 * scale, at.y - 4 * scale}, {at.x + needed.x + 8 * scale, at.y + needed.y + 4 * scale},
                     IM_COL32(0, 0, 0, 170), 3 * scale);
  draw.AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, ImGui::GetColorU32(kStageColours.accent), words.c_str(),
               nullptr, std::max(width, 40.0f));
}

}  // namespace footlight::tools
