// Shadows of lenses with a size: pictures compared with the judge's straight lines from places on the lens.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/live_error.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// A lens of 24 cm, a wall 8 m away, and two boxes in its beam.
Scene large_lens(Scene scene = optics_scene(false)) {
  scene.rig.types.front().beams.front().radius_m = 0.12;
  scene.rig.boxes.push_back({"in front", {-0.6, 3, 2.9}, {0.1, 3.3, 3.2}, glm::dvec3(0.5)});
  scene.rig.boxes.push_back({"behind", {0.2, 5, 2.2}, {0.9, 5.5, 3.1}, glm::dvec3(0.5)});
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  return scene;
}

JudgedImage judged(const Scene& scene, std::vector<glm::dvec2> lens, int width, int height) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  judge.lens = std::move(lens);
  return judge_image(judge, view_of(scene.camera), width, height, {.tolerance = 1e-5, .stated_error = false});
}

FrameSettings soft_settings(unsigned points, int width = 32, int height = 18) {
  FrameSettings settings = judged_settings(width, height);
  settings.nodes = 5;
  settings.gobo_taps = 256;
  settings.gobo_method = GoboMethod::kTaps;
  settings.penumbra = points;
  return settings;
}

TEST_CASE("shadows from 4 points of a lens are nearer to the judge's whole disc than hard ones, from 7 points nearer") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = large_lens();
  const JudgedImage disc = judged(scene, judge_lens(150), 32, 18);
  const double hard = picture_norms(draw_new(vulkan.device(), scene, soft_settings(1)).rgb, disc.rgb).rel_l2;
  Scene black = scene;
  for (fixtures::StageBox& box : black.rig.boxes) box.albedo = glm::dvec3(0);
  black.rig.ambient_lx = 0;
  black.compile();
  black.levels = scene.levels;
  const JudgedImage dark = judged(black, judge_lens(150), 32, 18);
  double before = hard;
  for (const unsigned points : {4u, 7u}) {
    const PictureNorms norms = picture_norms(draw_new(vulkan.device(), scene, soft_settings(points)).rgb, disc.rgb);
    const PictureNorms air = picture_norms(draw_new(vulkan.device(), black, soft_settings(points)).rgb, dark.rgb);
    std::fprintf(stderr, "%u points: relL2 %.3g, max %.3g; in the air %.3g; hard %.3g\n", points, norms.rel_l2,
                 norms.max, air.rel_l2, hard);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < before / (points == 4 ? 12 : 1));
    CHECK(air.rel_l2 < hard / 12);
    before = norms.rel_l2;
  }
}

TEST_CASE("whatever shapes a beam, its shadows from 4 points of the lens are nearer to its disc than hard ones") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto check = [&](const Scene& lamp, const char* what) {
    const Scene scene = large_lens(lamp);
    const JudgedImage disc = judged(scene, judge_lens(100), 32, 18);
    const PictureNorms soft = picture_norms(draw_new(vulkan.device(), scene, soft_settings(4)).rgb, disc.rgb);
    const PictureNorms hard = picture_norms(draw_new(vulkan.device(), scene, soft_settings(1)).rgb, disc.rgb);
    std::fprintf(stderr, "%s: relL2 %.3g, hard %.3g\n", what, soft.rel_l2, hard.rel_l2);
    CHECK(soft.nonfinite == 0);
    CHECK(soft.rel_l2 < hard.rel_l2 / 6);
  };
  Scene scene = optics_scene(false);
  scene.set(0, "Gobo1WheelIndex", 2);
  scene.set(0, "Blade1A", 0.3);
  check(scene, "gobo and blade");
  check(rectangle_scene(2.5, 30, 2), "rectangle");
}

TEST_CASE("bodies behind others hide what the judge says of a lens with a size, without a live error") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  scene.rig.types.front().beams.front().radius_m = 0.12;
  scene.rig.boxes.front().albedo = glm::dvec3(0);
  const glm::dvec3 black(0);
  scene.rig.boxes.push_back({"first", {-0.3, 1.5, 2.8}, {0.05, 1.6, 3.1}, black});
  for (int i = 0; i < 30; ++i) {
    const double y = 1.7 + 0.1 * i;
    scene.rig.boxes.push_back({"behind", {-0.2, y, 2.85}, {0, y + 0.05, 3.05}, black});
  }
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  const auto frame = make_frame(vulkan.device(), scene, soft_settings(4));
  const PictureNorms norms = picture_norms(draw(*frame, scene).rgb, judged(scene, judge_lens(100), 32, 18).rgb);
  CHECK(must(frame->read_counts()).shadows >= 31);  // pairs, not pairs and points
  const auto live = must(LiveError::create(vulkan.device(), *frame, scene.compiled.needs));
  for (int i = 0; i < 8; ++i) {
    must(vulkan.device().run_once([&](VkCommandBuffer commands) { live->record(commands); }));
    must(live->take(i));
  }
  const double live_error = live->estimate().rel_l2;
  std::fprintf(stderr, "behind others: relL2 %.3g, max %.3g, live error %.3g\n", norms.rel_l2, norms.max, live_error);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < 2e-2);
  CHECK(live_error < 1e-3);
}

