// The panel beside the picture without a window: what its controls ask for.
#include <algorithm>
#include <string>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/side_panel_ui.h"
#include "tests/tools/footlight/ui_rigs.h"

namespace footlight::tools {
namespace {

class SidePanel : public testing::SidePanelUi {
 public:
  SidePanel() : SidePanelUi(1280, 900) {
    facts.cameras = {"stalls", "wings"};
    facts.can_edit = facts.can_haze = true;
    facts.room_haze_per_m = 0.02;
    for (int i = 0; i < 3; ++i) frame();
  }
  // Presses down the panel until `done`.
  template <class Done>
  bool press_down(float x, int button, Done done) {
    for (float y = 30; y < 900; y += 5) {
      press(x, y, button);
      if (done()) return true;
    }
    return false;
  }
  static bool has_popup() { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel); }
};

TEST_CASE("the menu of a camera stores the view there, and deletes it") {
  SidePanel ui;
  for (const auto what : {CameraRequest::What::kStore, CameraRequest::What::kDelete}) {
    REQUIRE(ui.press_down(1060, 1, [] { return SidePanel::has_popup(); }));
    const ImVec2 at = ImGui::GetIO().MousePos;
    for (float y = at.y; y < at.y + 90 && !(ui.controls.camera_request && ui.controls.camera_request->what == what);
         y += 4) {
      if (!SidePanel::has_popup()) ui.press(at.x, at.y, 1);
      ui.controls.camera_request.reset();
      ui.press(at.x + 30, y);
    }
    REQUIRE(ui.controls.camera_request);
    CHECK(ui.controls.camera_request->index == 0);
    ui.controls.camera_request.reset();
    for (int i = 0; i < 3; ++i) ui.frame();
  }
}

TEST_CASE("the haze slider asks for a value in 1/m, and there is none in a rig without haze") {
  SidePanel ui;
  CHECK(ui.words().find("0.0200 /m") != std::string::npos);
  CHECK(ui.press_down(1240, 0, [&] { return ui.controls.haze_per_m.has_value(); }));
  CHECK(*ui.controls.haze_per_m > 0.02);
  CHECK(*ui.controls.haze_per_m <= 1);
  ui.facts.can_haze = false;
  CHECK(ui.words().find("0.0200 /m") == std::string::npos);
}

TEST_CASE("an error or a time is asked for at the release of its slider") {
  SidePanel ui;
  ui.facts.quality.ms = 16;
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(ui.words().find("16.0 ms a picture") != std::string::npos);
  bool held = false;
  for (float y = 200; y < 900 && !ui.controls.quality; y += 5) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {1255, y};
    ui.frame();
    io.MouseDown[0] = true;
    ui.frame();
    held = held || ui.controls.quality.has_value();
    io.MousePos.x = 1262;
    ui.frame();
    held = held || ui.controls.quality.has_value();
    io.MouseDown[0] = false;
    ui.frame();
  }
  CHECK(!held);
  REQUIRE(ui.controls.quality);
  CHECK(ui.controls.quality->ms > 16);
  CHECK(ui.controls.quality->error == 0);
  ui.facts.quality = {.error = 0.001};
  CHECK(ui.words().find("for an error") != std::string::npos);
  ui.facts.measures_knobs = true;
  CHECK(ui.words().find("measuring this machine") != std::string::npos);
}

TEST_CASE("the mode of harmful flashes is shown, and each mode is followed by another one") {
  SidePanel ui;
  for (const FlashMode mode : kFlashModes) {
    ui.facts.flashes = mode;
    CHECK(ui.words().find(std::string("harmful flashes: ") + word_of(mode)) != std::string::npos);
    CHECK(flash_mode_of(word_of(mode)) == mode);
    CHECK(next_of(next_of(next_of(mode))) == mode);
    CHECK(next_of(mode) != mode);
  }
}

TEST_CASE("a locked window has faders that no click moves, and says how it is unlocked") {
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  HandLevels hand(rig.rig, rig.compiled);
  testing::SidePanelUi ui(1280, 720);
  ui.hand = &hand;
  ui.controls.hand_fixture = 0;
  for (const auto& fixture : rig.rig.fixtures) ui.facts.fixtures.push_back(fixture.name);
  const std::vector<std::uint8_t> before(hand.levels().begin(), hand.levels().end());
  const auto moves = [&] {
    for (float y = 60; y < 400; y += 6) {
      ui.press(1200, y);
      if (!std::equal(before.begin(), before.end(), hand.levels().begin())) return true;
    }
    return false;
  };
  ui.facts.locked = true;
  CHECK(!moves());
  CHECK(ui.words().find("Ctrl+Shift+L unlocks") != std::string::npos);
  ui.facts.locked = false;
  CHECK(moves());
}

}  // namespace
}  // namespace footlight::tools
