// Colours and small pieces of text that all panels of the window share. Dear ImGui only.
#pragma once

#include <string>
#include <string_view>

#include <imgui/imgui.h>

namespace footlight::tools {

inline const ImVec4 kUiAmber{0.95f, 0.66f, 0.25f, 1};
inline const ImVec4 kUiGreen{0.42f, 0.78f, 0.48f, 1};
inline const ImVec4 kUiRed{0.93f, 0.36f, 0.33f, 1};
inline const ImVec4 kUiDim{0.50f, 0.52f, 0.56f, 1};

// A dark theme: few colours, no borders, small spacing. Of the current context.
void set_ui_style(float scale);

inline void ui_text(std::string_view words) { ImGui::TextUnformatted(words.data(), words.data() + words.size()); }
inline void ui_text(const ImVec4& colour, std::string_view words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ui_text(words);
  ImGui::PopStyleColor();
}

// A text as a format string of ImGui.
[[nodiscard]] inline std::string ui_format(std::string_view words) {
  std::string format;
  for (const char c : words) format += c == '%' ? std::string("%%") : std::string(1, c);
  return format;
}

}  // namespace footlight::tools
