#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/image.h"
#include "tests/support/model_bytes.h"
#include "tools/footlight/pictures/start_view.h"

namespace footlight::tools {
namespace {

constexpr double kAspect = 16.0 / 9;

// Four lamps in a row, 6 m up.
fixtures::Rig row_of_lamps() {
  fixtures::Rig rig;
  rig.types = {fixtures::demo_rig().types.front()};
  for (int i = 0; i < 4; ++i) {
    fixtures::PatchedFixture lamp;
    lamp.name = "Lamp " + std::to_string(i);
    lamp.position_m = {3.0 * i - 4.5, 0, 6};
    rig.fixtures.push_back(lamp);
  }
  rig.made_up_cameras = true;
  return rig;
}

bool in_picture(const fixtures::Camera& camera, const glm::dvec3& point) {
  const render::View view = render::view_of(camera);
  const glm::dvec3 way = point - view.position_m;
  const double depth = glm::dot(way, view.forward);
  return depth > 0 && std::abs(glm::dot(way, view.up)) < depth * view.tan_half_fov &&
         std::abs(glm::dot(way, view.right)) < depth * view.tan_half_fov * kAspect;
}

TEST_CASE("the start view has every fixture and the floor below it in the picture, from the front") {
  const fixtures::Rig rig = row_of_lamps();
  const fixtures::Camera camera = start_view(rig, kAspect, false);
  for (const auto& fixture : rig.fixtures) {
    CHECK(in_picture(camera, fixture.position_m));
    CHECK(in_picture(camera, {fixture.position_m.x, 0, 0}));
  }
  CHECK(camera.position_m.y < -5);
  CHECK(std::abs(camera.position_m.x) < 1e-6);
  CHECK(camera.fov_deg == doctest::Approx(fixtures::Camera{}.fov_deg));
}

TEST_CASE("the start view does not have most fixtures behind each other, if there is another side") {
  fixtures::Rig rig;
  rig.types = {fixtures::demo_rig().types.front()};
  for (const glm::dvec3& at : {glm::dvec3(0, 0, 0), glm::dvec3(5, 0, 0), glm::dvec3(-5, 0, 0), glm::dvec3(0, 5, 0),
                               glm::dvec3(0, -5, 0), glm::dvec3(0, 0, 5), glm::dvec3(0, 0, -5)}) {
    fixtures::PatchedFixture lamp;
    lamp.position_m = at;
    rig.fixtures.push_back(lamp);
  }
  rig.made_up_cameras = true;
  const render::View view = render::view_of(start_view(rig, kAspect, false));
  std::size_t columns = 0;
  std::vector<double> seen;
  for (const auto& fixture : rig.fixtures) {
    const glm::dvec3 way = fixture.position_m - view.position_m;
    const double across = glm::dot(way, view.right) / glm::dot(way, view.forward);
    const bool other = std::all_of(seen.begin(), seen.end(), [&](double x) { return std::abs(x - across) > 0.04; });
    columns += other ? 1 : 0;
    seen.push_back(across);
  }
  CHECK(columns == 5);  // three stand above each other on every side
}

TEST_CASE("in a hall the start view is inside its walls, and still has the fixtures in the picture") {
  using footlight::testing::MemoryFiles;
  fixtures::Rig rig = row_of_lamps();
  const double open_m = glm::length(start_view(rig, kAspect, false).position_m);
  rig.files = std::make_shared<MemoryFiles>(
      std::map<std::string, std::string>{{"hall.3ds", footlight::testing::box_3ds(14'000, 14'000, 9'000)}});
  fixtures::SceneObject hall;
  hall.name = "hall";
  glm::dmat4 pose(1);
  pose[3] = {-7, -7, -1, 1};
  hall.parts.push_back({"hall.3ds", pose});
  rig.objects.push_back(hall);
  const fixtures::Camera camera = start_view(rig, kAspect, false);
  CHECK(open_m > 8);  // otherwise the walls would not be in the way
  for (int i = 0; i < 2; ++i) CHECK(std::abs(camera.position_m[i]) < 7);
  CHECK(camera.position_m.z < 8);
  for (const auto& fixture : rig.fixtures) CHECK(in_picture(camera, fixture.position_m));
}

TEST_CASE("a lit rig is exposed by its lumens: four times the light, two stops") {
  fixtures::Rig rig = row_of_lamps();
  rig.types.front().beams.front().flux_lm = 50'000;
  const double dim_ev = start_view(rig, kAspect, true).exposure_ev;
  rig.types.front().beams.front().flux_lm = 200'000;
  CHECK(start_view(rig, kAspect, true).exposure_ev == doctest::Approx(dim_ev + 2));
  CHECK(start_view(rig, kAspect, false).exposure_ev == fixtures::Camera{}.exposure_ev);
}

TEST_CASE("the work light of a lit rig shows a black housing at every exposure, and not more") {
  for (const double exposure_ev : {-2.0, 4.0, 10.0, 14.0}) {
    CAPTURE(exposure_ev);
    // A side face with a reflectance of 0.04 gets 0.6 of the work light.
    const auto shown = [&](double lux) {
      const auto radiance = static_cast<float>(0.04 / std::numbers::pi * 0.6 * lux);
      return int{render::screen_of({1, 1, {radiance, radiance, radiance}}, exposure_ev).rgba[0]};
    };
    CHECK(shown(faint_light_lx(exposure_ev)) >= 20);
    CHECK(shown(faint_light_lx(exposure_ev)) <= 60);
    CHECK(shown(work_light_lx(exposure_ev)) >= 20);
  }
  CHECK(work_light_lx(4) == 150);
}

TEST_CASE("a rig with cameras of its own keeps them, and one of another program starts at the start view") {
  fixtures::Rig rig = row_of_lamps();
  rig.cameras = {{"front", {}, {}, 50, 4}};
  add_start_view(rig, kAspect, false);
  REQUIRE(rig.cameras.size() == 2);
  CHECK(rig.cameras.front().name == "start");
  rig.made_up_cameras = false;
  rig.cameras = {{"own", {}, {}, 50, 4}};
  add_start_view(rig, kAspect, false);
  CHECK(rig.cameras.size() == 1);
}

}  // namespace
}  // namespace footlight::tools
