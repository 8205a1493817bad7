// Distances between clicked points, and the lines on the floor.
#include "tools/footlight/preview/ui/stage_measure.h"

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"

namespace footlight::tools {
namespace {

TEST_CASE("two clicks are a distance, and a third one begins the next") {
  StageMeasure measure;
  measure.click({1, 0, 0});
  CHECK(measure.from_m == glm::dvec3(1, 0, 0));
  CHECK(!measure.to_m);
  measure.click({1, 3, 4});
  REQUIRE(measure.to_m);
  CHECK(text_of_distance(*measure.from_m, *measure.to_m) == "5.00 m  x +0.00  y +3.00  z +4.00");
  measure.click({7, 0, 0});
  CHECK(measure.from_m == glm::dvec3(7, 0, 0));
  CHECK(!measure.to_m);
  CHECK(text_of_distance({0, 0, 0}, {-0.0, -1.5, 0}) == "1.50 m  x +0.00  y -1.50  z +0.00");
}

TEST_CASE("a click measures at a fixture's hanging point, on the floor, on a box, and nowhere in the sky") {
  const fixtures::Rig rig = testing::parsed_rig(testing::kUiRig);
  const StagePick pick(rig);
  fixtures::Camera camera;
  camera.position_m = {0, -12, 2};
  camera.target_m = {0, 0, 4};
  const StagePlace place{render::view_of(camera), {1280, 720}};
  const auto mark = pick.mark_of(place, 2);
  REQUIRE(mark);
  CHECK(measured_point(rig, pick, place, (mark->low + mark->high) / 2.0) == glm::dvec3(3, 0, 5));
  const glm::dvec3 floor_m(1, -3, 0);
  const auto floor = measured_point(rig, pick, place, *projected(place, floor_m));
  REQUIRE(floor);
  CHECK(glm::length(*floor - floor_m) < 1e-9);
  const glm::dvec3 wall_m(-2, 10, 3);
  const auto wall = measured_point(rig, pick, place, *projected(place, wall_m));
  REQUIRE(wall);
  CHECK(glm::length(*wall - wall_m) < 1e-9);
  CHECK(!measured_point(rig, pick, place, {640, 2}));
}

TEST_CASE("lines are 1 m apart and around the rig, and farther apart where it is large") {
  const FloorLines lines = floor_lines({-3.2, 0.5, 0}, {4, 6, 5});
  CHECK(lines.step_m == 1);
  CHECK(lines.low == glm::ivec2(-6, -2));
  CHECK(lines.high == glm::ivec2(6, 8));
  for (const double far_m : {50.0, 56.0, 60.0, 900.0, 1e6, 1e30}) {
    CAPTURE(far_m);
    const FloorLines large = floor_lines({-far_m, 0, 0}, {far_m, 0, 0});
    CHECK(large.step_m == (far_m < 57 ? 1 : far_m < 100 ? 10 : large.step_m));
    CHECK(large.high.x - large.low.x < kFloorLinesMax);
    CHECK(large.high.x >= 0);
    CHECK(large.low.x < 0);
  }
}

}  // namespace
}  // namespace footlight::tools
