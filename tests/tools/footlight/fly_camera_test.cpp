// The camera that flies, and views of the whole rig.
#include "tools/footlight/preview/fly_camera.h"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "render/image.h"

namespace footlight::tools {
namespace {

OrbitCamera at_front() {
  fixtures::Camera camera;
  camera.position_m = {0, -12, 2};
  camera.target_m = {0, 0, 2};
  return OrbitCamera(camera);
}
glm::dvec3 place_of(const OrbitCamera& camera) { return camera.camera().position_m; }

TEST_CASE("a flight of a second goes as far as its speed says, in one step or in many, also diagonally") {
  for (const int steps : {5, 60}) {
    FlyCamera fly;
    fly.set_on(true);
    OrbitCamera camera = at_front();
    for (int i = 0; i < steps; ++i) CHECK(fly.step(camera, {.ahead = true}, kNsPerS / steps));
    CHECK(glm::length(place_of(camera) - glm::dvec3(0, -12 + fly.speed_m_s(), 2)) < 1e-6);
  }
  FlyCamera fly;
  fly.set_on(true);
  OrbitCamera camera = at_front();
  for (int i = 0; i < 10; ++i) fly.step(camera, {.right = true, .up = true, .fast = true}, kNsPerS / 10);
  const glm::dvec3 by_m = place_of(camera) - place_of(at_front());
  CHECK(glm::length(by_m) == doctest::Approx(fly.speed_m_s() * FlyCamera::kFastFactor));
  CHECK(by_m.x == doctest::Approx(by_m.z));
  CHECK(std::abs(by_m.y) < 1e-9);
}

TEST_CASE("a picture of 10 s and a clock that goes back move the camera by no more than a quarter of a second") {
  FlyCamera fly;
  fly.set_on(true);
  OrbitCamera camera = at_front();
  fly.step(camera, {.back = true}, 10 * kNsPerS);
  CHECK(place_of(camera).y == doctest::Approx(-12 - fly.speed_m_s() / 4));
  fly.step(camera, {.back = true}, -kNsPerS);
  CHECK(place_of(camera).y == doctest::Approx(-12 - fly.speed_m_s() / 4));
}

TEST_CASE("nothing moves while flying is off or opposite keys are held, and each flight begins once") {
  FlyCamera fly;
  OrbitCamera camera = at_front();
  CHECK(!fly.step(camera, {.ahead = true}, kNsPerS / 60));
  fly.set_on(true);
  CHECK(!fly.step(camera, {.left = true, .right = true}, kNsPerS / 60));
  CHECK(place_of(camera) == place_of(at_front()));
  CHECK(fly.step(camera, {.left = true}, kNsPerS / 60));
  CHECK(fly.begins());
  CHECK(fly.step(camera, {.ahead = true}, kNsPerS / 60));
  CHECK(!fly.begins());
  CHECK(!fly.step(camera, {}, kNsPerS / 60));
  CHECK(fly.step(camera, {.left = true}, kNsPerS / 60));
  CHECK(fly.begins());
}

TEST_CASE("the speed stays within its limits") {
  FlyCamera fly;
  fly.change_speed(1e6);
  CHECK(fly.speed_m_s() == FlyCamera::kSpeedMaxMS);
  fly.change_speed(-1e6);
  CHECK(fly.speed_m_s() == FlyCamera::kSpeedMinMS);
  fly.change_speed(1);
  CHECK(fly.speed_m_s() == doctest::Approx(0.125));
  fly.change_speed(std::numeric_limits<double>::quiet_NaN());
  CHECK(fly.speed_m_s() == doctest::Approx(0.125));
}

TEST_CASE("a look to the right and up turns about the camera's own place") {
  OrbitCamera camera = at_front();
  camera.look(0.2, 0.1);
  CHECK(glm::length(place_of(camera) - glm::dvec3(0, -12, 2)) < 1e-9);
  CHECK(camera.camera().target_m.x > 1);
  CHECK(camera.camera().target_m.z > 2.5);
  camera.look(0, 100);
  CHECK(render::view_of(camera.camera()).up.z > 0);
}

TEST_CASE("every side shows all of the rig, from where its name says") {
  const Bounds bounds{{-6, -2, 0}, {6, 4, 7}};
  for (std::size_t i = 0; i < kViewSides; ++i) {
    const auto side = static_cast<ViewSide>(i);
    const OrbitCamera view = view_from(side, bounds, 16.0 / 9, at_front());
    CAPTURE(view.name());
    CHECK(view.name() == name_of(side));
    const render::View seen = render::view_of(view.camera());
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at((corner & 1) != 0 ? 6 : -6, (corner & 2) != 0 ? 4 : -2, (corner & 4) != 0 ? 7 : 0);
      const glm::dvec3 way = at - seen.position_m;
      const double depth = glm::dot(way, seen.forward);
      REQUIRE(depth > 0);
      CHECK(std::abs(glm::dot(way, seen.up)) <= depth * seen.tan_half_fov);
      CHECK(std::abs(glm::dot(way, seen.right)) <= depth * seen.tan_half_fov * 16 / 9);
    }
  }
  const auto from = [&](ViewSide side) { return place_of(view_from(side, bounds, 1.5, at_front())); };
  CHECK(from(ViewSide::kFront).y < -10);
  CHECK(from(ViewSide::kLeft).x < -10);
  CHECK(from(ViewSide::kRight).x > 10);
  CHECK(from(ViewSide::kAbove).z > 10);
  const render::View plan = render::view_of(view_from(ViewSide::kPlan, bounds, 1.5, at_front()).camera());
  CHECK(plan.forward.z < -0.999);
  CHECK(plan.up.y > 0.999);  // the audience is at the bottom
}

}  // namespace
}  // namespace footlight::tools
