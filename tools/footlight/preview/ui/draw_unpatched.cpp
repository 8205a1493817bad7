#include "tools/footlight/preview/ui/draw_unpatched.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr int kUnpatchedColumns = 32;
constexpr int kUnpatchedRows = kSlotCountMax / kUnpatchedColumns;

double age_s(const UnpatchedUniverse& one, TimeNs now_ns) {
  return static_cast<double>(std::max<DurationNs>(now_ns - one.stamp_ns, 0)) * 1e-9;
}

// The slot under the mouse.
std::optional<std::size_t> draw_slots(const SlotChanges& changes, TimeNs now_ns) {
  const float line = ImGui::GetTextLineHeight();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = std::max(std::floor(room.x / kUnpatchedColumns), 4.0f);
  const float height = std::clamp(std::floor((room.y - 2 * line - 8) / kUnpatchedRows), 5.0f, line * 1.8f);
  ImGui::InvisibleButton("unpatched", {width * kUnpatchedColumns, height * kUnpatchedRows});
  std::optional<std::size_t> under;
  if (ImGui::IsItemHovered()) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const int column = std::clamp(static_cast<int>((mouse.x - at.x) / width), 0, kUnpatchedColumns - 1);
    const int row = std::clamp(static_cast<int>((mouse.y - at.y) / height), 0, kUnpatchedRows - 1);
    under = static_cast<std::size_t>(row * kUnpatchedColumns + column);
  }
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float size = ImGui::GetFontSize() * 0.8f;
  const bool numbers = width >= size * 2 && height >= size;
  for (std::size_t slot = 0; slot < changes.levels.size(); ++slot) {
    const ImVec2 low{at.x + static_cast<float>(slot % kUnpatchedColumns) * width,
                     at.y + static_cast<float>(slot / kUnpatchedColumns) * height};
    const ImVec2 high{low.x + width - 1, low.y + height - 1};
    const std::uint8_t level = changes.levels[slot];
    draw.AddRectFilled(low, high, ImGui::GetColorU32(ui_colours.ground));
    if (level == 0) continue;
    const float top = high.y - (high.y - low.y) * static_cast<float>(level) / 255;
    draw.AddRectFilled({low.x, top}, high,
                       ImGui::GetColorU32(changes.heat(slot, now_ns) > 0 ? ui_colours.hot : ui_colours.bar));
    if (!numbers) continue;
    draw.AddText(ImGui::GetFont(), size, {low.x + 2, low.y + (height - 1 - size) / 2},
                 ImGui::GetColorU32(ImGuiCol_Text), std::to_string(level).c_str());
  }
  return under;
}

}  // namespace

void UnpatchedView::draw_choice(const UiInput& input) {
  if (input.unpatched == nullptr || input.unpatched->empty()) return leave();
  const auto& all = *input.unpatched;
  const std::string label = shown_ ? trf("universe {}: not patched", *shown_)
                                   : trf_n("{} universe arrives that is not patched",
                                           "{} universes arrive that are not patched", all.size(), all.size());
  ImGui::SetNextItemWidth(-1);
  ImGui::PushStyleColor(ImGuiCol_Text, kUiAmber);
  const bool open = ImGui::BeginCombo("##unpatched", label.c_str());
  ImGui::PopStyleColor();
  if (!open) return;
  if (ImGui::Selectable(tr_label("the universes of the rig"), !shown_)) leave();
  for (const UnpatchedUniverse& one : all) {
    const std::string words = trf("universe {}: {}, {:.1f} s ago", one.universe, one.sender, age_s(one, input.now_ns)) +
                              fmt::format("###{}", one.universe);
    if (ImGui::Selectable(words.c_str(), shown_ == one.universe)) {
      shown_ = one.universe;
      fresh_ = true;
    }
  }
  ImGui::EndCombo();
}

void UnpatchedView::draw(const UiInput& input, bool frozen) {
  const auto& all = *input.unpatched;
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const UnpatchedUniverse& one) { return one.universe == *shown_; });
  if (at == all.end()) return ui_text(kUiAmber, trf("universe {} does not arrive any more", *shown_));
  if (fresh_) changes_ = {};
  if (fresh_ || !frozen) changes_.take(at->levels, input.now_ns, fresh_);
  fresh_ = false;
  const double age = age_s(*at, input.now_ns);
  ui_text(age * 1e9 >= static_cast<double>(kSilentNs) ? kUiRed : kUiGreen, trf("last frame {:.1f} s ago", age));
  ImGui::SameLine();
  ui_text(kUiDim, trf("{} (priority {})", at->sender, at->priority));
  const std::size_t slot = draw_slots(changes_, input.now_ns).value_or(0);
  const std::uint8_t level = changes_.levels[slot];
  ui_text(trf("{}.{}  level {} ({:.0f} %)", *shown_, slot + 1, level, level / 2.55));
  ui_text(kUiDim, tr("not patched: no fixture and no display uses this universe"));
}

}  // namespace footlight::tools
