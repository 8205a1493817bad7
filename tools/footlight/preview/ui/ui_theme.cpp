#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

void set_dark(ImVec4* colours) {
  colours[ImGuiCol_PopupBg] = {0.08f, 0.085f, 0.10f, 1};
  colours[ImGuiCol_FrameBg] = {0.12f, 0.13f, 0.15f, 1};
  colours[ImGuiCol_FrameBgHovered] = {0.17f, 0.18f, 0.21f, 1};
  colours[ImGuiCol_FrameBgActive] = {0.20f, 0.21f, 0.24f, 1};
  colours[ImGuiCol_SliderGrab] = {0.38f, 0.26f, 0.10f, 1};  // under the number, which has to be read
  colours[ImGuiCol_SliderGrabActive] = {0.68f, 0.47f, 0.18f, 1};
  colours[ImGuiCol_CheckMark] = {0.95f, 0.66f, 0.25f, 1};
  colours[ImGuiCol_Button] = {0.14f, 0.15f, 0.18f, 1};
  colours[ImGuiCol_ButtonHovered] = {0.21f, 0.22f, 0.26f, 1};
  colours[ImGuiCol_ButtonActive] = {0.30f, 0.25f, 0.17f, 1};
  colours[ImGuiCol_Header] = {0.20f, 0.18f, 0.14f, 1};
  colours[ImGuiCol_HeaderHovered] = {0.26f, 0.23f, 0.17f, 1};
  colours[ImGuiCol_HeaderActive] = {0.30f, 0.25f, 0.17f, 1};
  colours[ImGuiCol_Separator] = {0.16f, 0.17f, 0.20f, 1};
  colours[ImGuiCol_ScrollbarBg] = {0, 0, 0, 0};
  colours[ImGuiCol_TitleBg] = {0.09f, 0.095f, 0.11f, 1};
  colours[ImGuiCol_TitleBgActive] = {0.17f, 0.155f, 0.125f, 1};
  colours[ImGuiCol_MenuBarBg] = {0.09f, 0.095f, 0.11f, 1};
  colours[ImGuiCol_ResizeGrip] = {0.20f, 0.21f, 0.24f, 1};
  colours[ImGuiCol_ResizeGripHovered] = {0.52f, 0.36f, 0.14f, 1};
  colours[ImGuiCol_ResizeGripActive] = {0.68f, 0.47f, 0.18f, 1};
  colours[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.55f};
  colours[ImGuiCol_Tab] = {0.12f, 0.13f, 0.15f, 1};
  colours[ImGuiCol_TabHovered] = {0.30f, 0.25f, 0.17f, 1};
  colours[ImGuiCol_TabActive] = {0.26f, 0.23f, 0.17f, 1};
  colours[ImGuiCol_TextSelectedBg] = {0.52f, 0.36f, 0.14f, 0.6f};
  colours[ImGuiCol_NavHighlight] = {0.95f, 0.66f, 0.25f, 1};
}

void set_light(ImVec4* colours) {
  colours[ImGuiCol_PopupBg] = {0.97f, 0.97f, 0.96f, 1};
  colours[ImGuiCol_FrameBg] = {0.84f, 0.84f, 0.83f, 1};
  colours[ImGuiCol_FrameBgHovered] = {0.79f, 0.79f, 0.78f, 1};
  colours[ImGuiCol_FrameBgActive] = {0.74f, 0.74f, 0.72f, 1};
  colours[ImGuiCol_SliderGrab] = {0.88f, 0.74f, 0.48f, 1};
  colours[ImGuiCol_SliderGrabActive] = {0.68f, 0.47f, 0.14f, 1};
  colours[ImGuiCol_CheckMark] = {0.57f, 0.38f, 0.00f, 1};
  colours[ImGuiCol_Button] = {0.83f, 0.83f, 0.81f, 1};
  colours[ImGuiCol_ButtonHovered] = {0.76f, 0.76f, 0.74f, 1};
  colours[ImGuiCol_ButtonActive] = {0.86f, 0.76f, 0.56f, 1};
  colours[ImGuiCol_Header] = {0.88f, 0.82f, 0.70f, 1};
  colours[ImGuiCol_HeaderHovered] = {0.86f, 0.78f, 0.62f, 1};
  colours[ImGuiCol_HeaderActive] = {0.86f, 0.76f, 0.56f, 1};
  colours[ImGuiCol_Separator] = {0.76f, 0.76f, 0.74f, 1};
  colours[ImGuiCol_ScrollbarBg] = {0, 0, 0, 0};
  colours[ImGuiCol_TitleBg] = {0.85f, 0.85f, 0.84f, 1};
  colours[ImGuiCol_TitleBgActive] = {0.88f, 0.82f, 0.70f, 1};
  colours[ImGuiCol_MenuBarBg] = {0.87f, 0.87f, 0.86f, 1};
  colours[ImGuiCol_TableHeaderBg] = {0.85f, 0.85f, 0.84f, 1};
  colours[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.35f};
  colours[ImGuiCol_Tab] = {0.85f, 0.85f, 0.84f, 1};
  colours[ImGuiCol_TabHovered] = {0.86f, 0.78f, 0.62f, 1};
  colours[ImGuiCol_TabActive] = {0.88f, 0.82f, 0.70f, 1};
  colours[ImGuiCol_TextSelectedBg] = {0.86f, 0.70f, 0.38f, 0.6f};
  colours[ImGuiCol_NavHighlight] = {0.57f, 0.38f, 0.00f, 1};
}

}  // namespace

