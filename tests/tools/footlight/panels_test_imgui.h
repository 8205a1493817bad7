// Dear ImGui without a window: it makes the lists that a GPU would draw.
#pragma once

#include <imgui/imgui.h>

namespace footlight::testing {

class HeadlessImGui {
 public:
  HeadlessImGui(float width, float height) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.ConfigWindowsMoveFromTitleBarOnly = true;
    io.DisplaySize = {width, height};
    io.DeltaTime = 1.0f / 60;
    unsigned char* pixels = nullptr;
    int unused = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &unused, &unused);
  }
  ~HeadlessImGui() { ImGui::DestroyContext(); }
  HeadlessImGui(const HeadlessImGui&) = delete;
  HeadlessImGui& operator=(const HeadlessImGui&) = delete;
};

}  // namespace footlight::testing
