// Pictures of the GPU compared with the judge in double and with each other, at every size.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <malloc.h>

#include "fixtures/gobos/gobo.h"
#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

PictureNorms against_judge(vk::Device& device, const Scene& scene, const FrameSettings& settings, const char* what,
                           double tolerance = 1e-5) {
  const RadianceImage picture = draw_new(device, scene, settings);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  // The judge computes its picture at a hundredth of its tolerance, 1e-7, below the resolution of a float picture.
  const JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  const JudgedImage judged = judge_image(judge, view_of(scene.camera), settings.width, settings.height,
                                         {.tolerance = tolerance, .stated_error = false});
  const PictureNorms norms = picture_norms(picture.rgb, judged.rgb);
  std::fprintf(stderr, "%s: relL2 %.3g, p99 %.3g, max %.3g\n", what, norms.rel_l2, norms.p99, norms.max);
  CHECK(norms.nonfinite == 0);
  double brightest = 0;
  for (const double value : judged.rgb) brightest = std::max(brightest, value);
  CHECK(brightest > 0);
  return norms;
}

// One lamp 5 m above the origin of the stage that shines along +Y.
Scene one_lamp_scene() {
  Scene scene = lamps_scene(1, 1);
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.type = 1;
  lamp.position_m = {0, 0, 5};
  lamp.rotation_deg = {90, 0, 0};
  scene.compile();
  scene.set(0, "Zoom", 16);
  return scene;
}

// Bounds of relL2 are three times the values measured on lavapipe with 3 nodes and 32 gobo samples (64 x 36 pixels),
// because the error depends on the levels. Measured: 6.4e-5 for beams over the demo rig (profiles m = 1, 2 and 3),
// 1.2e-5 for light on boxes alone.
constexpr double kBeamsMax = 2e-4;
constexpr double kSurfacesMax = 4e-5;
// Measured: 6.7e-3 with gobos, because 32 samples resolve an edge only to 1/32 of the ray's part in the beam.
constexpr double kGobosMax = 2e-2;

TEST_CASE("pictures of the demo rig agree with the judge") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(11, false);
  CHECK(against_judge(vulkan.device(), scene, judged_settings(), "demo rig, front").rel_l2 < kBeamsMax);
  scene.camera = scene.rig.cameras.at(2);
  CHECK(against_judge(vulkan.device(), scene, judged_settings(), "demo rig, close").rel_l2 < kBeamsMax);
}

TEST_CASE("pictures of the demo rig with gobos agree with the judge") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(12, true);
  CHECK(against_judge(vulkan.device(), scene, judged_settings(), "demo rig, gobos").rel_l2 < kGobosMax);
}

TEST_CASE("everything that shapes a beam is drawn as the judge computes it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    std::vector<std::pair<const char*, double>> values;
    double rel_l2_max;  // twice the value on lavapipe (32 x 18 pixels, 32 gobo samples), or 1e-5
  };
  for (const Case& each : {
           Case{"open", {}, 1e-5},
           Case{"iris", {{"Iris", 0.4}}, 1e-5},
           Case{"frost", {{"Frost1", 0.5}}, 2e-5},
           Case{"blades", {{"Blade1A", 0.4}, {"Blade2A", 0.3}, {"Blade4A", 0.6}, {"Blade4Rot", 20}}, 1e-5},
           Case{"prism", {{"Prism1", 2}}, 1e-5},
           Case{"gobo", {{"Gobo1WheelIndex", 90}, {"Gobo1Pos", 30}}, 6e-2},
           Case{"gobo and prism", {{"Gobo1WheelIndex", 270}, {"Prism1", 2}}, 4e-2},
           Case{"wheel between two slots", {{"Gobo1WheelIndex", 125}}, 2e-3},
           Case{"wheel between a gobo and open", {{"Gobo1WheelIndex", 30}}, 2e-3},
           Case{"gobo and frost", {{"Gobo1WheelIndex", 180}, {"Frost1", 0.2}}, 7e-2},
           Case{"gobo out of focus", {{"Gobo1WheelIndex", 180}, {"Focus1", 0.3}}, 6e-2},
           Case{"blades out of focus", {{"Blade3A", 0.5}, {"Focus1", 0.3}}, 3e-5},
           Case{"animation wheel", {{"AnimationWheel1", 1}, {"AnimationWheel1Pos", 40}}, 3e-2},
       }) {
    CAPTURE(each.what);
    const auto focuses = [](const auto& value) { return std::string_view(value.first) == "Focus1"; };
    Scene scene = optics_scene(std::any_of(each.values.begin(), each.values.end(), focuses));
    for (const auto& [attribute, value] : each.values) scene.set(0, attribute, value);
    CHECK(against_judge(vulkan.device(), scene, judged_settings(32, 18), each.what, 1e-3).rel_l2 < each.rel_l2_max);
  }
}

