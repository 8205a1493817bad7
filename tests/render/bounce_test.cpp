// Light that surfaces reflect to others: pictures compared with traced paths, and what must not change.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/bounce_tables.h"
#include "render/frame.h"
#include "render/reference/bounce_judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using namespace render::testing;
using footlight::testing::HeadlessVulkan;
using glm::dvec3;

constexpr int kWidth = 16, kHeight = 9;

FrameSettings bounce_settings(int width = kWidth, int height = kHeight) {
  FrameSettings settings = judged_settings(width, height);
  settings.nodes = 5;
  settings.bounce = true;
  return settings;
}

// Two washes in a room of 6 x 8 x 4 m with coloured walls and a box, seen from a corner.
Scene room_scene() {
  Scene scene = lamps_scene(4, 2);
  scene.rig.boxes = {
      {"floor", {-3, -4, -0.2}, {3, 4, 0}, {0.5, 0.5, 0.5}},   {"ceiling", {-3, -4, 4}, {3, 4, 4.2}, {0.7, 0.7, 0.7}},
      {"left", {-3.2, -4, 0}, {-3, 4, 4}, {0.7, 0.1, 0.1}},    {"right", {3, -4, 0}, {3.2, 4, 4}, {0.1, 0.6, 0.1}},
      {"back", {-3, 4, 0}, {3, 4.2, 4}, {0.6, 0.6, 0.6}},      {"front", {-3, -4.2, 0}, {3, -4, 4}, {0.6, 0.6, 0.6}},
      {"box", {0.4, 0.5, 0}, {1.6, 1.7, 1.5}, {0.6, 0.6, 0.2}}};
  scene.rig.fixtures[0].position_m = {-1, -0.5, 3.7};
  scene.rig.fixtures[1].position_m = {1, 1, 3.6};
  for (auto& fixture : scene.rig.fixtures) {
    fixture.type = 1;
    fixture.rotation_deg = {0, 0, 0};
  }
  scene.rig.fixtures[1].rotation_deg = {35, 0, 0};
  scene.rig.haze.scattering_per_m = 0;  // without haze there are fewer pipelines
  scene.rig.cameras = {{"corner", {-2.6, -3.6, 1.8}, {0.8, 1.5, 1.2}, 70, 4}};
  scene.compile();
  scene.camera = scene.rig.cameras.front();
  for (std::size_t i = 0; i < 2; ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, i == 0 ? 1 : 0.6);
    scene.set(i, "Dimmer", 1);
    scene.set(i, "Zoom", 60);
  }
  return scene;
}

struct Judged {
  std::vector<double> direct;
  std::vector<double> all;
};

Judged judged(const Scene& scene, int side) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  const View view = view_of(scene.camera);
  Judged result;
  result.direct = judge_image(judge, view, kWidth, kHeight, {.tolerance = 1e-3, .stated_error = false}).rgb;
  result.all = judge_reflected(path_scene(judge), scene.rig.haze, view, kWidth, kHeight, {.side = side, .bounces = 8});
  for (std::size_t i = 0; i < result.all.size(); ++i) result.all[i] += result.direct[i];
  return result;
}

// The picture, and the light that is reflected alone, compared with traced paths.
void check(const HeadlessVulkan& vulkan, const Scene& scene, const char* what, int side, double picture_max,
           double reflected_max) {
  const Judged judge = judged(scene, side);
  const RadianceImage with = draw_new(vulkan.device(), scene, bounce_settings());
  const PictureNorms norms = picture_norms(with.rgb, judge.all);
  std::vector<float> reflected(with.rgb.size());
  std::vector<double> paths(with.rgb.size());
  double sum = 0, path_sum = 0, square = 0, lost = 0;
  for (std::size_t i = 0; i < reflected.size(); ++i) {
    paths[i] = judge.all[i] - judge.direct[i];
    reflected[i] = static_cast<float>(static_cast<double>(with.rgb[i]) - judge.direct[i]);
    sum += static_cast<double>(reflected[i]);
    path_sum += paths[i];
    square += judge.all[i] * judge.all[i];
    lost += paths[i] * paths[i];
  }
  const PictureNorms own = picture_norms(reflected, paths);
  std::fprintf(stderr,
               "%s: relL2 %.3g, without reflected light %.3g; of reflected light %.3g, its sum %.4f of the paths'\n",
               what, norms.rel_l2, std::sqrt(lost / square), own.rel_l2, sum / path_sum);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < picture_max);
  CHECK(own.rel_l2 < reflected_max);
  CHECK(std::abs(sum / path_sum - 1) < 0.04);
}

