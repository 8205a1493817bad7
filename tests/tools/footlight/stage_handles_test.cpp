// Handles in the picture: drags of the mouse become edits, one step each, and Escape takes them back.
#include "tools/footlight/preview/ui/stage_handles.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/footlight/edit_desk.h"

namespace footlight::tools {
namespace {

using testing::EditDesk;
using testing::kUiRig;
using testing::parsed_rig;

// A mouse over a picture from the front, with Spot 2 selected: it hangs at 0, 0, 5.
struct Stage {
  explicit Stage(fixtures::Rig rig = parsed_rig(kUiRig)) : edit(std::move(rig)), desk(edit.desk) {
    look({4, -12, 7}, {0, 0, 4});
    desk.select(1, false);
    levels.resize(desk.compiled().universes.size() * kSlotCountMax);
    (void)mouse({0, 0}, false);
  }
  void look(glm::dvec3 from_m, glm::dvec3 to_m) {
    fixtures::Camera camera;
    camera.position_m = from_m;
    camera.target_m = to_m;
    input.place = {render::view_of(camera), {1280, 720}};
  }
  bool mouse(glm::dvec2 at, bool down) {
    for (std::uint8_t& level : levels) level = 0;
    desk.overlay(levels);
    input.levels = levels;
    input.over_stage = true;
    input.pressed = down && !input.down;
    input.down = down;
    input.mouse = at;
    const bool began = input.pressed || (!down && handles.dragging());
    if (input.pressed) desk.begin_gesture();
    const bool taken = handles.take(desk, input);
    if (began && !down) desk.begin_gesture();
    return taken;
  }
  bool drag(glm::dvec2 from, glm::dvec2 to) {
    (void)mouse(from, false);
    if (!mouse(from, true)) return false;
    (void)mouse((from + to) / 2.0, true);
    (void)mouse(to, true);
    return mouse(to, false);
  }
  [[nodiscard]] glm::dvec2 seen(const glm::dvec3& point_m) const { return projected(input.place, point_m).value(); }
  [[nodiscard]] glm::dvec2 middle_of(std::size_t axis) const {
    const auto& arrow = handles.shape().value().arrows.at(axis);
    return (arrow.from + arrow.to) / 2.0;
  }
  [[nodiscard]] glm::dvec3 position(std::size_t fixture) const { return fixtures::position_of(edit.fixture(fixture)); }