TEST_CASE("frost, focus and iris in a rig of m = 1, and floods, are drawn in haze as the judge computes them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    std::vector<std::pair<const char*, double>> values;
    double rel_l2_max;  // three times the value on lavapipe (32 x 18 pixels), or 1e-5
  };
  for (const Case& each : {
           Case{"m = 1", {}, 1e-5},
           Case{"m = 1, frost", {{"Frost1", 0.3}}, 1.3e-4},
           Case{"m = 1, full frost", {{"Frost1", 1}}, 9e-5},
           Case{"m = 1, focus near", {{"Focus1", 0}}, 2.7e-4},
           Case{"m = 1, iris", {{"Iris", 0.5}}, 1e-5},
           Case{"m = 1, iris and frost", {{"Iris", 0.5}, {"Frost1", 0.1}}, 2.1e-5},
           Case{"m = 1, 120 degrees", {{"Zoom", 120}}, 2.2e-4},
           Case{"m = 1, 160 degrees", {{"Zoom", 160}}, 2.3e-3},
           Case{"m = 1, 175 degrees and frost", {{"Zoom", 175}, {"Frost1", 1}}, 3.8e-3},
       }) {
    CAPTURE(each.what);
    Scene scene = optics_scene(true);
    scene.rig.types[0].beams[0].profile_power = 1;
    for (fixtures::Channel& channel : scene.rig.types[0].modes[0].channels) {
      if (channel.functions[0].attribute == "Zoom") channel.functions[0].physical_to = 180;
    }
    scene.compile();
    scene.set(0, "Zoom", 24);
    for (const auto& [attribute, value] : each.values) scene.set(0, attribute, value);
    CHECK(against_judge(vulkan.device(), scene, judged_settings(32, 18), each.what, 1e-3).rel_l2 < each.rel_l2_max);
  }
}

TEST_CASE(
    "coloured and turned facets of a prism, a second prism and a second frost are drawn as the judge computes them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    std::vector<std::pair<const char*, double>> values;
    double rel_l2_max;  // twice the value on lavapipe (48 x 27 pixels)
  };
  for (const Case& each : {
           Case{"three colours", {{"Prism1", 2}}, 1e-5},
           Case{"second prism, turned", {{"Prism2", 2}, {"Prism2Pos", 50}}, 1e-5},
           Case{"blades through turned facets", {{"Prism1", 2}, {"Blade1A", 0.8}, {"Prism1Pos", 30}}, 1e-5},
           Case{"blades through a mirror",
                {{"Prism2", 2}, {"Blade1A", 0.8}, {"Blade1Rot", 20}, {"Prism2Pos", 70}},
                1e-5},
           Case{"both prisms, blades, iris",
                {{"Prism1", 2}, {"Prism2", 2}, {"Prism1Pos", 40}, {"Prism2Pos", 110}, {"Blade2A", 0.7}, {"Iris", 0.6}},
                1e-5},
           Case{"second frost", {{"Frost2", 0.6}}, 5e-4},
           Case{"two frosts", {{"Frost1", 1}, {"Frost2", 1}}, 1e-4},
           Case{"frost behind a prism", {{"Prism1", 2}, {"Frost2", 0.5}}, 1e-5},
       }) {
    CAPTURE(each.what);
    Scene scene = optics_scene(false, true);
    CHECK(scene.compiled.needs.stacked);
    for (const auto& [attribute, value] : each.values) scene.set(0, attribute, value);
    CHECK(against_judge(vulkan.device(), scene, judged_settings(48, 27), each.what, 1e-3).rel_l2 < each.rel_l2_max);
  }
}

