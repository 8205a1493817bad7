// Panels over a rig that can be edited, with a mouse and a keyboard and without a window.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include "tests/tools/footlight/edit_desk.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/questions.h"

namespace footlight::testing {

inline constexpr int kDown = 1;
inline constexpr int kUp = 2;
inline constexpr int kEnter = 13;
inline constexpr int kEscape = 27;

// A user interface with a mouse and a keyboard, over a rig that can be edited.
class EditUi : public DrawnUi {
 public:
  explicit EditUi(fixtures::Rig rig) : edit(std::move(rig)), desk(edit.desk) {
    ImGuiIO& io = ImGui::GetIO();
    io.KeyMap[ImGuiKey_Enter] = kEnter;
    io.KeyMap[ImGuiKey_Escape] = kEscape;
    io.KeyMap[ImGuiKey_DownArrow] = kDown;
    io.KeyMap[ImGuiKey_UpArrow] = kUp;
  }

  void draw() override {
    const std::vector<std::uint8_t> levels(desk.compiled().universes.size() * kSlotCountMax);
    tools::UiInput input;
    input.levels = levels;
    input.now_ns = now_ns += kNsPerS / 60;
    open.draw(desk, input, 1280, 720);
    if (asks) answer = question.draw("/shows/club.toml", "");
    if (more) more();
  }
  void show(std::size_t panel) {
    open.set_open(panel, true, desk);
    for (int i = 0; i < 3; ++i) frame();
  }
  void pause() {
    for (int i = 0; i < 60; ++i) frame();  // clicks after it do not count as double clicks
  }
  void twice(float x, float y) {
    pause();
    press(x, y);
    press(x, y);
    frame();
  }
  // Over what is in the field, which is selected.
  void type(const std::string& text) {
    for (int i = 0; i < 3; ++i) frame();
    for (const char c : text) ImGui::GetIO().AddInputCharacter(static_cast<unsigned>(c));
    frame();
    hit(kEnter);
  }
  void hit(int key) {
    ImGui::GetIO().KeysDown[key] = true;
    frame();
    ImGui::GetIO().KeysDown[key] = false;
    frame();
  }
  // Where a click selects a fixture of the patch; a negative place if there is none.
  ImVec2 row_of(int fixture, float x) {
    for (float y = 78; y < 420; y += 4) {  // below the headings
      pause();
      press(x, y);
      if (desk.state().selection.lead == fixture) return {x, y + 2};
    }
    return {-1, -1};
  }
  // A click in the middle of each line down a column until `done`; where it was, a negative place if nowhere.
  template <class Done>
  ImVec2 click_down(float x, float from_y, float to_y, Done done) {
    for (float y = from_y; y < to_y; y += 6) {
      pause();
      press(x, y);
      if (done()) return {x, y};
    }
    return {-1, -1};
  }
  static bool has_popup() { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel); }

  HeadlessImGui imgui{1280, 720};
  EditDesk edit;
  tools::UiDesk& desk;
  tools::UiPanels open;
  bool asks = false;
  std::function<void()> more;  // draws more than panels
  tools::CloseQuestion question;
  std::optional<tools::CloseAnswer> answer;
  TimeNs now_ns = kNsPerS;
};

}  // namespace footlight::testing
