#include <cmath>

#include <doctest/doctest.h>

#include "render/image.h"
#include "tools/footlight/preview/orbit_camera.h"

namespace footlight::tools {
namespace {

fixtures::Camera foh() {
  fixtures::Camera camera;
  camera.position_m = {1, -14, 2.6};
  camera.target_m = {0, 0.5, 2.8};
  camera.fov_deg = 42;
  camera.exposure_ev = 4.5;
  return camera;
}

void check_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-12) {
  CHECK(glm::length(a - b) < tolerance);
}

TEST_CASE("a camera that was not moved is the rig's camera") {
  const fixtures::Camera back = OrbitCamera(foh()).camera();
  check_near(back.position_m, foh().position_m);
  check_near(back.target_m, foh().target_m);
  CHECK(back.fov_deg == foh().fov_deg);
  CHECK(back.exposure_ev == foh().exposure_ev);
}

TEST_CASE("orbiting keeps the target and the distance, and positive angles go right and up") {
  OrbitCamera camera(foh());
  const render::View before = render::view_of(camera.camera());
  camera.orbit(0.1, 0.05);
  const fixtures::Camera moved = camera.camera();
  check_near(moved.target_m, foh().target_m);
  CHECK(glm::length(moved.position_m - moved.target_m) ==
        doctest::Approx(glm::length(foh().position_m - foh().target_m)));
  CHECK(glm::dot(moved.position_m - foh().position_m, before.right) > 0.5);
  CHECK(glm::dot(moved.position_m - foh().position_m, before.up) > 0.5);
}

TEST_CASE("no orbit turns the camera upside down") {
  OrbitCamera camera(foh());
  camera.orbit(0, 100);
  const render::View view = render::view_of(camera.camera());
  CHECK(view.forward.z < -0.99);
  CHECK(view.forward.z > -1);
  CHECK(view.up.z > 0);
}

TEST_CASE("panning by the height of the picture moves the target to the former edge of the picture") {
  OrbitCamera camera(foh());
  const render::View view = render::view_of(foh());
  const double half_height_m = view.tan_half_fov * glm::length(foh().target_m - foh().position_m);
  camera.pan(0, 0.5);
  check_near(camera.camera().target_m, foh().target_m + view.up * half_height_m, 1e-9);
  check_near(camera.camera().position_m, foh().position_m + view.up * half_height_m, 1e-9);
}

TEST_CASE("approaching never reaches the target, and the distance is limited") {
  OrbitCamera camera(foh());
  const double distance_m = camera.distance_m();
  camera.approach(1);
  CHECK(camera.distance_m() == doctest::Approx(0.9 * distance_m));
  camera.approach(1e6);
  CHECK(camera.distance_m() == doctest::Approx(0.05));
  camera.approach(-1e6);
  CHECK(camera.distance_m() == doctest::Approx(50000));
}

TEST_CASE("every corner of a framed box is in the picture, wide or tall") {
  for (const double aspect : {0.4, 1.0, 2.4}) {
    CAPTURE(aspect);
    OrbitCamera camera(foh());
    camera.orbit(0.7, 0.2);
    const glm::dvec3 low(-5, -5.4, 0);
    const glm::dvec3 high(4.9, 3.5, 6);
    camera.frame(low, high, aspect);
    const render::View view = render::view_of(camera.camera());
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                          (corner & 4) != 0 ? high.z : low.z);
      const glm::dvec3 way = at - view.position_m;
      const double depth = glm::dot(way, view.forward);
      CHECK(depth > 0);
      CHECK(std::abs(glm::dot(way, view.up)) < depth * view.tan_half_fov);
      CHECK(std::abs(glm::dot(way, view.right)) < depth * view.tan_half_fov * aspect);
    }
  }
}

TEST_CASE("a framed rig fills at least four fifths of the picture, across or upward") {
  const Bounds bounds = bounds_of(fixtures::demo_rig());
  for (const double aspect : {0.5, 16.0 / 9, 3.0}) {
    for (const double right : {0.0, 0.7, 1.57}) {
      CAPTURE(aspect);
      CAPTURE(right);
      OrbitCamera camera(foh());
      camera.orbit(right, 0.2);
      camera.frame(bounds.low_m, bounds.high_m, aspect);
      const render::View view = render::view_of(camera.camera());
      glm::dvec2 low(1e9);
      glm::dvec2 high(-1e9);
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at((corner & 1) != 0 ? bounds.high_m.x : bounds.low_m.x,
                            (corner & 2) != 0 ? bounds.high_m.y : bounds.low_m.y,
                            (corner & 4) != 0 ? bounds.high_m.z : bounds.low_m.z);
        const glm::dvec3 way = at - view.position_m;
        const double half = glm::dot(way, view.forward) * view.tan_half_fov;
        const glm::dvec2 place(glm::dot(way, view.right) / (half * aspect), glm::dot(way, view.up) / half);
        low = glm::min(low, place);
        high = glm::max(high, place);
      }
      CHECK(std::max(high.x - low.x, high.y - low.y) > 2 * 0.8);
      CHECK(std::abs(high.x + low.x) < 0.2);
      CHECK(std::abs(high.y + low.y) < 0.2);
    }
  }
}

TEST_CASE("a camera at its own target can still be moved") {
  fixtures::Camera camera = foh();
  camera.target_m = camera.position_m;
  OrbitCamera orbit(camera);
  check_near(orbit.camera().position_m, camera.position_m);
  orbit.orbit(1, 0.1);
  CHECK(std::isfinite(orbit.camera().position_m.x));
  CHECK(orbit.distance_m() == doctest::Approx(1));
}

TEST_CASE("the bounds contain the corners of displays") {
  fixtures::Rig rig;
  rig.boxes.push_back({"floor", {-30, -20, -0.1}, {30, 20, 0}, {}});
  fixtures::Display display;
  display.position_m = {1, 4, 3};
  display.rotation_deg = {0, 0, 90};  // its width is along y
  display.width_m = 6;
  display.height_m = 2;
  rig.displays.push_back(display);
  check_near(bounds_of(rig).low_m, {1, 1, 2});
  check_near(bounds_of(rig).high_m, {1, 7, 4});
}

TEST_CASE("the bounds contain every fixture and the floor under it, without fixtures, the boxes") {
  const fixtures::Rig& demo = fixtures::demo_rig();
  const Bounds bounds = bounds_of(demo);
  CHECK(bounds.low_m.z == 0);
  for (const auto& fixture : demo.fixtures) {
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(fixture.position_m[axis] >= bounds.low_m[axis]);
      CHECK(fixture.position_m[axis] <= bounds.high_m[axis]);
    }
  }
  fixtures::Rig bare;
  bare.boxes.push_back({"floor", {-3, -2, -0.1}, {3, 2, 0}, {}});
  check_near(bounds_of(bare).high_m, {3, 2, 0});
  bare.boxes.clear();
  CHECK(bounds_of(bare).low_m.x < bounds_of(bare).high_m.x);
}

}  // namespace
}  // namespace footlight::tools
