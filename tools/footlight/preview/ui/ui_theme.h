// Colours and small pieces of text that all panels of the window share. Dear ImGui only.
//
// States are told apart by colours of Okabe and Ito (Color Universal Design, 2008), which differ also for people with
// protanopia, deuteranopia or tritanopia; a light theme has darker ones of the same hues. A test computes both.
#pragma once

#include <string>
#include <string_view>

#include <imgui/imgui.h>

#include "tools/footlight/preview/window_settings.h"

namespace footlight::tools {

struct UiColours {
  ImVec4 accent;  // headings, keys, what is selected, warnings
  ImVec4 good;    // works; was taken over
  ImVec4 bad;     // gone, errors, live to real lamps
  ImVec4 dim;     // what matters less
  ImVec4 text;
  ImVec4 window;  // the ground of panels
  // Of grids and curves.
  ImVec4 ground;
  ImVec4 even;
  ImVec4 odd;
  ImVec4 bar;
  ImVec4 hot;      // of a bar that has just changed
  ImVec4 differs;  // from a kept moment
  ImVec4 line;     // before bars
};
[[nodiscard]] UiColours colours_of(UiTheme theme);

// Those of the current theme: set_ui_style() changes them, and what follows.
inline UiColours ui_colours = colours_of(UiTheme::kDark);
inline const ImVec4& kUiAmber = ui_colours.accent;
inline const ImVec4& kUiGreen = ui_colours.good;
inline const ImVec4& kUiRed = ui_colours.bad;
inline const ImVec4& kUiDim = ui_colours.dim;
inline const ImVec4& kUiText = ui_colours.text;

// Over the picture, which is dark in every theme.
inline const UiColours kStageColours = colours_of(UiTheme::kDark);

// Of the band and the frame while outputs are live, with black or white text: the same in every theme.
inline constexpr ImU32 kLiveColour = IM_COL32(214, 28, 28, 255);
inline constexpr ImU32 kMadeUpColour = IM_COL32(242, 169, 64, 255);

// Of the font: Latin with the letters of Europe, Greek and Cyrillic, for the words of a language and for names in rigs.
[[nodiscard]] const ImWchar* ui_glyph_ranges();

// Few colours, no borders, small spacing. Of the current context.
void set_ui_style(float scale, UiTheme theme = UiTheme::kDark);

inline void ui_text(std::string_view words) { ImGui::TextUnformatted(words.data(), words.data() + words.size()); }
inline void ui_text(const ImVec4& colour, std::string_view words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ui_text(words);
  ImGui::PopStyleColor();
}

// The next item follows on the line if it fits: a button or text with these words, whose label may have a part from
// "##" on. has_box: a check box before the words.
inline void ui_same_line_for(const char* words, bool has_box = false, float spacing_px = -1) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float beside = has_box ? ImGui::GetFrameHeight() + style.ItemInnerSpacing.x : 2 * style.FramePadding.x;
  const float width = ImGui::CalcTextSize(words, nullptr, true).x + beside;
  ImGui::SameLine(0, spacing_px);
  if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

// On several lines where it is too long for one.
inline void ui_wrapped(const ImVec4& colour, std::string_view words) {
  ImGui::PushTextWrapPos(0);
  ui_text(colour, words);
  ImGui::PopTextWrapPos();
}

// A text as a format string of ImGui.
[[nodiscard]] inline std::string ui_format(std::string_view words) {
  std::string format;
  for (const char c : words) format += c == '%' ? std::string("%%") : std::string(1, c);
  return format;
}

}  // namespace footlight::tools
