// Rays, axes and planes of the handles in the picture, also where there is no answer.
#include "tools/footlight/preview/ui/stage_rays.h"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"

namespace footlight::tools {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

StagePlace place_from(glm::dvec3 from_m, glm::dvec3 to_m) {
  fixtures::Camera camera;
  camera.position_m = from_m;
  camera.target_m = to_m;
  return {render::view_of(camera), {1280, 720}};
}

TEST_CASE("the ray through where a point is seen meets the point") {
  const StagePlace place = place_from({3, -12, 4}, {0, 0, 2});
  for (const glm::dvec3 point_m : {glm::dvec3(0, 0, 0), glm::dvec3(-4, 3, 6), glm::dvec3(5, -2, 1)}) {
    const auto at = projected(place, point_m);
    REQUIRE(at);
    const StageRay ray = ray_through(place, *at);
    CHECK(glm::length(glm::cross(point_m - ray.from_m, ray.way)) < 1e-9);
    CHECK(glm::length(ray.way) == doctest::Approx(1));
  }
}

TEST_CASE("the nearest point of an axis to a ray through one of its points is that point") {
  const StagePlace place = place_from({3, -12, 4}, {0, 0, 2});
  const glm::dvec3 origin_m(1, 2, 3);
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 way(0);
    way[axis] = 1;
    for (const double along : {-2.5, 0.0, 4.0}) {
      const auto at = projected(place, origin_m + way * along);
      REQUIRE(at);
      const auto found = nearest_on_axis(ray_through(place, *at), origin_m, way);
      REQUIRE(found);
      CHECK(*found == doctest::Approx(along).epsilon(1e-9));
    }
  }
}

TEST_CASE("an axis has no nearest point to a ray along it, to one that leads away, and to no ray") {
  const glm::dvec3 x(1, 0, 0);
  CHECK(!nearest_on_axis({{0, -5, 0}, x}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{0, -5, 0}, -x}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{-5, 0, 0}, x}, {0, 0, 0}, x));  // within it
  CHECK(!nearest_on_axis({{0, -5, 0}, glm::normalize(glm::dvec3(1, 1e-5, 0))}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{0, -5, 0}, {0, -1, 0}}, {0, 0, 0}, x));  // behind the camera
  CHECK(nearest_on_axis({{0, -5, 0}, {0, 1, 0}}, {0, 0, 0}, x).value() == doctest::Approx(0));
  // Hardly not parallel: farther than anything that hangs.
  CHECK(!nearest_on_axis({{0, -100, 0}, glm::normalize(glm::dvec3(1, 0.005, 0))}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{0, -5, 0}, {kNan, kNan, kNan}}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{0, kNan, 0}, {0, 1, 0}}, {0, 0, 0}, x));
  CHECK(!nearest_on_axis({{0, -5, 0}, {0, 1, 0}}, {kNan, 0, 0}, x));
}

TEST_CASE("a plane is met before the camera only, and not from along it") {
  const glm::dvec3 up(0, 0, 1);
  const auto met = on_plane({{1, 2, 10}, {0, 0, -1}}, {0, 0, 3}, up);
  REQUIRE(met);
  CHECK(glm::length(*met - glm::dvec3(1, 2, 3)) < 1e-12);
  CHECK(!on_plane({{1, 2, 10}, {0, 0, 1}}, {0, 0, 3}, up));
  CHECK(!on_plane({{1, 2, 10}, {1, 0, 0}}, {0, 0, 3}, up));
  CHECK(!on_plane({{1, 2, 3}, {1, 0, 0}}, {0, 0, 3}, up));  // within it
  CHECK(!on_plane({{1, 2, 10}, glm::normalize(glm::dvec3(1, 0, -5e-4))}, {0, 0, 3}, up));
  CHECK(!on_plane({{1, 2, 50}, glm::normalize(glm::dvec3(1, 0, -2e-3))}, {0, 0, 3}, up));  // 23 km away
  CHECK(!on_plane({{1, 2, 10}, {kNan, 0, -1}}, {0, 0, 3}, up));
  CHECK(!on_plane({{1, 2, 10}, {0, 0, -1}}, {0, 0, kNan}, up));
}

