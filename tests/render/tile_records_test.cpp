// Beams whose tiles show several surfaces, and beams with gobos, taken together against pixel by pixel.
#include <cstdio>
#include <string>

#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// Share of the beams of all pixels that are computed for the pixel alone.
double general_share(vk::Device& device, const Scene& scene, FrameSettings settings) {
  settings.view = FrameView::kClasses;
  settings.tile_beams = 0;
  const RadianceImage classes = draw_new(device, scene, settings);
  double general = 0, all = 0;
  for (std::size_t i = 0; i < classes.rgb.size(); ++i) {
    all += classes.rgb[i];
    if (i % 3 == 0) general += classes.rgb[i];
  }
  REQUIRE(all > 0);
  return general / all;
}

// The picture with tiles against that without.
void check_against_general(vk::Device& device, const Scene& scene, FrameSettings settings, const std::string& what,
                           double rel_l2_max = 5e-4, double max_error = 3e-2) {
  settings.tile_beams = 0;
  settings.tile_error = 0;
  const auto frame = make_frame(device, scene, settings);
  const RadianceImage general = draw(*frame, scene);
  const std::vector<double> reference(general.rgb.begin(), general.rgb.end());
  for (const double error : {1e-5, 4e-3}) {
    settings.tile_error = error;
    must(frame->change(settings));
    const RadianceImage tiles = draw(*frame, scene);
    const PictureNorms norms = picture_norms(tiles.rgb, reference);
    std::fprintf(stderr, "%s, tile error %.1g: relL2 %.3g, max %.3g\n", what.c_str(), error, norms.rel_l2, norms.max);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < (error > 1e-4 ? rel_l2_max : 1e-5));
    CHECK(norms.max < max_error);
    CHECK(draw(*frame, scene).rgb == tiles.rgb);
  }
}

// Lamps above a floor with posts, before which and behind which beams pass.
Scene posts_scene(int count) {
  Scene scene = lamps_scene(41, count);
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  scene.rig.boxes.push_back({"wall", {-20, 12, 0}, {20, 12.2, 12}, glm::dvec3(0.3)});
  Random random(42);
  for (int i = 0; i < 80; ++i) {
    const glm::dvec3 foot(random.between(-8, 8), random.between(-4, 10), 0);
    scene.rig.boxes.push_back({"post", foot, foot + glm::dvec3(0.1, 0.1, 7), glm::dvec3(0.3)});
  }
  scene.rig.cameras.front() = {"near", {0, -14, 3}, {0, 0, 3}, 16, 4};
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  scene.levels = levels;
  return scene;
}

TEST_CASE("beams that several surfaces of a tile cut are taken together") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = posts_scene(200);
  FrameSettings settings = judged_settings(320, 180);
  settings.shadows = false;
  check_against_general(vulkan.device(), scene, settings, "posts");
  settings.tile_error = FrameSettings{}.tile_error;
  const double share = general_share(vulkan.device(), scene, settings);
  std::fprintf(stderr, "posts: %.1f %% pixel by pixel\n", 100 * share);
  CHECK(share < 0.45);
}

// Lamps that shine down beside each other in front of the camera, with a star in each.
Scene gobos_scene(bool turned) {
  Scene scene = gates_scene(1);
  const int slots = scene.rig.types[0].modes[0].slot_count;
  const int per_universe = kSlotCountMax / slots;
  for (int i = 1; i < 40; ++i) {
    fixtures::PatchedFixture lamp = scene.rig.fixtures[0];
    lamp.name = "Lamp " + std::to_string(i + 1);
    lamp.universe = 1 + i / per_universe;
    lamp.address = 1 + i % per_universe * slots;
    scene.rig.fixtures.push_back(lamp);
  }
  Random random(43);
  scene.rig.boxes.clear();
  scene.rig.cameras.front() = {"beside", {0, -14, 3}, {0, 0, 3}, 6, 4};
  scene.camera = scene.rig.cameras.front();
  for (fixtures::PatchedFixture& lamp : scene.rig.fixtures) {
    lamp.position_m = {random.between(-1, 1), random.between(-1, 1), 7};
    lamp.rotation_deg = {turned ? random.between(-20, 20) : 0.0, 0, turned ? random.between(-180, 180) : 0.0};
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    scene.set(i, "Zoom", random.between(6, 24));
    scene.set(i, "Gobo1WheelIndex", 270);
    scene.set(i, "Gobo1Pos", random.between(0, 360));
  }
  return scene;
}

TEST_CASE("beams with gobos whose chords cross the whole disc are taken together") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const bool turned : {false, true}) {
    const Scene scene = gobos_scene(turned);
    FrameSettings settings = judged_settings(128, 72);
    settings.gobo_method = GoboMethod::kTables;
    const std::string what = turned ? "turned gobos" : "gobos";
    check_against_general(vulkan.device(), scene, settings, what);
    settings.tile_error = FrameSettings{}.tile_error;
    const double share = general_share(vulkan.device(), scene, settings);
    std::fprintf(stderr, "%s: %.1f %% pixel by pixel\n", what.c_str(), 100 * share);
    CHECK(share < 0.8);  // without the others, which a lens cuts, 1
  }
}

TEST_CASE("beams with gobos that are taken together have their shadows, and their light with any number of nodes") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gobos_scene(false);
  FrameSettings settings = judged_settings(128, 72);
  settings.gobo_method = GoboMethod::kTables;
  settings.nodes = 5;
  check_against_general(vulkan.device(), scene, settings, "gobos, 5 nodes");
  settings.nodes = 3;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", 50);  // smooth over tiles
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"roof", {-2, -2, 6}, {-0.2, 2, 6.1}, glm::dvec3(0.3)});  // above the picture
  scene.compile();
  scene.levels = levels;
  // Whole chords by their table, and less of them by sums along lines: 8.2e-4 on lavapipe.
  check_against_general(vulkan.device(), scene, settings, "gobos with shadows", 2e-3);
}

TEST_CASE("beams nearly across the view go on to the sky beside posts") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(44, 120);
  const std::vector<std::uint8_t> levels = scene.levels;
  for (fixtures::PatchedFixture& lamp : scene.rig.fixtures) lamp.rotation_deg = {0, 0, 0};
  Random random(45);
  for (int i = 0; i < 30; ++i) {
    const glm::dvec3 foot(random.between(-4, 4), random.between(-4, 10), 0);
    scene.rig.boxes.push_back({"post", foot, foot + glm::dvec3(0.1, 0.1, 7), glm::dvec3(0.3)});
  }
  scene.rig.cameras.front() = {"level", {0, -14, 3}, {0, 0, 3}, 20, 4};
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  scene.levels = levels;
  FrameSettings settings = judged_settings(321, 181);
  settings.shadows = false;
  // A dim pixel in a bright tile: 3.6e-2 on lavapipe.
  check_against_general(vulkan.device(), scene, settings, "level camera", 5e-4, 5e-2);
}

}  // namespace
}  // namespace footlight::render