// 200 washes above a stage with boxes, with lenses of 20 cm.
TEST_CASE("beams that are taken together for tiles have the soft shadows of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Random random(26);
  Scene scene = lamps_above_boxes(random);
  for (fixtures::FixtureType& type : scene.rig.types) type.beams.front().radius_m = 0.1;
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", random.between(10, 40));
  FrameSettings settings = judged_settings(128, 72);
  settings.penumbra = 4;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage each = draw(*frame, scene);
  settings.tile_error = FrameSettings{}.tile_error;
  must(frame->change(settings));
  const RadianceImage together = draw(*frame, scene);
  const PictureNorms norms = picture_norms(together, each);
  CHECK(draw(*frame, scene).rgb == together.rgb);
  settings.penumbra = 1;
  must(frame->change(settings));
  const PictureNorms hard = picture_norms(draw(*frame, scene), each);
  std::fprintf(stderr, "tiles with soft shadows: relL2 %.3g, max %.3g; hard %.3g\n", norms.rel_l2, norms.max,
               hard.rel_l2);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < 5e-5);
  CHECK(norms.rel_l2 > 0);  // some are taken together
  CHECK(hard.rel_l2 > 3 * norms.rel_l2);
}

TEST_CASE("a lens half in a box gives half its light, and one in a box, a wall or behind a plate only finite light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto light = [&](const std::vector<fixtures::StageBox>& boxes, unsigned points) {
    Scene scene = optics_scene(false);
    scene.rig.types.front().beams.front().radius_m = 0.12;
    scene.rig.boxes.insert(scene.rig.boxes.end(), boxes.begin(), boxes.end());
    const std::vector<std::uint8_t> levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    const RadianceImage drawn = draw_new(vulkan.device(), scene, soft_settings(points));
    double sum = 0;
    bool finite = true;
    for (const float value : drawn.rgb) {
      finite = finite && std::isfinite(value) && value >= 0;
      sum += static_cast<double>(value);
    }
    CHECK(finite);
    return sum;
  };
  const glm::dvec3 black(0);
  for (const unsigned points : {4u, 7u}) {
    const double all = light({}, points);
    CHECK(light({{"around", {-0.3, -0.3, 2.7}, {0.3, 0.3, 3.3}, black}}, points) < 1e-6 * all);
    // A box from the lens plane on, before the lower half of the lens.
    const double half = light({{"half", {-0.5, 0, 2}, {0.5, 0.01, 3}, black}}, points);
    CHECK(half == doctest::Approx(0.5 * all).epsilon(points == 4 ? 0.1 : 0.2));
    CHECK(light({{"wall that ends in the lens plane", {-3, -0.3, 0}, {3, 0, 6}, black}}, points) > 0.2 * all);
    const double plate = light({{"plate", {-0.2, 2, 2.8}, {0.2, 2, 3.2}, black}}, points);
    CHECK(plate < 0.98 * all);
    CHECK(plate > 0.3 * all);
  }
}

TEST_CASE("a frame made for hard shadows refuses soft ones, and shadow maps stay hard") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = large_lens();
  FrameSettings settings = soft_settings(1, 16, 9);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  settings.penumbra = 4;
  const auto refused = frame->change(settings);
  REQUIRE(!refused);
  CHECK(refused.error().message.find("from 1 points of a lens, not 4: expected a new frame") != std::string::npos);
  settings.penumbra = 5;
  CHECK(!frame->change(settings));
  settings.penumbra = 4;
  settings.shadow_map_px = 64;
  const RadianceImage soft = draw_new(vulkan.device(), scene, settings);
  settings.penumbra = 1;
  CHECK(draw_new(vulkan.device(), scene, settings).rgb == soft.rgb);
}

}  // namespace
