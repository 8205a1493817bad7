#include "tools/footlight/preview/ui/palette.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr const char* kPalettePopup = "actions";
constexpr float kPaletteWidth = 560;
constexpr std::size_t kPaletteRows = 14;

bool pressed(ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); }

}  // namespace

void Palette::search(const UiDesk& desk, bool has_log, const OutputsView* outputs) {
  const std::string words = small_letters(text_.data());
  rows_ = action_items(desk, has_log, outputs);
  std::erase_if(rows_, [&](const UiActionItem& item) {
    return item.call.action == UiAction::kPalette || !has_words(small_letters(item.label + " " + item.keys), words);
  });
}

// Marks the next row that can be run; step 0: this one, or the next below.
void Palette::mark_next(int step) {
  for (std::size_t tries = 0; tries < rows_.size(); ++tries) {
    const auto count = static_cast<long long>(rows_.size());
    const long long next = static_cast<long long>(marked_) + (tries == 0 ? step : step < 0 ? -1 : 1);
    marked_ = static_cast<std::size_t>((next + count) % count);
    if (rows_[marked_].possible()) return;
  }
}

std::optional<UiCall> Palette::draw_rows(bool entered, bool scrolls, float scale) {
  std::optional<UiCall> chosen;
  const std::size_t shown = std::clamp<std::size_t>(rows_.size(), 1, kPaletteRows);
  const float height = static_cast<float>(shown) * ImGui::GetTextLineHeightWithSpacing();
  if (ImGui::BeginChild("rows", {0, height})) {
    float keys_width = 150 * scale;
    for (const UiActionItem& row : rows_) {
      keys_width = std::max(keys_width, ImGui::CalcTextSize(row.keys.c_str()).x + ImGui::GetFontSize());
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const UiActionItem& row = rows_[i];
      ImGui::PushID(static_cast<int>(i));
      const ImGuiSelectableFlags flags = row.possible() ? 0 : ImGuiSelectableFlags_Disabled;
      if (ImGui::Selectable("##row", i == marked_ && row.possible(), flags)) chosen = row.call;
      if (i == marked_ && scrolls) ImGui::SetScrollHereY();
      ImGui::SameLine(0, 0);
      ui_text(row.possible() ? kUiAmber : kUiDim, row.keys);
      ImGui::SameLine(keys_width);
      const std::string words = row.possible() ? row.label : fmt::format("{} - {}", row.label, row.why_not);
      const float right = ImGui::GetCursorPosX() + ImGui::CalcTextSize(words.c_str()).x;
      ui_text(row.possible() ? kUiText : kUiDim, words);
      if (right > ImGui::GetWindowContentRegionMax().x && ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%s", words.c_str());  // what is cut off
      }
      ImGui::PopID();
    }
    if (rows_.empty()) ui_text(kUiDim, tr("No action has these words."));
  }
  ImGui::EndChild();
  if (entered && marked_ < rows_.size() && rows_[marked_].possible()) chosen = rows_[marked_].call;
  return chosen;
}

std::optional<UiCall> Palette::draw(const UiDesk& desk, bool has_log, const OutputsView* outputs, float scale) {
  const bool begins = std::exchange(opens_, false);
  if (begins) {
    text_.fill(0);
    marked_ = 0;
    ImGui::OpenPopup(kPalettePopup);
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y * 0.12f}, ImGuiCond_Always, {0.5f, 0});
  ImGui::SetNextWindowSize({std::min(kPaletteWidth * scale, std::max(size.x - 16, 1.0f)), 0});
  shown_ = ImGui::BeginPopup(kPalettePopup);
  if (!shown_) return std::nullopt;
  std::optional<UiCall> chosen;
  if (begins) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue;
  const bool entered =
      ImGui::InputTextWithHint("##words", tr("words of an action"), text_.data(), text_.size(), kFlags);
  const bool edited = ImGui::IsItemEdited();
  search(desk, has_log, outputs);
  if (edited || begins) marked_ = 0;
  marked_ = std::min(marked_, rows_.empty() ? 0 : rows_.size() - 1);
  const int step = pressed(ImGuiKey_DownArrow) ? 1 : pressed(ImGuiKey_UpArrow) ? -1 : 0;
  mark_next(step);
  chosen = draw_rows(entered, step != 0 || edited, scale);
  if (chosen || pressed(ImGuiKey_Escape)) {
    ImGui::CloseCurrentPopup();
  } else if (entered) {
    ImGui::SetKeyboardFocusHere(-1);  // Enter that runs nothing leaves the field open
  }
  ImGui::EndPopup();
  return chosen;
}

}  // namespace footlight::tools