  EditDesk edit;
  UiDesk& desk;
  StageHandles handles;
  HandleInput input;
  std::vector<std::uint8_t> levels;
};

// The place of the mouse that is `by_m` along an axis from `from`, which is over the axis through the fixture.
glm::dvec2 along(const Stage& stage, glm::dvec2 from, const glm::dvec3& axis, double by_m) {
  const glm::dvec3 origin_m = stage.position(1);
  const double at_m = nearest_on_axis(ray_through(stage.input.place, from), origin_m, axis).value();
  return stage.seen(origin_m + axis * (at_m + by_m));
}

TEST_CASE("a drag of an arrow moves all selected fixtures along it, as one step that can be undone") {
  for (int axis = 0; axis < 3; ++axis) {
    Stage stage;
    stage.desk.select(3, true);
    stage.desk.select(1, true);
    stage.desk.select(1, true);  // selected last
    (void)stage.mouse({0, 0}, false);
    const std::size_t steps = stage.desk.history().size();
    glm::dvec3 way(0);
    way[axis] = 1;
    const glm::dvec3 par_m = stage.position(3);
    const glm::dvec2 from = stage.middle_of(static_cast<std::size_t>(axis));
    REQUIRE(stage.drag(from, along(stage, from, way, 1.7)));
    CHECK(glm::length(stage.position(1) - (glm::dvec3(0, 0, 5) + way * 1.7)) < 1e-9);
    CHECK(glm::length(stage.position(3) - (par_m + way * 1.7)) < 1e-9);
    CHECK(stage.position(0) == glm::dvec3(-3, 0, 5));
    CHECK(stage.desk.history().size() == steps + 1);
    (void)stage.desk.undo();
    CHECK(stage.position(1) == glm::dvec3(0, 0, 5));
    CHECK(stage.position(3) == par_m);
  }
}

TEST_CASE("in a locked window a drag of a handle moves no fixture, and its press says why") {
  Stage stage;
  stage.desk.select(1, false);
  (void)stage.mouse({0, 0}, false);
  const glm::dvec3 before_m = stage.position(1);
  const std::size_t steps = stage.desk.history().size();
  stage.desk.set_locked(true);
  const glm::dvec2 from = stage.middle_of(0);
  (void)stage.mouse(from, false);
  CHECK(stage.mouse(from, true));  // the camera does not get it
  CHECK(!stage.handles.dragging());
  CHECK(stage.desk.take_news() == locked_words());
  (void)stage.mouse(from + glm::dvec2(80, 0), true);
  (void)stage.mouse(from + glm::dvec2(80, 0), false);
  CHECK(stage.position(1) == before_m);
  CHECK(stage.desk.history().size() == steps);
}

TEST_CASE("a drag of the square moves across the floor, and the height stays") {
  Stage stage;
  const auto& corners = stage.handles.shape().value().floor.value();
  const glm::dvec2 from = (corners[0] + corners[2]) / 2.0;
  const glm::dvec3 grabbed_m = on_plane(ray_through(stage.input.place, from), {0, 0, 5}, {0, 0, 1}).value();
  REQUIRE(stage.drag(from, stage.seen(grabbed_m + glm::dvec3(-1.25, 2, 0))));
  CHECK(glm::length(stage.position(1) - glm::dvec3(-1.25, 2, 5)) < 1e-9);
}

TEST_CASE("with Ctrl the coordinate that is dragged comes to steps of half a metre, and the text says so") {
  Stage stage(parsed_rig(kUiRig));
  const glm::dvec2 from = stage.middle_of(0);
  stage.input.snaps = true;
  (void)stage.mouse(from, true);
  (void)stage.mouse(along(stage, from, {1, 0, 0}, 1.3), true);
  CHECK(stage.handles.text() == "X 1.50 m (+1.50)  snap 0.5 m");
  CHECK(stage.handles.shape()->origin_m == glm::dvec3(1.5, 0, 5));
  CHECK(stage.position(1) == glm::dvec3(0, 0, 5));  // until the end of the drag
  stage.input.snaps = false;
  (void)stage.mouse(along(stage, from, {1, 0, 0}, 1.3), true);
  CHECK(stage.handles.text() == "X 1.30 m (+1.30)");
  stage.input.snaps = true;
  (void)stage.mouse(along(stage, from, {1, 0, 0}, -0.7), true);
  stage.input.snaps = false;  // the release comes with the keys of the press
  (void)stage.mouse(along(stage, from, {1, 0, 0}, -0.8), false);
  CHECK(stage.position(1) == glm::dvec3(-1, 0, 5));
}

TEST_CASE("Escape during a drag leaves the rig and the history as they were") {
  Stage stage;
  const std::size_t steps = stage.desk.history().size();
  const std::uint64_t revision = stage.desk.state().revision;
  const glm::dvec2 from = stage.middle_of(2);
  (void)stage.mouse(from, true);
  (void)stage.mouse(from + glm::dvec2(0, -80), true);
  CHECK(stage.handles.moved_m().z > 0.5);
  stage.handles.cancel(stage.desk);
  CHECK(!stage.mouse(from + glm::dvec2(0, -90), false));
  CHECK(stage.position(1) == glm::dvec3(0, 0, 5));
  CHECK(stage.desk.history().size() == steps);
  CHECK(stage.desk.state().revision == revision);
  CHECK(stage.handles.shape()->origin_m == glm::dvec3(0, 0, 5));
}

TEST_CASE("the aim handle takes pan and tilt over to the point of the floor under the mouse, as one step") {
  Stage stage;
  (void)stage.mouse({0, 0}, false);
  const std::size_t steps = stage.desk.history().size();
  const auto before = stage.desk.state().taken;
  const glm::dvec3 target_m(1, 2, 0);
  // At level 0 the head points beside the floor; a first aim brings the handle onto it.
  BeamAim aim(stage.desk.rig(), stage.desk.compiled());
  REQUIRE(stage.handles.aim_shape());
  REQUIRE(stage.drag(stage.handles.aim_shape()->point, stage.seen(target_m)));
  CHECK(stage.desk.history().size() == steps + 1);
  CHECK(stage.desk.state().taken.size() == 2);
  stage.desk.overlay(stage.levels);
  const StageRay beam = aim.beam_of(1, stage.levels).value();
  CHECK(glm::length(glm::cross(target_m - beam.from_m, beam.way)) < 2e-3);
  (void)stage.mouse({0, 0}, false);
  CHECK(glm::length(stage.handles.aim_shape()->point_m - target_m) < 5e-3);
  (void)stage.desk.undo();
  CHECK(stage.desk.state().taken == before);
  // Escape: as if it had not begun. The first step back stays the one before.
  (void)stage.mouse(stage.handles.aim_shape()->point, false);
  (void)stage.mouse(stage.handles.aim_shape()->point, true);
  (void)stage.mouse(stage.seen({2, 2, 0}), true);
  (void)stage.mouse(stage.seen({2, 1, 0}), true);
  CHECK(stage.desk.state().taken.size() == 2);
  CHECK(stage.handles.text().find("aim at 2.00 1.00 0.00 m") == 0);
  stage.handles.cancel(stage.desk);
  CHECK(stage.desk.state().taken == before);
  CHECK(stage.desk.history().next_redo() == nullptr);
  CHECK(text_of(*stage.desk.history().next_undo(), stage.desk.rig()) == "select Spot 2");
}

TEST_CASE("while the mouse stands still during a drag, heads are not aimed again") {
  Stage stage;
  const glm::dvec2 at = stage.seen({1, 2, 0});
  (void)stage.mouse(stage.handles.aim_shape()->point, true);
  (void)stage.mouse(at, true);
  CHECK(stage.desk.state().taken.size() == 2);
  stage.desk.release_all();
  (void)stage.mouse(at, true);
  CHECK(stage.desk.state().taken.empty());
  (void)stage.mouse(stage.seen({2, 2, 0}), true);
  CHECK(stage.desk.state().taken.size() == 2);  // another point is aimed at
}

TEST_CASE("with Ctrl the point that is aimed at snaps in X and Y, and keeps its height") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  fixtures::StageBox riser;
  riser.min_m = {-4, -4, 0};
  riser.max_m = {4, 4, 0.3};
  rig.boxes.push_back(riser);
  Stage stage(std::move(rig));
  stage.input.snaps = true;
  (void)stage.mouse(stage.handles.aim_shape()->point, true);
  (void)stage.mouse(stage.seen({1.1, 1.9, 0.3}), true);
  CHECK(glm::length(stage.handles.aim_shape()->point_m - glm::dvec3(1, 2, 0.3)) < 1e-9);
}

TEST_CASE("a par is turned by the aim handle, at the end of the drag") {
  Stage stage;
  stage.desk.select(3, false);
  (void)stage.mouse({0, 0}, false);
  REQUIRE(stage.handles.aim_shape());
  const glm::dvec3 rotation_deg = fixtures::rotation_deg_of(stage.edit.fixture(3));
  const glm::dvec3 target_m(2, 4, 0);
  REQUIRE(stage.drag(stage.handles.aim_shape()->point, stage.seen(target_m)));
  CHECK(fixtures::rotation_deg_of(stage.edit.fixture(3)) != rotation_deg);
  CHECK(stage.desk.state().taken.empty());
  (void)stage.mouse({0, 0}, false);
  CHECK(glm::length(stage.handles.aim_shape()->point_m - target_m) < 1e-3);
  CHECK(stage.desk.undo() == "aim Par");
  CHECK(fixtures::rotation_deg_of(stage.edit.fixture(3)) == rotation_deg);
}

TEST_CASE("a click on a handle changes nothing, and beside all handles it is not taken") {
  Stage stage;
  const std::size_t steps = stage.desk.history().size();
  for (const glm::dvec2 at : {stage.middle_of(0), stage.handles.aim_shape()->point}) {
    (void)stage.mouse(at, false);
    CHECK(stage.mouse(at, true));
    CHECK(stage.mouse(at, false));
  }
  CHECK(stage.desk.history().size() == steps);
  CHECK(!stage.mouse({5, 5}, true));
  CHECK(!stage.mouse({5, 5}, false));
  // A panel over the handle has the mouse.
  stage.input.mouse = stage.middle_of(0);
  stage.input.over_stage = false;
  stage.input.pressed = stage.input.down = true;
  CHECK(!stage.handles.take(stage.desk, stage.input));
}

TEST_CASE("arrows keep their length in the picture at any distance") {
  for (const double away : {0.8, 12.0, 400.0}) {
    Stage stage;
    stage.look({0, -away, 5}, {0, 0, 5});
    (void)stage.mouse({0, 0}, false);
    const auto& shape = stage.handles.shape().value();
    CHECK(glm::length(shape.arrows[0].to - shape.origin) == doctest::Approx(70));
    CHECK(glm::length(shape.arrows[2].to - shape.origin) == doctest::Approx(70));
    CHECK(shape.arrows[1].along);  // seen from its end
    CHECK(!shape.floor);           // from the side
  }
}

TEST_CASE("there are no handles behind the camera, without a selection, and of a rig that cannot be edited") {
  Stage stage;
  stage.look({0, 3, 5}, {0, 20, 5});
  (void)stage.mouse({0, 0}, false);
  CHECK(!stage.handles.shape());
  CHECK(!stage.mouse({640, 360}, true));
  (void)stage.mouse({640, 360}, false);
  stage.look({4, -12, 7}, {0, 0, 4});
  stage.desk.select(-1, false);
  (void)stage.mouse({0, 0}, false);
  CHECK(!stage.handles.shape());
  CHECK(!stage.handles.aim_shape());
  const auto rig = testing::compiled_rig(parsed_rig(kUiRig));
  UiDesk fixed(rig.rig, rig.compiled);
  fixed.select(1, false);
  StageHandles handles;
  stage.input.levels = stage.levels;
  (void)handles.take(fixed, stage.input);
  CHECK(!handles.shape());
  CHECK(handles.aim_shape());  // its channels can be taken over
}

TEST_CASE("a drag whose fixture is deleted or deselected meanwhile ends without an edit") {
  Stage stage;
  const glm::dvec2 from = stage.middle_of(0);
  (void)stage.mouse(from, true);
  (void)stage.mouse(from + glm::dvec2(50, 0), true);
  stage.desk.select(0, false);
  const std::size_t steps = stage.desk.history().size();
  (void)stage.mouse(from + glm::dvec2(60, 0), true);
  CHECK(!stage.handles.dragging());
  (void)stage.mouse(from + glm::dvec2(60, 0), false);
  CHECK(stage.desk.history().size() == steps);
  CHECK(stage.position(1) == glm::dvec3(0, 0, 5));
}

TEST_CASE("a step of a key moves the selected fixtures by 0.1 m, and nothing without a selection") {
  Stage stage;
  CHECK(nudge_selected(stage.desk, 2, -kNudgeM).empty());
  CHECK(stage.position(1).z == doctest::Approx(4.9));
  stage.desk.select(-1, false);
  const std::size_t steps = stage.desk.history().size();
  CHECK(nudge_selected(stage.desk, 2, -kNudgeM).empty());
  CHECK(stage.desk.history().size() == steps);
}

}  // namespace
}  // namespace footlight::tools