TEST_CASE("of a line through the camera's plane only the part in front of it is seen") {
  const StagePlace place = place_from({0, -10, 1}, {0, 0, 1});
  const auto line = projected_line(place, {1, -30, 1}, {1, 10, 1});
  REQUIRE(line);
  for (const glm::dvec2 end : {line->first, line->second}) {
    CHECK(std::isfinite(end.x));
    CHECK(end.y == doctest::Approx(360));
  }
  CHECK(glm::length(line->second - *projected(place, {1, 10, 1})) < 1e-9);
  CHECK(line->first.x > 10'000);  // beside the camera, to the right
  const auto back = projected_line(place, {1, 10, 1}, {1, -30, 1});
  REQUIRE(back);
  CHECK(glm::length(back->first - line->second) < 1e-9);
  CHECK(!projected_line(place, {1, -30, 1}, {1, -11, 1}));
  CHECK(!projected_line(place, {kNan, 0, 1}, {1, 10, 1}));
}

TEST_CASE("a length in units of the picture is the same at any distance") {
  const StagePlace place = place_from({0, -10, 1}, {0, 0, 1});
  for (const double y : {-9.5, 0.0, 500.0}) {
    const glm::dvec3 at_m(0, y, 1);
    const auto unit_m = metres_per_unit(place, at_m);
    REQUIRE(unit_m);
    const auto end = projected(place, at_m + place.view.right * (70 * *unit_m));
    REQUIRE(end);
    CHECK(glm::length(*end - *projected(place, at_m)) == doctest::Approx(70));
  }
  CHECK(!metres_per_unit(place, {0, -10, 1}));
  CHECK(!metres_per_unit(place, {0, -11, 1}));
}

TEST_CASE("the first surface is the nearest box or the floor, within reach") {
  const fixtures::Rig rig = testing::parsed_rig(testing::kUiRig);  // with a wall at y = 10
  const auto floor = surface_on(rig, {{1, 2, 5}, {0, 0, -1}}, 100);
  REQUIRE(floor);
  CHECK(glm::length(*floor - glm::dvec3(1, 2, 0)) < 1e-12);
  const auto wall = surface_on(rig, {{0, 0, 4}, {0, 1, 0}}, 100);
  REQUIRE(wall);
  CHECK(wall->y == doctest::Approx(10));
  CHECK(!surface_on(rig, {{0, 0, 4}, {0, 1, 0}}, 9));
  CHECK(!surface_on(rig, {{0, 0, 4}, {0, -1, 0}}, 100));
  CHECK(!surface_on(rig, {{0, 0, 4}, {0, 0, 1}}, 100));
  CHECK(!surface_on(rig, {{0, 0, kNan}, {0, 0, -1}}, 100));
  CHECK(!surface_on(rig, {{0, 0, 4}, {kNan, kNan, kNan}}, 100));
  // A lens within a box shines out of it.
  const auto out = surface_on(rig, {{0, 10.1, 4}, {0, 0, -1}}, 100);
  REQUIRE(out);
  CHECK(out->z == doctest::Approx(0));
}

TEST_CASE("the distance to a line is that to its nearest point, also of one without length") {
  CHECK(distance_to_line({5, 3}, {0, 0}, {10, 0}) == doctest::Approx(3));
  CHECK(distance_to_line({13, 4}, {0, 0}, {10, 0}) == doctest::Approx(5));
  CHECK(distance_to_line({3, 4}, {0, 0}, {0, 0}) == doctest::Approx(5));
  CHECK(snapped(1.26, 0.5) == 1.5);
  CHECK(snapped(-1.24, 0.5) == -1);
}

}  // namespace
}  // namespace footlight::tools
