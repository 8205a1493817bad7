// Dear ImGui without a window: it makes the lists that a GPU would draw.
#pragma once

#include <initializer_list>
#include <string>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

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

// The next frame presses the widget with this id, wherever it is: a button, a box or a row of a list. path: the texts
// of PushID() around it, then its own.
inline void activate(const char* window, std::initializer_list<const char*> path) {
  const ImGuiWindow* found = ImGui::FindWindowByName(window);
  IM_ASSERT(found != nullptr);
  ImGuiID id = found->ID;
  for (const char* part : path) id = ImHashStr(part, 0, id);
  ImGui::ActivateItem(id);
}

// A user interface that a test draws and clicks.
class DrawnUi {
 public:
  virtual ~DrawnUi() = default;
  // One frame.
  void frame() {
    ImGui::NewFrame();
    if (logs_) ImGui::LogToClipboard();
    draw();
    if (logs_) ImGui::LogFinish();
    ImGui::Render();
  }
  std::string words() {
    logs_ = true;
    frame();
    logs_ = false;
    return ImGui::GetClipboardText();
  }
  void press(float x, float y, int button = 0) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {x, y};
    frame();
    io.MouseDown[button] = true;
    frame();
    io.MouseDown[button] = false;
    frame();
  }

 private:
  virtual void draw() = 0;

  bool logs_ = false;  // into the clipboard
};

}  // namespace footlight::testing