TEST_CASE("measured beams are drawn as the judge computes them from the candela of the file") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    double away_deg;
    double width_deg;
    double zoom_deg;    // of the lamp with a zoom, alone; 0: the lamp without one
    double rel_l2_max;  // twice the value on lavapipe
  };
  for (const Case& each :
       {Case{"flood, brightest at 40 degrees", 40, 50, 0, 2e-4}, Case{"spot with spill", 0, 12, 0, 2.5e-4},
        Case{"spot beside the axis", 20, 10, 0, 8e-4}, Case{"flood with a zoom", 40, 50, 50, 2e-3},
        Case{"flood, zoomed to a pencil", 40, 50, 4, 4e-3}}) {
    CAPTURE(each.what);
    Scene scene = measured_scene(each.away_deg, each.width_deg, each.zoom_deg);
    CHECK(scene.compiled.needs.measured);
    dim_lamps(scene, {each.zoom_deg == 0, each.zoom_deg > 0});
    CHECK(against_judge(vulkan.device(), scene, judged_settings(48, 27), each.what, 1e-3).rel_l2 < each.rel_l2_max);
    scene.rig.haze.scattering_per_m = scene.rig.haze.absorption_per_m = 0;
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    CHECK(against_judge(vulkan.device(), scene, judged_settings(48, 27), "on surfaces alone", 1e-3).rel_l2 <
          each.rel_l2_max);
  }
}

TEST_CASE("rectangular beams are drawn as the judge computes them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    double aspect;
    double beam_deg;
    int profile_power;
    std::vector<std::pair<const char*, double>> values;
    double rel_l2_max;  // twice the value on lavapipe
  };
  for (const Case& each :
       {Case{"16 by 9", 16.0 / 9, 25, 0, {}, 3e-6}, Case{"a sheet of light", 14, 25, 0, {}, 3e-6},
        Case{"upright", 0.5, 40, 2, {}, 3e-6}, Case{"square, frost", 1, 20, 4, {{"Frost1", 0.5}}, 3e-6},
        Case{"iris", 2, 25, 1, {{"Iris", 0.5}}, 3e-6}, Case{"prism", 3, 20, 4, {{"Prism1", 2}}, 3e-6},
        Case{"prism and iris", 3, 20, 4, {{"Prism1", 2}, {"Iris", 0.6}}, 8e-6},
        Case{"blades", 2, 25, 1, {{"Blade1A", 0.3}, {"Blade2A", 0.5}, {"Blade4A", 0.1}}, 3e-6},
        Case{"turned blades, iris",
             0.6,
             25,
             2,
             {{"Blade1A", 0.3}, {"Blade1Rot", 25}, {"Blade3A", 0.4}, {"Iris", 0.8}},
             3e-6},
        Case{"blades and prism", 1.5, 20, 4, {{"Blade2A", 0.6}, {"Blade2Rot", -20}, {"Prism1", 2}}, 3e-6},
        Case{"gobo", 2, 25, 0, {{"Gobo1WheelIndex", 90}, {"Gobo1Pos", 30}}, 3e-2},
        Case{"wheel between two slots", 1.5, 25, 1, {{"Gobo1WheelIndex", 125}}, 2.5e-2}}) {
    CAPTURE(each.what);
    Scene scene = rectangle_scene(each.aspect, each.beam_deg, each.profile_power);
    CHECK(scene.compiled.needs.rectangle);
    for (const auto& [attribute, value] : each.values) scene.set(0, attribute, value);
    CHECK(against_judge(vulkan.device(), scene, judged_settings(48, 27), each.what, 1e-3).rel_l2 < each.rel_l2_max);
  }
}