TEST_CASE("boxes reflect light to each other as traced paths say") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  check(vulkan, room_scene(), "room", 20, 3e-2, 0.15);
  if (!footlight::testing::runs_long_tests()) return;
  check(vulkan, room_scene(), "room, 16 times the paths", 80, 2e-2, 0.1);
  // What shapes a beam, on a wall whose light reaches a floor and a box beside it.
  const auto check_wall = [&](Scene scene, const char* what) {
    scene.rig.haze.scattering_per_m = 0;
    scene.rig.boxes.push_back({"floor", {-4, 2, -0.2}, {4, 8, 0}, dvec3(0.5)});
    scene.rig.boxes.push_back({"box", {-2.5, 5, 0}, {-1.5, 6, 2}, dvec3(0.6)});
    const std::vector<std::uint8_t> levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    check(vulkan, scene, what, 40, 2e-2, 0.2);
  };
  Scene scene = optics_scene(false);
  scene.set(0, "Gobo1WheelIndex", 1);
  scene.set(0, "Iris", 0.8);
  check_wall(scene, "gobo and iris");
  scene = optics_scene(false);
  scene.set(0, "Blade1A", 0.3);
  scene.set(0, "Prism1", 1);
  check_wall(scene, "blade and prism");
  check_wall(rectangle_scene(2.5, 30, 2), "rectangle");
}

TEST_CASE("reflected light is the same to the bit in each picture and each frame") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = room_scene();
  const auto frame = make_frame(vulkan.device(), scene, bounce_settings());
  const RadianceImage first = draw(*frame, scene);
  CHECK(draw(*frame, scene).rgb == first.rgb);
  FrameSettings other = bounce_settings();
  other.bounce = false;
  must(frame->change(other));
  const RadianceImage off = draw(*frame, scene);
  CHECK(off.rgb != first.rgb);
  CHECK(draw_new(vulkan.device(), scene, other).rgb == off.rgb);
  must(frame->change(bounce_settings()));
  CHECK(draw(*frame, scene).rgb == first.rgb);
  // A frame that was made without has none of its buffers.
  const auto without = make_frame(vulkan.device(), scene, other);
  CHECK_FALSE(without->change(bounce_settings()).has_value());
  CHECK(without->resources().rig.bounce_forms.size_bytes <= 16);
  CHECK(frame->bytes() > without->bytes());
}

TEST_CASE("no light that a floor reflects reaches what is below it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // A riser on a lit floor, and one in the dark below that floor, which is 5 cm thick.
  Scene scene = lamps_scene(4, 1);
  scene.rig.boxes = {{"floor", {-4, -4, 1.95}, {4, 4, 2}, dvec3(0.8)}};
  fixtures::Scenery riser = fixtures::default_scenery(fixtures::SceneryKind::kRiser);
  riser.position_m = {-1.5, 0, 2};
  scene.rig.scenery.push_back(riser);
  riser.position_m = {1.5, 0, 0.8};
  scene.rig.scenery.push_back(riser);
  scene.rig.fixtures[0].position_m = {0.5, -2.5, 6};
  scene.rig.fixtures[0].rotation_deg = {0, 0, 0};
  scene.rig.fixtures[0].type = 1;
  scene.rig.cameras = {{"above", {-1.5, -9, 3}, {-1.5, 0, 2.1}, 10, 4}, {"below", {1.5, -9, 1}, {1.5, 0, 1}, 10, 4}};
  scene.compile();
  for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(0, color, 1);
  scene.set(0, "Dimmer", 1);
  scene.set(0, "Zoom", 12);  // beside the riser
  FrameSettings settings = bounce_settings(8, 8);
  settings.bodies = true;
  settings.view = render::FrameView::kLux;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const auto brightest = [&](const fixtures::Camera& camera) {
    scene.camera = camera;
    const RadianceImage lux = draw(*frame, scene);
    return static_cast<double>(*std::max_element(lux.rgb.begin(), lux.rgb.end()));
  };
  const double above = brightest(scene.rig.cameras[0]), below = brightest(scene.rig.cameras[1]);
  std::fprintf(stderr, "above the floor %.4g lx, below %.4g lx\n", above, below);
  CHECK(above > 1);
  CHECK(below < 1e-3 * above);
}

TEST_CASE("the patches and probes of the demo are within their limits and made in little time") {
  const auto begin = std::chrono::steady_clock::now();
  const BounceScene scene = bounce_scene(fixtures::demo_rig(), {}, true);
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  std::fprintf(stderr, "demo: %zu solids, %zu patches, %zu probes %.2f m apart, in %.1f ms\n", scene.solids.size(),
               scene.patches.size(), scene.probes.size(), static_cast<double>(scene.grid.low.w), ms);
  CHECK(scene.patches.size() > FL_BOUNCE_PATCHES_MAX / 2);
  CHECK(scene.patches.size() <= FL_BOUNCE_PATCHES_MAX);
  CHECK(scene.probes.size() > FL_BOUNCE_PROBES_MAX / 2);
  CHECK(scene.probes.size() <= FL_BOUNCE_PROBES_MAX);
  // The stage floor covers a part of the house floor, and risers a part of the stage floor.
  const auto covered = [](const BouncePatchRow& patch) { return patch.exposed != 0xffffu; };
  CHECK(std::count_if(scene.patches.begin(), scene.patches.end(), covered) > 10);
}

}  // namespace
