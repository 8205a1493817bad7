// Triangles in the picture: objects of a scene under work light, and bodies of imported fixtures.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>

#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::box_3ds;
using footlight::testing::HeadlessVulkan;
using footlight::testing::MemoryFiles;

constexpr double kWorkLightLx = 100;

FrameSettings small() {
  FrameSettings settings;
  settings.width = 64;
  settings.height = 36;
  settings.edge_samples = 0;  // a pixel is what its middle shows
  return settings;
}

glm::vec3 pixel(const RadianceImage& image, int x, int y) {
  const std::size_t at = 3 * static_cast<std::size_t>(y * image.width + x);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

// A box of 2 m around the origin, scaled by `scale`, under work light alone.
Scene box_scene(glm::dvec3 scale) {
  Scene scene;
  scene.rig.name = "box";
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = kWorkLightLx;
  scene.rig.files =
      std::make_shared<MemoryFiles>(std::map<std::string, std::string>{{"box.3ds", box_3ds(2000, 2000, 2000)}});
  fixtures::SceneObject object;
  object.name = "box";
  glm::dmat4 pose(1);
  for (int i = 0; i < 3; ++i) pose[i] *= scale[i];
  pose[3] = glm::dvec4(-scale, 1);
  object.parts.push_back({"box.3ds", pose});
  scene.rig.objects.push_back(object);
  scene.camera = {"c", {0, -6, 0}, {0, 0, 0}, 40, 4};
  scene.compile();
  return scene;
}

TEST_CASE("an object of the scene is drawn in its paint under work light, mirrored or not") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const glm::dvec3 scale : {glm::dvec3(1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -1, -1)}) {
    const Scene scene = box_scene(scale);
    REQUIRE(scene.compiled.needs.objects);
    const RadianceImage image = draw_new(vulkan.device(), scene, small());
    // The front face, -y: its normal is horizontal, towards the camera. The file's paint is 255 0 128.
    const double form = 0.3 + 0.3 * 0.5 + 0.4;
    const glm::vec3 seen = pixel(image, 32, 18);
    CHECK(seen.x == doctest::Approx(kWorkLightLx * form / std::numbers::pi).epsilon(2e-3));
    CHECK(seen.y == 0);
    CHECK(seen.z == doctest::Approx(kWorkLightLx * form / std::numbers::pi * std::pow(128 / 255.0, 2.2)).epsilon(5e-3));
    CHECK(pixel(image, 2, 2) == glm::vec3(0));
  }
}

TEST_CASE("without bodies no object is drawn") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  FrameSettings settings = small();
  settings.bodies = false;
  const RadianceImage image = draw_new(vulkan.device(), box_scene(glm::dvec3(1)), settings);
  CHECK(std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return v == 0; }));
}

TEST_CASE("a lamp lights the side of an object that faces the lamp, and not the opposite side") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(1, 1);
  const Scene box = box_scene(glm::dvec3(1));
  scene.rig.objects = box.rig.objects;
  scene.rig.files = box.rig.files;
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = 0;
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.position_m = {0, 0, 6};
  lamp.rotation_deg = {0, 0, 0};
  scene.compile();
  scene.set(0, "Dimmer", 1);
  scene.set(0, "ColorAdd_R", 1);
  scene.set(0, "Zoom", 30);
  const auto brightest_red = [&](const glm::dvec3& from) {
    scene.camera = {"c", from, {0, 0, 0}, 40, 4};
    FrameSettings settings = small();
    settings.bodies = true;
    const RadianceImage image = draw_new(vulkan.device(), scene, settings);
    return pixel(image, 32, 18).x;
  };
  CHECK(brightest_red({0.1, -3, 4}) > 1);      // the top of the box
  CHECK(brightest_red({0.1, -6, -4}) < 1e-3);  // its underside
}

TEST_CASE("the models of a type's geometries are drawn at their places, and turn with the joints that move them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  using namespace fixtures;
  FixtureType type;
  type.name = "imported";
  type.body = BodyModel::kNone;
  type.beams.push_back({});
  for (const glm::dvec3 size : {glm::dvec3(0.4, 0.4, 0.4), glm::dvec3(0.3, 0.3, 2)}) {
    Model model;
    model.name = "m";
    model.primitive = Primitive::kCube;
    model.size_m = size;
    type.models.push_back(model);
  }
  Mode mode;
  mode.name = "m";
  mode.slot_count = 1;
  Geometry base;
  base.name = "Base";
  base.model = 0;
  Geometry arm;
  arm.name = "Arm";
  arm.kind = GeometryKind::kAxis;
  arm.parent = 0;
  arm.model = 1;
  Geometry beam;
  beam.name = "Beam";
  beam.kind = GeometryKind::kBeam;
  beam.parent = 1;
  beam.beam = 0;
  mode.geometries = {base, arm, beam};
  Channel tilt;
  tilt.name = "Arm_Tilt";
  tilt.geometry = 1;
  tilt.slot_offsets = {0};
  ChannelFunction function;
  function.name = "Tilt";
  function.attribute = "Tilt";
  function.physical_from = 0;
  function.physical_to = 90;
  function.instant = true;
  tilt.functions.push_back(function);
  mode.channels.push_back(tilt);
  type.modes.push_back(mode);
  REQUIRE(problems(type).empty());

  Scene scene;
  scene.rig.name = "imported";
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = kWorkLightLx;
  scene.rig.types.push_back(type);
  PatchedFixture fixture;
  fixture.name = "one";
  scene.rig.fixtures.push_back(fixture);
  scene.camera = {"c", {6, 0, 0}, {0, 0, 0}, 40, 4};  // from the side, so that tilt is visible
  scene.compile();
  const auto seen = [&](std::uint8_t level, int x, int y) {
    scene.levels[0] = level;
    return pixel(draw_new(vulkan.device(), scene, small()), x, y).x > 0;
  };
  // 36 rows show 4.4 m. The arm of 2 m reaches 8 pixels up and down, or left and right after it has turned.
  CHECK(seen(0, 32, 18));
  CHECK(seen(0, 32, 12));
  CHECK(!seen(0, 26, 18));
  CHECK(!seen(255, 32, 12));
  CHECK(seen(255, 26, 18));
}

}  // namespace
}  // namespace footlight::render
