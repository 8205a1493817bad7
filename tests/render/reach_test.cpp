// Far objects, faint beams and beams after a change of size are drawn.
#include <cmath>
#include <cstdio>
#include <numeric>

#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

double sum_of(const RadianceImage& picture) { return std::accumulate(picture.rgb.begin(), picture.rgb.end(), 0.0); }

// One lamp that shines along +Y.
Scene one_lamp(double zoom_deg) {
  Scene scene = lamps_scene(1, 1);
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.type = 1;
  lamp.position_m = {0, 0, 5};
  lamp.rotation_deg = {90, 0, 0};
  scene.compile();
  scene.set(0, "Zoom", zoom_deg);
  return scene;
}

TEST_CASE("a frame whose size changes and changes back draws the same beams, without a step") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr std::size_t kCount = 200;  // four workgroups
  Scene scene = lamps_scene(60, kCount);
  std::vector<bool> lit;
  for (std::size_t i = 0; i < kCount; ++i) lit.push_back(i % 3 != 0);
  dim_lamps(scene, lit);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings());
  const RadianceImage before = draw(*frame, scene);
  const CountsRow counts = must(frame->read_counts());
  const auto heads = [&] {
    std::vector<std::uint32_t> rows;
    for (const BeamRow& beam : must(frame->read_beams())) rows.push_back(beam.head);
    return rows;
  };
  const std::vector<std::uint32_t> expected = heads();
  must(frame->change(judged_settings(30, 20)));
  must(frame->draw(view_of(scene.camera), 0));
  CHECK(heads() == expected);
  must(frame->change(judged_settings()));
  must(frame->draw(view_of(scene.camera), 0));
  CHECK(must(frame->read_counts()).live_count == counts.live_count);
  CHECK(must(frame->read_counts()).dark_count == counts.dark_count);
  CHECK(heads() == expected);
  CHECK(must(frame->read_radiance()).rgb == before.rgb);

  must(vulkan.device().run_once([&](VkCommandBuffer commands) { forget_states(commands, frame->resources()); }));
  must(frame->draw(view_of(scene.camera), 0));
  CHECK(must(frame->read_counts()).live_count == 0);
}

TEST_CASE("steps of a rig without fixtures use no memory") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene;
  scene.rig.boxes.push_back({"floor", {-1, -1, -1}, {1, 1, 0}, glm::dvec3(0.3)});
  scene.rig.cameras.emplace_back();
  scene.compile();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  for (int i = 0; i < 3; ++i) (void)draw(*frame, scene);
  CHECK(frame->pending_steps() == 0);
}

TEST_CASE("after a blackout a picture without surfaces is black") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_lamp(16);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings());
  CHECK(sum_of(draw(*frame, scene)) > 0);
  dim_lamps(scene, {false});
  CHECK(sum_of(draw(*frame, scene)) == 0);
  CHECK(must(frame->read_counts()).live_count == 0);
}

// A floor and a lamp above it, both at this distance from the camera.
Scene far_floor(double distance_m) {
  Scene scene = one_lamp(20);
  scene.rig.fixtures.front().position_m = {0, distance_m, 20};
  scene.rig.fixtures.front().rotation_deg = {0, 0, 0};  // down
  scene.rig.haze.scattering_per_m = scene.rig.haze.absorption_per_m = 0;
  scene.rig.boxes.push_back({"floor", {-6, distance_m - 6, -1}, {6, distance_m + 6, 0}, {0.5, 0.4, 0.3}});
  scene.rig.cameras = {
      {"far", {0, 0, distance_m / 10}, {0, distance_m, 0}, 2 * std::atan(4 / distance_m) / kDegree, 4}};
  scene.compile();
  scene.set(0, "Zoom", 20);
  return scene;
}

PictureNorms far_norms(vk::Device& device, const Scene& scene, const char* what) {
  const RadianceImage picture = draw_new(device, scene, judged_settings(32, 18));
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgedImage judged =
      judge_image(judge_scene(scene.rig, walker), view_of(scene.camera), 32, 18, {.stated_error = false});
  CHECK(std::accumulate(judged.rgb.begin(), judged.rgb.end(), 0.0) > 0.1);
  const PictureNorms norms = picture_norms(picture.rgb, judged.rgb);
  std::fprintf(stderr, "%s: relL2 %.3g, max %.3g\n", what, norms.rel_l2, norms.max);
  CHECK(norms.nonfinite == 0);
  return norms;
}

TEST_CASE("a lit floor is drawn as the judge computes it at 990 m, 1010 m and 9 km") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Floats at 9 km have steps of 1 mm: 2.5e-4 of the beam's radius.
  CHECK(far_norms(vulkan.device(), far_floor(990), "990 m").rel_l2 < 1e-3);
  CHECK(far_norms(vulkan.device(), far_floor(1010), "1010 m").rel_l2 < 1e-3);
  CHECK(far_norms(vulkan.device(), far_floor(9000), "9 km").rel_l2 < 1e-3);
}

TEST_CASE("a beam in haze is drawn as the judge computes it 9 km away") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = far_floor(9000);
  scene.rig.boxes.clear();
  scene.rig.haze = {1e-5, 0, 0.3, 30};
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  CHECK(far_norms(vulkan.device(), scene, "haze, 9 km").rel_l2 < 1e-3);
}

TEST_CASE("light reaches the other end of a rig that is 3 km long") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_lamp(1);
  scene.rig.haze = {0, 0, 0, 0};
  scene.rig.boxes.push_back({"wall", {-50, 3000, -50}, {50, 3001, 50}, glm::dvec3(0.5)});
  scene.rig.cameras = {{"near the wall", {0, 2900, 5}, {0, 3000, 5}, 40, 4}};
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  CHECK(light_range_m(scene.rig) > 3000);
  CHECK(far_norms(vulkan.device(), scene, "wall at 3 km").rel_l2 < 1e-3);
}

TEST_CASE("a lamp of a thousandth of a lumen gives a ten-millionth of the light of 10,000 lm with default settings") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_lamp(16);
  scene.rig.boxes.push_back({"wall", {-20, 8, -20}, {20, 9, 20}, glm::dvec3(0.5)});
  FrameSettings settings;
  settings.width = 32;
  settings.height = 18;
  settings.bodies = false;
  const auto light = [&](double flux_lm) {
    scene.rig.types[1].beams[0].flux_lm = flux_lm;
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    return sum_of(draw_new(vulkan.device(), scene, settings));
  };
  const double bright = light(10'000);
  CHECK(bright > 1);
  CHECK(light(1.01) == doctest::Approx(1.01e-4 * bright).epsilon(1e-4));
  CHECK(light(0.99) == doctest::Approx(0.99e-4 * bright).epsilon(1e-4));
  CHECK(light(0.001) == doctest::Approx(1e-7 * bright).epsilon(1e-4));
}

}  // namespace
}  // namespace footlight::render
