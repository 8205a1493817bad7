// Pictures in the style of other systems.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "render/rivals/picture_style.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

RadianceImage draw_style(vk::Device& device, const Scene& scene, PictureStyle style) {
  const FrameSettings settings = settings_of(style, judged_settings(32, 18));
  const auto frame = must(Frame::create(device, scene.rig, scene.compiled, settings, passes_of(style)));
  RadianceImage image = draw(*frame, scene);
  CHECK(draw(*frame, scene).rgb == image.rgb);
  for (const auto value : image.rgb) REQUIRE(std::isfinite(value));
  return image;
}

double middle_of(const RadianceImage& image) {
  return static_cast<double>(image.rgb[3 * (static_cast<std::size_t>(image.height / 2) *
                                                static_cast<std::size_t>(image.width) +
                                            static_cast<std::size_t>(image.width / 2))]);
}

// A wide lamp that shines along +Y on a wall, seen from beside the lamp.
Scene wall_at(double distance_m, double scattering_per_m) {
  Scene scene = lamps_scene(1, 1);
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.type = 1;
  lamp.position_m = {0, 0, 5};
  lamp.rotation_deg = {90, 0, 0};
  scene.rig.haze = {};
  scene.rig.haze.scattering_per_m = scattering_per_m;
  scene.rig.ambient_lx = 0;
  scene.rig.boxes = {{"wall", {-20, distance_m, 0}, {20, distance_m + 0.2, 12}, glm::dvec3(0.5)}};
  scene.rig.cameras = {{"beside", {0.5, 0, 5.5}, {0, distance_m, 5}, 20, 8}};
  scene.compile();
  for (const char* channel : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(0, channel, 1);
  scene.set(0, "Zoom", 40);
  return scene;
}

TEST_CASE("a spot of VRSL equals the beam's illuminance 6 m away and falls with the third power of the distance") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double distance_m : {6.0, 9.0, 12.0}) {
    CAPTURE(distance_m);
    const Scene scene = wall_at(distance_m, 0);
    const double physical = middle_of(draw_style(vulkan.device(), scene, PictureStyle::kPhysical));
    const double vrsl = middle_of(draw_style(vulkan.device(), scene, PictureStyle::kVrsl));
    REQUIRE(physical > 0);
    CHECK(vrsl / physical == doctest::Approx(6 / distance_m).epsilon(0.03));
  }
}

TEST_CASE("beams of VRSL and cards shine in the air before a surface, and not without haze") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Across the beam, which ends at the wall.
  const auto beside = [](double scattering_per_m) {
    Scene scene = wall_at(12, scattering_per_m);
    scene.rig.cameras.front() = {"side", {9, 5, 5}, {0, 5, 5}, 40, 8};
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    return scene;
  };
  for (const PictureStyle style : {PictureStyle::kVrsl, PictureStyle::kCard}) {
    CAPTURE(word_of(style));
    CHECK(middle_of(draw_style(vulkan.device(), beside(0.02), style)) > 0);
    CHECK(middle_of(draw_style(vulkan.device(), beside(0), style)) == 0);
  }
}

TEST_CASE("a shiny floor in the style of VRSL is as bright as a matt one") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = wall_at(8, 0);
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.5)});
  scene.rig.cameras.front() = {"low", {0, -6, 2}, {0, 2, 0}, 40, 8};
  scene.rig.ambient_lx = 50;
  const auto levels = scene.levels;
  const auto floor_of = [&](double gloss) {
    scene.rig.boxes.back().gloss.share = gloss;
    scene.compile();
    scene.levels = levels;
    return draw_style(vulkan.device(), scene, PictureStyle::kVrsl).rgb;
  };
  CHECK(floor_of(0.5) == floor_of(0));
}

TEST_CASE("a style has the passes that its words say, and none of the product's light in the haze") {
  for (const PictureStyle style : {PictureStyle::kPhysical, PictureStyle::kVrsl, PictureStyle::kCard}) {
    CHECK(must(picture_style_of(word_of(style))) == style);
    const auto has = [&](std::string_view name) {
      const PassList& passes = passes_of(style);
      return std::any_of(passes.begin(), passes.end(), [&](const PassEntry* pass) { return pass->name == name; });
    };
    CHECK(has("beams") == (style == PictureStyle::kPhysical));
    CHECK(has("gobos") == (style == PictureStyle::kPhysical));
    CHECK(has("haze"));  // lasers, displays and shafts read its table
  }
  const auto wrong = picture_style_of("VRSL");
  REQUIRE(!wrong);
  CHECK(wrong.error().message == "VRSL: expected physical, vrsl or card");
}

// A disco ball before a wall.
Scene disco_at(double distance_m) {
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"x\"\n[[fixture]]\nname = \"Ball\"\ntype = \"vrsl/disco-ball\"\nuniverse = 1\naddress = 1\n"
      "position = [0, 0, 5.4]\n",
      "x.toml"));
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = 0;
  scene.rig.boxes = {{"wall", {-40, distance_m, -30}, {40, distance_m + 0.2, 40}, glm::dvec3(0.5)}};
  scene.rig.cameras = {{"beside", {0, -1, 5}, {0, distance_m, 5}, 40, 8}};
  scene.compile();
  scene.set(0, "Dimmer", 1);
  return scene;
}

TEST_CASE("a disco ball of VRSL throws its map by the square of the level over the distance, and no beams") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto sum_at = [&](Scene& scene, double* most = nullptr) {
    const RadianceImage image = draw_style(vulkan.device(), scene, PictureStyle::kVrsl);
    double sum = 0;
    for (const float value : image.rgb) {
      sum += static_cast<double>(value);
      if (most != nullptr) *most = std::max(*most, static_cast<double>(value));
    }
    return sum;
  };
  Scene scene = disco_at(6);
  const double spot_cd = static_cast<double>(disco_balls(scene.rig, scene.compiled).at(0).spot_cd);
  CHECK(spot_cd == doctest::Approx(80 / (2 * 3.14159265 * (1 - std::cos(1.5 * 3.14159265 / 180)))).epsilon(1e-3));
  double most = 0;
  const double full = sum_at(scene, &most);
  const double spot = 0.5 / 3.14159265 * spot_cd / 36;  // 6 m away
  CHECK(most <= spot * 1.001);
  CHECK(most >= spot * 0.5);
  scene.slots(0)[0] = 51;
  CHECK(sum_at(scene) / full == doctest::Approx(0.04).epsilon(1e-3));
  scene.slots(0)[0] = 0;
  CHECK(sum_at(scene) == 0);
  // The map turns with the ball: 82 degrees in 10 s.
  const FrameSettings settings = settings_of(PictureStyle::kVrsl, judged_settings(32, 18));
  const auto frame =
      must(Frame::create(vulkan.device(), scene.rig, scene.compiled, settings, passes_of(PictureStyle::kVrsl)));
  scene.slots(0)[0] = 255;
  const auto first = draw(*frame, scene).rgb;
  frame->step(scene.levels, 10'000 * kMs);
  CHECK(draw(*frame, scene).rgb != first);
}

}  // namespace
}  // namespace footlight::render
