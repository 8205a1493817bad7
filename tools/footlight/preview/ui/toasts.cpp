#include "tools/footlight/preview/ui/toasts.h"

#include <algorithm>
#include <string>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

void draw_toasts(const MessageLog& log, TimeNs now_ns, const ImVec2& stage, float scale) {
  // Buttons of a dialog may be where the boxes are: it lies over them.
  const bool dialog = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
  ImDrawList& draw = dialog ? *ImGui::GetBackgroundDrawList() : *ImGui::GetForegroundDrawList();
  const float left = 12 * scale;
  const float pad = 6 * scale;
  const float width = std::max(stage.x - 2 * left - 2 * pad, 40.0f);
  float bottom = stage.y - 36 * scale;
  const auto shown = log.shown(now_ns);
  for (auto at = shown.rbegin(); at != shown.rend(); ++at) {
    const Message& message = **at;
    const std::string text = text_of(message) + (message.wrong ? tr("  (F8 keeps it)") : "");
    const ImVec2 needed = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
    const ImVec2 low{left, bottom - needed.y - 2 * pad};
    if (low.y < 0) break;  // no room; the panel has it
    const ImVec2 high{left + needed.x + 2 * pad, bottom};
    draw.AddRectFilled(low, high, IM_COL32(14, 15, 18, 235), 3);
    if (message.wrong) draw.AddRectFilled(low, {low.x + 3 * scale, high.y}, ImGui::GetColorU32(kStageColours.bad), 3);
    draw.AddText(ImGui::GetFont(), ImGui::GetFontSize(), {low.x + pad, low.y + pad},
                 ImGui::GetColorU32(message.wrong ? kStageColours.bad : kStageColours.text), text.c_str(), nullptr,
                 width);
    bottom = low.y - 4 * scale;
  }
}

}  // namespace footlight::tools