UiColours colours_of(UiTheme theme) {
  if (theme == UiTheme::kLight) {
    return {.accent = {0.57f, 0.38f, 0.00f, 1},
            .good = {0.00f, 0.40f, 0.36f, 1},
            .bad = {0.46f, 0.02f, 0.02f, 1},
            .dim = {0.38f, 0.38f, 0.38f, 1},
            .text = {0.08f, 0.08f, 0.09f, 1},
            .window = {0.93f, 0.93f, 0.92f, 1},
            .ground = {0.97f, 0.97f, 0.96f, 1},
            .even = {0.87f, 0.88f, 0.90f, 1},
            .odd = {0.81f, 0.82f, 0.85f, 1},
            .bar = {0.45f, 0.68f, 0.86f, 1},
            .hot = {0.95f, 0.66f, 0.20f, 1},
            .differs = {0.65f, 0.20f, 0.55f, 1},
            .line = {0.05f, 0.05f, 0.05f, 1}};
  }
  return {.accent = {0.96f, 0.74f, 0.20f, 1},
          .good = {0.00f, 0.74f, 0.56f, 1},
          .bad = {0.90f, 0.30f, 0.08f, 1},
          .dim = {0.52f, 0.54f, 0.58f, 1},
          .text = {0.86f, 0.87f, 0.89f, 1},
          .window = {0.055f, 0.060f, 0.070f, 1},
          .ground = {0.075f, 0.080f, 0.090f, 1},
          .even = {0.125f, 0.140f, 0.170f, 1},
          .odd = {0.165f, 0.175f, 0.200f, 1},
          .bar = {0.00f, 0.36f, 0.60f, 1},
          .hot = {0.90f, 0.56f, 0.16f, 1},
          .differs = {0.90f, 0.55f, 0.78f, 1},
          .line = {1, 1, 1, 1}};
}

const ImWchar* ui_glyph_ranges() {
  static constexpr ImWchar kRanges[] = {
      0x0020, 0x00ff,  // Basic Latin, Latin-1
      0x0100, 0x017f,  // Latin Extended-A
      0x0370, 0x052f,  // Greek, Cyrillic
      0x2010, 0x2026,  // dashes, quotation marks, ellipsis
      0,
  };
  return kRanges;
}

void set_ui_style(float scale, UiTheme theme) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();  // sizes are not scaled twice
  if (theme == UiTheme::kLight) {
    ImGui::StyleColorsLight();
  } else {
    ImGui::StyleColorsDark();
  }
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {8, 3};
  style.GrabMinSize = 10;
  style.ScrollbarSize = 9;
  ui_colours = colours_of(theme);
  ImVec4* colours = style.Colors;
  colours[ImGuiCol_Text] = ui_colours.text;
  colours[ImGuiCol_TextDisabled] = ui_colours.dim;
  colours[ImGuiCol_WindowBg] = ui_colours.window;
  if (theme == UiTheme::kLight) {
    set_light(colours);
  } else {
    set_dark(colours);
  }
  style.ScaleAllSizes(scale);
}

}  // namespace footlight::tools
