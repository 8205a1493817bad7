// Universes that the rig does not use, in the panel of universes.
#include <string>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/edit_ui.h"

namespace footlight::tools {
namespace {

struct UnpatchedUi final : testing::DrawnUi {
  UnpatchedUi() {
    open.set_open(panel_of("universes"), true, edit.desk);
    for (int i = 0; i < 3; ++i) frame();
  }
  void draw() override {
    const std::vector<std::uint8_t> levels(edit.desk.compiled().universes.size() * kSlotCountMax);
    UiInput input;
    input.levels = levels;
    input.unpatched = &unpatched;
    input.now_ns = now_ns += kNsPerS / 60;
    open.draw(edit.desk, input, 1280, 720);
  }
  bool shows(const char* text) { return words().find(text) != std::string::npos; }

  testing::HeadlessImGui imgui{1280, 720};
  testing::EditDesk edit{testing::parsed_rig(testing::kUiRig)};
  UiPanels open;
  std::vector<UnpatchedUniverse> unpatched;
  TimeNs now_ns = 10 * kNsPerS;
};

TEST_CASE("a universe that arrives and is not patched is chosen from a list, and its slots mean nothing") {
  UnpatchedUi ui;
  CHECK(!ui.shows("not patched"));
  ui.unpatched.resize(2);
  ui.unpatched[0].universe = 8;
  ui.unpatched[0].sender = "Desk B";
  ui.unpatched[0].stamp_ns = ui.now_ns;
  ui.unpatched[1].universe = 9;
  ui.unpatched[1].sender = "Desk C";
  ui.unpatched[1].priority = 120;
  ui.unpatched[1].stamp_ns = ui.now_ns;
  ui.unpatched[1].levels.fill(51);
  CHECK(ui.shows("2 universes arrive that are not patched"));
  CHECK(ui.shows("universe 1"));
  testing::activate("###Universes", {"##unpatched"});
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(ui.shows("universe 8: Desk B"));
  testing::activate("##Combo_00", {"###9"});
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(ui.shows("universe 9: not patched"));
  CHECK(ui.shows("Desk C (priority 120)"));
  CHECK(ui.shows("9.1  level 51 (20 %)"));
  CHECK(ui.shows("not patched: no fixture and no display uses this universe"));
  ui.unpatched.pop_back();
  CHECK(ui.shows("universe 9 does not arrive any more"));
  ui.unpatched.clear();
  CHECK(!ui.shows("not patched"));
}

}  // namespace
}  // namespace footlight::tools