TEST_CASE("light on boxes agrees with the judge in clear air") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(13, false);
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.haze.absorption_per_m = 0;
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  CHECK(!scene.compiled.needs.haze);
  CHECK(against_judge(vulkan.device(), scene, judged_settings(), "no haze").rel_l2 < kSurfacesMax);
}

TEST_CASE("light in haze agrees with the judge in a scene without surfaces") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(14, false);
  scene.rig.boxes.clear();
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  CHECK(against_judge(vulkan.device(), scene, judged_settings(), "haze only").rel_l2 < kBeamsMax);
}

TEST_CASE("pictures of a camera in the beam, at the lens and in front of the lens agree with the judge") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_lamp_scene();
  // rel_l2_max: three times the value measured with 3 nodes, at least 5e-6, where float rounding dominates. If a ray
  // runs along the beam from its lens, the integrand falls as 1/z^2 over 30 m, and 3 nodes are too few; 8 are enough.
  struct Case {
    const char* what;
    glm::dvec3 from_m;
    glm::dvec3 to_m;
    double fov_deg;
    std::uint32_t nodes;
    double rel_l2_max;
  };
  for (const Case& c : {Case{"in the beam, along it", {0.05, 4, 5.02}, {0, 10, 5}, 60, 3, 8e-4},
                        Case{"in the beam, across it", {0.05, 4, 5.02}, {3, 4.5, 5}, 60, 3, 5e-6},
                        Case{"in the beam, into the lens", {0.05, 4, 5.02}, {0, 0, 5}, 60, 3, 5e-6},
                        Case{"on the axis, into the lens", {0, 6, 5}, {0, 0, 5}, 40, 3, 5e-6},
                        Case{"in the lens, along the beam", {0, 0, 5}, {0, 5, 5}, 60, 3, 1e-2},
                        Case{"in the lens, 8 nodes", {0, 0, 5}, {0, 5, 5}, 60, 8, 1.2e-4},
                        Case{"behind the lamp", {0.01, -3, 5.01}, {0, 5, 5}, 30, 3, 4e-2},
                        Case{"behind the lamp, 8 nodes", {0.01, -3, 5.01}, {0, 5, 5}, 30, 8, 4e-4},
                        Case{"beside the lens", {0.2, 0.01, 5}, {0, 0.3, 5}, 60, 3, 6e-3}}) {
    CAPTURE(c.what);
    scene.camera = {"c", c.from_m, c.to_m, c.fov_deg, 4};
    FrameSettings settings = judged_settings(32, 18);
    settings.nodes = c.nodes;
    CHECK(against_judge(vulkan.device(), scene, settings, c.what).rel_l2 < c.rel_l2_max);
  }
}

// No multiple of a tile.
const FrameSettings kOddSize{.width = 97, .height = 61};

TEST_CASE("a picture does not depend on earlier pictures of its frame or another frame, to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(15, true);
  const RadianceImage first = draw_new(vulkan.device(), scene, kOddSize);
  double brightest = 0;
  for (const float value : first.rgb) {
    REQUIRE(std::isfinite(value));
    brightest = std::max(brightest, static_cast<double>(value));
  }
  CHECK(brightest > 1);

  const auto frame = make_frame(vulkan.device(), scene, kOddSize);
  for (int i = 0; i < 2; ++i) CHECK(draw(*frame, scene).rgb == first.rgb);
  // Other levels, another camera, another exposure, and another frame of another size.
  Scene other = demo_scene(16, true);
  other.camera = scene.rig.cameras.at(1);
  FrameSettings small = kOddSize;
  small.width = 33;
  small.height = 20;
  small.nodes = 5;
  (void)draw_new(vulkan.device(), other, small);
  must(frame->draw(view_of(other.camera), -3));
  CHECK(draw(*frame, scene).rgb == first.rgb);
  CHECK(must(frame->read_screen()).rgba.size() == std::size_t{97} * 61 * 4);
}

