// Where the views of the stage are, whose camera moves, and which of them is drawn next.
#include "tools/footlight/preview/ui/stage_views.h"

#include <array>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::parsed_rig;

TEST_CASE("views have the same size, lie within the stage, and no pixel belongs to two of them") {
  for (const PixelRect whole : {PixelRect{0, 0, 1001, 640}, PixelRect{10, 20, 301, 700}, PixelRect{0, 0, 2, 2}}) {
    for (const int views : {1, 2, 4}) {
      const PixelRect first = view_place(whole, views, 0);
      int pixels = 0;
      for (int y = whole.y; y < whole.y + whole.height; ++y) {
        for (int x = whole.x; x < whole.x + whole.width; ++x) pixels += view_at(whole, views, x, y) >= 0 ? 1 : 0;
      }
      for (int view = 0; view < views; ++view) {
        const PixelRect place = view_place(whole, views, view);
        CHECK(place.width == first.width);
        CHECK(place.height == first.height);
        if (whole.width <= 2) continue;  // too small for a gap
        CHECK(view_at(whole, views, place.x, place.y) == view);
        CHECK(view_at(whole, views, place.x + place.width - 1, place.y + place.height - 1) == view);
        CHECK(place.x + place.width <= whole.x + whole.width);
        CHECK(place.y + place.height <= whole.y + whole.height);
      }
      if (whole.width > 2) CHECK(pixels == views * first.width * first.height);
    }
  }
}

TEST_CASE("two views are beside each other in a wide stage, and above each other in a high one") {
  CHECK(view_place({0, 0, 1000, 500}, 2, 1) == PixelRect{501, 0, 499, 500});
  CHECK(view_place({0, 0, 500, 1000}, 2, 1) == PixelRect{0, 501, 500, 499});
  CHECK(view_at({0, 0, 1000, 500}, 2, 499, 100) == -1);  // the gap
}

TEST_CASE("the active view is drawn most often, and every other one in turn") {
  for (const int views : {1, 2, 4}) {
    for (int active = 0; active < views; ++active) {
      ViewTurns turns;
      std::array<int, kViewsMax> drawn{};
      for (int i = 0; i < 120; ++i) ++drawn[static_cast<std::size_t>(turns.next(views, active))];
      const int own = views == 1 ? 120 : views == 2 ? 80 : 60;
      for (int view = 0; view < kViewsMax; ++view) {
        const int expected = view == active ? own : view < views ? (120 - own) / (views - 1) : 0;
        CHECK(drawn[static_cast<std::size_t>(view)] == expected);
      }
    }
  }
}

TEST_CASE("a movement of the camera is undone in the view in which it was made, whichever is active since") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_views(2);
  const OrbitCamera near({.name = "near", .position_m = {0, -5, 2}});
  const OrbitCamera far({.name = "far", .position_m = {0, -50, 2}});
  const double start_m = desk.state().camera.distance_m();
  desk.place_camera(1, near);
  desk.activate_view(1);
  CHECK(desk.state().camera.distance_m() == doctest::Approx(near.distance_m()));
  CHECK(desk.camera_of(0).distance_m() == doctest::Approx(start_m));
  desk.jump_camera(far);
  desk.activate_view(0);
  desk.jump_camera(near);
  CHECK(desk.camera_of(1).distance_m() == doctest::Approx(far.distance_m()));
  desk.undo();
  CHECK(desk.camera_of(0).distance_m() == doctest::Approx(start_m));
  CHECK(desk.camera_of(1).distance_m() == doctest::Approx(far.distance_m()));
  desk.undo();
  CHECK(desk.camera_of(0).distance_m() == doctest::Approx(start_m));
  CHECK(desk.camera_of(1).distance_m() == doctest::Approx(near.distance_m()));
  desk.redo();
  CHECK(desk.camera_of(1).distance_m() == doctest::Approx(far.distance_m()));
}

TEST_CASE("what is undone is seen: the view of a movement becomes active, and closed views are passed over") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_views(2);
  const OrbitCamera near({.name = "near", .position_m = {0, -5, 2}});
  const OrbitCamera far({.name = "far", .position_m = {0, -50, 2}});
  const double start_m = desk.state().camera.distance_m();
  desk.jump_camera(near);
  desk.activate_view(1);
  desk.jump_camera(far);
  desk.activate_view(0);
  CHECK(!desk.undo().empty());
  CHECK(desk.state().view == 1);
  CHECK(!desk.redo().empty());
  CHECK(desk.state().camera.distance_m() == doctest::Approx(far.distance_m()));
  desk.set_views(1);
  CHECK(desk.undo() == "move the camera");
  CHECK(desk.state().view == 0);
  CHECK(desk.state().camera.distance_m() == doctest::Approx(start_m));  // not that of the view that is closed
  CHECK(desk.undo().empty());
  CHECK(!desk.redo().empty());
  CHECK(desk.redo().empty());
  CHECK(desk.state().camera.distance_m() == doctest::Approx(near.distance_m()));
}

TEST_CASE("a flight ends with its view") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_views(2);
  desk.activate_view(1);
  desk.fly().set_on(true);
  desk.activate_view(1);
  CHECK(desk.fly().on());
  desk.set_views(1);
  CHECK(!desk.fly().on());
}

TEST_CASE("drags in two views are two edits, also within one gesture") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_views(4);
  OrbitCamera camera = desk.state().camera;
  camera.orbit(0.1, 0);
  desk.run(MoveCamera{camera, std::nullopt, 0});
  desk.run(MoveCamera{camera, std::nullopt, 3});
  CHECK(desk.history().size() == 2);
}

TEST_CASE("with fewer views the first one is active if the active one is closed") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_views(4);
  desk.activate_view(3);
  desk.activate_view(4);  // there is none
  CHECK(desk.state().view == 3);
  desk.set_views(2);
  CHECK(desk.state().view == 0);
  desk.activate_view(-1);
  CHECK(desk.state().view == 0);
}

TEST_CASE("fixtures are clicked on and marked where the view is") {
  const fixtures::Rig rig = parsed_rig(kUiRig);
  const StagePick pick(rig);
  fixtures::Camera camera;
  camera.position_m = {0, -12, 2};
  camera.target_m = {0, 0, 4};
  const StagePlace whole{render::view_of(camera), {640, 360}};
  const StagePlace view{render::view_of(camera), {640, 360}, {700, 400}};
  for (int fixture = 0; fixture < static_cast<int>(rig.fixtures.size()); ++fixture) {
    const auto mark = pick.mark_of(whole, fixture);
    const auto moved = pick.mark_of(view, fixture);
    REQUIRE(mark.has_value() == moved.has_value());
    if (!mark) continue;
    CHECK(glm::length(mark->low + view.origin - moved->low) < 1e-9);
    const glm::dvec2 middle = (mark->low + mark->high) / 2.0;
    CHECK(pick.fixture_at(view, middle + view.origin) == pick.fixture_at(whole, middle));
    const StageRay ray = ray_through(view, middle + view.origin);
    CHECK(glm::length(ray.way - ray_through(whole, middle).way) < 1e-12);
  }
}

}  // namespace
}  // namespace footlight::tools
