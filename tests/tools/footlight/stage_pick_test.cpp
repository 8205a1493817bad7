#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/stage_pick.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;

StagePlace front(glm::dvec3 from_m = {0, -12, 2}, glm::dvec3 to_m = {0, 0, 4}) {
  fixtures::Camera camera;
  camera.position_m = from_m;
  camera.target_m = to_m;
  return {render::view_of(camera), {1280, 720}};
}

TEST_CASE("a point ahead is seen in the middle, one to the right at the right, and none from behind") {
  const StagePlace place = front({0, -10, 1}, {0, 0, 1});
  const auto middle = projected(place, {0, 5, 1});
  REQUIRE(middle);
  CHECK(glm::length(*middle - glm::dvec2(640, 360)) < 1e-9);
  // The edge of the picture, from the field of view.
  const auto top = projected(place, {0, 0, 1 + 10 * place.view.tan_half_fov});
  REQUIRE(top);
  CHECK(top->y == doctest::Approx(0).epsilon(1e-9));
  CHECK(projected(place, {1, 0, 1})->x > 640);
  CHECK(!projected(place, {0, -11, 1}));
}

TEST_CASE("a click on the middle of a fixture's mark selects this fixture") {
  const fixtures::Rig rig = parsed_rig(kUiRig);
  const StagePick pick(rig);
  const StagePlace place = front();
  for (int fixture = 0; fixture < 4; ++fixture) {
    const auto mark = pick.mark_of(place, fixture);
    REQUIRE(mark);
    CHECK(pick.fixture_at(place, (mark->low + mark->high) / 2.0) == fixture);
  }
  CHECK(pick.fixture_at(place, {640, 700}) == -1);
}

TEST_CASE("of two fixtures in a line the nearer one is selected") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.boxes.clear();
  rig.fixtures[1].position_m = {0, 0, 5};
  rig.fixtures[3].position_m = {0, 5, 5};
  const StagePick pick(rig);
  const double middle_m = (pick.box_of(1).low_m.z + pick.box_of(1).high_m.z) / 2;
  const StagePlace ahead = front({0, -12, 5 + middle_m}, {0, 0, 5 + middle_m});
  const StagePlace behind = front({0, 20, 5 + middle_m}, {0, 0, 5 + middle_m});
  CHECK(pick.fixture_at(ahead, {640, 360}) == 1);
  CHECK(pick.fixture_at(behind, {640, 360}, 0) == 3);
}

TEST_CASE("a fixture behind a wall cannot be clicked, and one before it can") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  const StagePlace place = front({0, -12, 2}, {0, 20, 1.9});
  const StagePick pick(rig);
  const auto mark = pick.mark_of(place, 4);
  REQUIRE(mark);
  const glm::dvec2 middle = (mark->low + mark->high) / 2.0;
  CHECK(pick.fixture_at(place, middle) == -1);
  rig.boxes.clear();
  CHECK(pick.fixture_at(place, middle) == 4);
}

TEST_CASE("a fixture that is smaller than a pixel is selected from beside it") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  const StagePick pick(rig);
  const StagePlace place = front({0, -3000, 2}, {0, 0, 2});
  const auto mark = pick.mark_of(place, 1);
  REQUIRE(mark);
  CHECK(mark->high.x - mark->low.x < 1);
  CHECK(pick.fixture_at(place, mark->low + glm::dvec2(0, -5)) >= 0);
  CHECK(pick.fixture_at(place, mark->low + glm::dvec2(0, -50)) == -1);
}

TEST_CASE("what is framed holds the boxes of all its fixtures") {
  const fixtures::Rig rig = parsed_rig(kUiRig);
  const StagePick pick(rig);
  const std::vector<int> spots{0, 2};
  const StagePick::Box box = pick.bounds_of(spots);
  CHECK(box.low_m.x < -3);
  CHECK(box.high_m.x > 3);
  CHECK(box.high_m.z - box.low_m.z < 2);
  CHECK(box.low_m.z < 5);
}

TEST_CASE("a rig without fixtures, and a mode without geometry, can be clicked on") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  for (fixtures::FixtureType& type : rig.types) {
    for (fixtures::Mode& mode : type.modes) mode.geometries.clear();
  }
  const StagePick bare(rig);
  const auto mark = bare.mark_of(front(), 1);
  REQUIRE(mark);
  CHECK(bare.fixture_at(front(), (mark->low + mark->high) / 2.0) == 1);
  rig.fixtures.clear();
  CHECK(StagePick(rig).fixture_at(front(), {640, 360}) == -1);
}

TEST_CASE("every one of many fixtures is found by its mark or hidden by one that is nearer") {
  const auto rig = many_fixtures(300);
  const StagePick pick(rig.rig);
  const StagePlace place = front({50, -60, 30}, {50, 0, 0});
  int own = 0;
  for (int fixture = 0; fixture < 300; ++fixture) {
    const auto mark = pick.mark_of(place, fixture);
    REQUIRE(mark);
    const int found = pick.fixture_at(place, (mark->low + mark->high) / 2.0);
    REQUIRE(found >= 0);
    own += found == fixture ? 1 : 0;
  }
  CHECK(own > 290);
}

}  // namespace
}  // namespace footlight::tools