// Mesa's lavapipe 22.3 keeps code that it compiles for values of a uniform buffer (FL_NOT_IN_CODE in lib/frame.glsl):
// 5.5 MB for each picture of the demo before that was prevented.
TEST_CASE("ten more pictures of the demo take less than 300 kB of the heap") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(15, true);
  const auto frame = make_frame(vulkan.device(), scene, kOddSize);
  const auto heap_after = [&](int pictures) {
    for (int i = 0; i < pictures; ++i) must(frame->draw(view_of(scene.camera), 8));
    return mallinfo2().uordblks;
  };
  const std::size_t before = heap_after(3);
  const std::size_t after = heap_after(10);
  CHECK(after < before + 300'000);
}

TEST_CASE("at every picture size each pixel equals the pixel of the same ray in a picture of another size") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(17, false);
  FrameSettings first = judged_settings(8, 8);
  first.bodies = true;
  const auto frame = make_frame(vulkan.device(), scene, first);
  const auto drawn = [&](const FrameSettings& settings) {
    must(frame->change(settings));
    return draw(*frame, scene);
  };
  struct Size {
    int width;
    int height;
  };
  for (const Size& size : {Size{1, 1}, Size{17, 13}, Size{65, 63}, Size{16, 16}, Size{3, 130}}) {
    CAPTURE(size.width);
    FrameSettings settings = judged_settings(size.width, size.height);
    settings.bodies = true;
    const RadianceImage picture = drawn(settings);
    REQUIRE(picture.rgb.size() == static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * 3);
    for (const float value : picture.rgb) REQUIRE(std::isfinite(value));
    // With three times as many pixels in each direction, the middle pixel of each 3 x 3 has the same ray.
    settings.bodies = false;
    const RadianceImage plain = drawn(settings);
    settings.width *= 3;
    settings.height *= 3;
    const RadianceImage fine = drawn(settings);
    double worst = 0;
    double mean = 0;
    for (const float value : plain.rgb) mean += static_cast<double>(value) / static_cast<double>(plain.rgb.size());
    CHECK(mean > 0);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width * 3; ++x) {
        const auto at = static_cast<std::size_t>(y * size.width * 3 + x);
        const int pixel = x / 3;
        const int channel = x % 3;
        const auto in_fine = static_cast<std::size_t>(((3 * y + 1) * size.width * 3 + 3 * pixel + 1) * 3 + channel);
        const double difference = std::abs(static_cast<double>(plain.rgb[at]) - static_cast<double>(fine.rgb[in_fine]));
        worst = std::max(worst, difference / (static_cast<double>(plain.rgb[at]) + 1e-2 * mean));
      }
    }
    std::fprintf(stderr, "%d x %d against three times as many: max %.3g\n", size.width, size.height, worst);
    CHECK(worst < 1e-3);
  }
}

TEST_CASE("the screen is the tone map of the light behind the lens, within one step of 255") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(18, false);
  FrameSettings settings;
  settings.width = 96;
  settings.height = 54;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 0);
  int worst = 0;
  int differing = 0;
  for (const double exposure_ev : {-20.0, -4.0, 0.0, 2.0, 4.6, 8.0, 14.0, 30.0}) {
    must(frame->draw(view_of(scene.camera), exposure_ev));
    const ScreenImage gpu = must(frame->read_screen());
    const ScreenImage cpu = screen_of(must(frame->read_seen()), exposure_ev);
    REQUIRE(gpu.rgba.size() == cpu.rgba.size());
    int alpha_wrong = 0;
    for (std::size_t i = 0; i < gpu.rgba.size(); ++i) {
      const int difference = std::abs(int{gpu.rgba[i]} - int{cpu.rgba[i]});
      worst = std::max(worst, difference);
      differing += difference != 0;
      if (i % 4 == 3) alpha_wrong += gpu.rgba[i] != 255;
    }
    CHECK(alpha_wrong == 0);
  }
  std::fprintf(stderr, "tone map: %d values of %d differ, by %d at most\n", differing, 8 * 96 * 54 * 3, worst);
  CHECK(worst <= 1);
}

}  // namespace
}  // namespace footlight::render
