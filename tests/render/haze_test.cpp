// Haze that is not even: pictures compared with the judge's march through the same field.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr std::int64_t kTimeNs = 90'000 * kMs;

Scene cloudy(Scene scene) {
  fixtures::Haze& haze = scene.rig.haze;
  haze.noise = 0.5;
  haze.size_m = 3;
  haze.wind_m_s = {0.3, 0.1, -0.05};
  haze.seed = 7;
  haze.height_m = 6;
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  return scene;
}

JudgeScene judge_of(const Scene& scene) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  return judge_scene(scene.rig, walker, gobos_of_judge(scene), kTimeNs);
}
JudgedImage judged(const JudgeScene& judge, const Scene& scene, const FrameSettings& settings) {
  return judge_image(judge, view_of(scene.camera), settings.width, settings.height,
                     {.tolerance = 1e-4, .stated_error = false});
}

RadianceImage picture_at(Frame& frame, const Scene& scene) {
  frame.step(scene.levels, kTimeNs);
  must(frame.draw(view_of(scene.camera), scene.camera.exposure_ev));
  return must(frame.read_radiance());
}

PictureNorms against_judge(vk::Device& device, const Scene& scene, const FrameSettings& settings, const char* what) {
  const JudgeScene judge = judge_of(scene);
  const auto frame = make_frame(device, scene, settings);
  const RadianceImage drawn = picture_at(*frame, scene);
  const PictureNorms norms = picture_norms(drawn.rgb, judged(judge, scene, settings).rgb);
  std::fprintf(stderr, "haze, %s: relL2 %.3g, p99 %.3g, max %.3g", what, norms.rel_l2, norms.p99, norms.max);
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) {
    JudgeScene other = judge;
    other.density = {};
    std::fprintf(stderr, "; even haze %.3g", picture_norms(drawn.rgb, judged(other, scene, settings).rgb).rel_l2);
    other = judge;
    other.even_extinction = false;
    std::fprintf(stderr, "; true loss %.3g", picture_norms(drawn.rgb, judged(other, scene, settings).rgb).rel_l2);
  }
  std::fprintf(stderr, "\n");
  CHECK(norms.nonfinite == 0);
  return norms;
}

TEST_CASE("clouds of haze in a picture are those that the judge marches through") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Washes, pars, and profiles with gobos, on a stage of boxes.
  const Scene scene = cloudy(demo_scene(78, true));
  CHECK(against_judge(vulkan.device(), scene, judged_settings(24, 14), "demo").rel_l2 < 5e-3);
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") == nullptr) return;
  for (const double noise : {0.5, 1.0}) {
    for (const double size_m : {2.0, 3.0}) {
      Scene other = scene;
      other.rig.haze.noise = noise;
      other.rig.haze.size_m = size_m;
      const std::string what = "noise " + std::to_string(noise) + ", size " + std::to_string(size_m);
      against_judge(vulkan.device(), other, judged_settings(24, 14), what.c_str());
    }
  }
}

TEST_CASE("beams in clouds of haze that are taken together for tiles give the picture of beams pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = cloudy(lamps_scene(21, 150));
  FrameSettings settings = judged_settings(128, 72);
  settings.tile_beams = 0;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage general = picture_at(*frame, scene);
  settings.tile_error = 4e-3;
  must(frame->change(settings));
  frame->forget_air();
  const RadianceImage tiles = picture_at(*frame, scene);
  const std::vector<double> reference(general.rgb.begin(), general.rgb.end());
  const PictureNorms norms = picture_norms(tiles.rgb, reference);
  std::fprintf(stderr, "haze, tiles: relL2 %.3g, p99 %.3g\n", norms.rel_l2, norms.p99);
  CHECK(norms.rel_l2 > 0);  // some were taken together
  CHECK(norms.rel_l2 < 2e-3);
  // The same frame, and another one that plays to the same time in steps.
  frame->forget_air();
  CHECK(picture_at(*frame, scene).rgb == tiles.rgb);
  const auto played = make_frame(vulkan.device(), scene, settings);
  for (int i = 0; i < 3; ++i) played->step(scene.levels, kTimeNs / 3);
  must(played->draw(view_of(scene.camera), scene.camera.exposure_ev));
  CHECK(must(played->read_radiance()).rgb == tiles.rgb);
  // Time moves the clouds.
  CHECK(picture_at(*played, scene).rgb != tiles.rgb);
}

TEST_CASE("a rig that asks for no clouds has the pipelines and the picture of even haze") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene even = lamps_scene(5, 3);
  Scene still = cloudy(even);
  still.rig.haze.noise = 0;
  still.rig.haze.height_m = 0;
  still.compile();
  still.levels = even.levels;
  const FrameSettings settings = judged_settings(32, 18);
  const auto frame = make_frame(vulkan.device(), still, settings);
  for (const PassPlan& pass : frame->plan()) {
    CHECK(pass.name != "haze");
    CHECK(std::count(pass.constants.begin(), pass.constants.end(), vk::SpecConstant{FL_SPEC_HAZE, 1}) == 0);
  }
  CHECK(draw(*frame, still).rgb == draw_new(vulkan.device(), even, settings).rgb);
  CHECK(make_frame(vulkan.device(), cloudy(even), settings)->bytes() - frame->bytes() > 8 << 20);
}

}  // namespace
