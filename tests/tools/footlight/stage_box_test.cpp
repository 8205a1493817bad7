// The rectangle that selects, without a window.
#include "tools/footlight/preview/ui/stage_box.h"

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"

namespace footlight::tools {
namespace {

using Fixtures = std::vector<int>;

// Three spots in a row, a par behind them, a par behind the wall.
struct BoxUi {
  BoxUi()
      : rig(testing::compiled_rig(testing::parsed_rig(testing::kUiRig))), pick(rig.rig), desk(rig.rig, rig.compiled) {
    fixtures::Camera camera;
    camera.position_m = {0, -12, 2};
    camera.target_m = {0, 0, 4};
    input.place = {render::view_of(camera), {1280, 720}};
    input.over_stage = true;
  }
  [[nodiscard]] glm::dvec2 middle(int fixture) const {
    const auto mark = pick.mark_of(input.place, fixture);
    REQUIRE(mark);
    return (mark->low + mark->high) / 2.0;
  }
  bool move(glm::dvec2 at, bool pressed, bool down) {
    input.mouse = at;
    input.pressed = pressed;
    input.down = down;
    return box.take(desk, pick, input);
  }
  void drag(glm::dvec2 from, glm::dvec2 to) {
    desk.begin_gesture();
    move(from, true, true);
    move(to, false, true);
    move(to, false, false);
  }
  [[nodiscard]] const Fixtures& selected() const { return desk.state().selection.fixtures; }

  testing::UiRig rig;
  StagePick pick;
  UiDesk desk;
  StageBox box;
  BoxInput input;
};

TEST_CASE("a drag with Shift selects what is in the rectangle, from any corner, and is one step of undo") {
  BoxUi ui;
  ui.input.shift = true;
  const glm::dvec2 low = glm::min(ui.middle(0), ui.middle(1)) - 5.0;
  const glm::dvec2 high = glm::max(ui.middle(0), ui.middle(1)) + 5.0;
  ui.drag(low, high);
  CHECK(ui.selected() == Fixtures{0, 1});
  ui.drag({high.x, low.y}, {low.x, high.y});
  CHECK(ui.selected() == Fixtures{0, 1});
  ui.drag(ui.middle(2) - 5.0, ui.middle(2) + 5.0);
  CHECK(ui.selected() == Fixtures{2});
  CHECK(ui.desk.state().selection.lead == 2);
  ui.desk.undo();
  CHECK(ui.selected() == Fixtures{0, 1});
  ui.drag({0, 0}, {5, 5});
  CHECK(ui.selected().empty());
  CHECK(ui.desk.state().selection.lead == -1);
}

TEST_CASE("Ctrl adds the fixtures of the rectangle, and Ctrl with Shift takes them away") {
  BoxUi ui;
  ui.desk.select(0, false);
  ui.input.ctrl = true;
  ui.drag(ui.middle(2) - 5.0, ui.middle(2) + 5.0);
  CHECK(ui.selected() == Fixtures{0, 2});
  CHECK(ui.desk.state().selection.lead == 0);
  ui.input.shift = true;
  ui.drag(ui.middle(0) - 5.0, ui.middle(0) + 5.0);
  CHECK(ui.selected() == Fixtures{2});
  CHECK(ui.desk.state().selection.lead == 2);
}

TEST_CASE("a rectangle over the whole picture leaves out what a wall hides") {
  BoxUi ui;
  ui.input.shift = true;
  ui.drag({0, 0}, {1280, 720});
  CHECK(ui.selected() == Fixtures{0, 1, 2, 3});
}

TEST_CASE("without Shift or Ctrl, over a panel and with a click there is no rectangle") {
  BoxUi ui;
  CHECK(!ui.move({0, 0}, true, true));
  CHECK(!ui.move({900, 700}, false, true));
  ui.input.shift = true;
  ui.input.over_stage = false;
  CHECK(!ui.move({0, 0}, true, true));
  CHECK(!ui.move({900, 700}, false, true));
  CHECK(!ui.move({900, 700}, false, false));
  ui.input.over_stage = true;
  CHECK(!ui.move({0, 0}, true, true));
  CHECK(!ui.move({2, 2}, false, true));
  CHECK(!ui.move({2, 2}, false, false));  // a click adds or removes one fixture
  CHECK(ui.desk.history().next_undo() == nullptr);
}

TEST_CASE("a rectangle that is cancelled selects nothing at the release") {
  BoxUi ui;
  ui.input.shift = true;
  ui.move({0, 0}, true, true);
  CHECK(ui.move({1280, 720}, false, true));
  CHECK(ui.box.dragging());
  ui.box.cancel();
  CHECK(!ui.move({1280, 720}, false, true));
  CHECK(!ui.move({1280, 720}, false, false));
  CHECK(ui.selected().empty());
}

}  // namespace
}  // namespace footlight::tools
