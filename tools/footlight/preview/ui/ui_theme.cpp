#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {

void set_ui_style(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {8, 3};
  style.GrabMinSize = 10;
  style.ScrollbarSize = 9;
  ImVec4* colours = style.Colors;
  colours[ImGuiCol_Text] = {0.86f, 0.87f, 0.89f, 1};
  colours[ImGuiCol_TextDisabled] = {0.50f, 0.52f, 0.56f, 1};
  colours[ImGuiCol_WindowBg] = {0.055f, 0.060f, 0.070f, 1};
  colours[ImGuiCol_PopupBg] = {0.08f, 0.085f, 0.10f, 1};
  colours[ImGuiCol_FrameBg] = {0.12f, 0.13f, 0.15f, 1};
  colours[ImGuiCol_FrameBgHovered] = {0.17f, 0.18f, 0.21f, 1};
  colours[ImGuiCol_FrameBgActive] = {0.20f, 0.21f, 0.24f, 1};
  colours[ImGuiCol_SliderGrab] = {0.52f, 0.36f, 0.14f, 1};
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
  style.ScaleAllSizes(scale);
}

}  // namespace footlight::tools
