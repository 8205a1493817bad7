// Gates with more than one thing in them: their images and tables against the judge, and which of them have any.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "fixtures/simulate/walker.h"
#include "render/gobo_tables.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// gates_scene() without the wall: light in the air alone.
Scene gates_in_the_air(int count) {
  Scene scene = gates_scene(count);
  scene.rig.boxes.clear();
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  return scene;
}

FrameSettings with_tables(std::uint32_t gates, std::uint32_t builds, int width = 16, int height = 9) {
  FrameSettings settings = judged_settings(width, height);
  settings.gobo_method = GoboMethod::kTables;
  settings.gobo_gates = gates;
  settings.gate_builds = builds;
  return settings;
}

// Gives a lamp two images, the second turned against the first.
void set_two_wheels(Scene& scene, std::size_t lamp, double apart_deg) {
  scene.set(lamp, "Gobo1WheelIndex", 90);
  scene.set(lamp, "Gobo1Pos", 30);
  scene.set(lamp, "Gobo2WheelIndex", 180);
  scene.set(lamp, "Gobo2Pos", 30 + apart_deg);
  scene.set(lamp, "Iris", 0.9);  // which has no tables of whole chords: lavapipe takes seconds to build one
}

double rel_l2(const RadianceImage& picture, const std::vector<double>& judged) {
  const PictureNorms norms = picture_norms(picture.rgb, judged);
  CHECK(norms.nonfinite == 0);
  return norms.rel_l2;
}

TEST_CASE("whatever stands in a gate is drawn from tables of its image as the judge computes it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    std::vector<std::pair<const char*, double>> values;
    double rel_l2_max;  // twice the value on lavapipe
  };
  for (const Case& each : {
           Case{"two wheels", {{"Gobo2WheelIndex", 180}, {"Gobo2Pos", 100}}, 1.1e-2},
           Case{"two wheels, iris", {{"Gobo2WheelIndex", 180}, {"Gobo2Pos", 100}, {"Iris", 0.5}}, 4.4e-3},
           Case{"animation wheel, and a wheel between two slots",
                {{"AnimationWheel1", 1}, {"AnimationWheel1Pos", 70}, {"Gobo2WheelIndex", 215}},
                3.5e-2},
       }) {
    CAPTURE(each.what);
    Scene scene = gates_in_the_air(1);
    scene.set(0, "Gobo1WheelIndex", 90);
    scene.set(0, "Gobo1Pos", 30);
    for (const auto& [attribute, value] : each.values) scene.set(0, attribute, value);
    const FrameSettings settings = with_tables(16, 8, 48, 27);
    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    const std::vector<double> judged =
        judge_image(judge_scene(scene.rig, walker, gobos_of_judge(scene)), view_of(scene.camera), settings.width,
                    settings.height, {.tolerance = 1e-4, .stated_error = false})
            .rgb;
    const double tables = rel_l2(draw_new(vulkan.device(), scene, settings), judged);
    std::fprintf(stderr, "%s: %.3g\n", each.what, tables);
    CHECK(tables < each.rel_l2_max);
  }
}

// Prints the table of docs/numerics.md, on demand: the judge takes minutes.
TEST_CASE("gates of eight beams, by tables and by samples, have errors below 1e-2") {
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") == nullptr) return;
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    const char* what;
    std::vector<std::pair<const char*, double>> values;
  };
  for (const Case& each : {
           Case{"one wheel", {}},
           Case{"two wheels", {{"Gobo2WheelIndex", 180}, {"Gobo2Pos", 100}}},
           Case{"two wheels, iris", {{"Gobo2WheelIndex", 180}, {"Gobo2Pos", 100}, {"Iris", 0.5}}},
           Case{"between two slots", {{"Gobo1WheelIndex", 215}}},
           Case{"animation wheel", {{"AnimationWheel1", 1}, {"AnimationWheel1Pos", 70}}},
       }) {
    CAPTURE(each.what);
    Scene scene = gates_scene(8);
    scene.rig.boxes.clear();
    Random random(5);
    for (auto& lamp : scene.rig.fixtures) {
      lamp.position_m = {random.between(-5, 5), random.between(-1, 5), random.between(3, 6)};
      lamp.rotation_deg = {random.between(0, 110), random.between(0, 360), random.between(0, 360)};
    }
    scene.compile();
    for (std::size_t lamp = 0; lamp < 8; ++lamp) {
      scene.set(lamp, "Zoom", random.between(6, 30));
      scene.set(lamp, "Gobo1WheelIndex", 90.0 * static_cast<double>(1 + lamp % 3));
      scene.set(lamp, "Gobo1Pos", random.between(0, 360));
      for (const auto& [attribute, value] : each.values) scene.set(lamp, attribute, value);
      if (lamp % 2 == 0) scene.set(lamp, "Gobo2Pos", random.between(0, 360));
    }
    FrameSettings settings = with_tables(16, 8, 256, 144);
    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    std::vector<std::uint32_t> pixels;
    for (std::uint32_t p = 0; p < 256 * 144; p += 37) pixels.push_back(p);
    const std::vector<double> judged =
        judge_pixels(judge_scene(scene.rig, walker, gobos_of_judge(scene)), view_of(scene.camera), settings.width,
                     settings.height, pixels, {.tolerance = 1e-3, .stated_error = false})
            .rgb;
    const auto error = [&](GoboMethod method, std::uint32_t taps) {
      settings.gobo_method = method;
      settings.gobo_taps = taps;
      const RadianceImage all = draw_new(vulkan.device(), scene, settings);
      RadianceImage some{static_cast<int>(pixels.size()), 1, {}};
      for (const auto p : pixels)
        some.rgb.insert(some.rgb.end(), &all.rgb[3 * std::size_t{p}], &all.rgb[3 * std::size_t{p}] + 3);
      return rel_l2(some, judged);
    };
    const double tables = error(GoboMethod::kTables, 128);
    const double samples = error(GoboMethod::kTaps, 128);
    const double many = error(GoboMethod::kTaps, 1024);
    std::fprintf(stderr, "%s: tables %.3g, 128 samples %.3g, 1024: %.3g\n", each.what, tables, samples, many);
    for (const double each_error : {tables, samples, many}) CHECK(each_error < 1e-2);
  }
}

TEST_CASE("frost blurs the image of a gate as samples show it") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Scene scene = gates_in_the_air(1);
  set_two_wheels(scene, 0, 70);
  scene.set(0, "Frost1", 0.1);
  FrameSettings settings = with_tables(2, 2, 32, 18);
  const RadianceImage tables = draw_new(vulkan.device(), scene, settings);
  settings.gobo_method = GoboMethod::kTaps;
  settings.gobo_taps = 1024;
  const RadianceImage samples = draw_new(vulkan.device(), scene, settings);
  const double error = rel_l2(tables, {samples.rgb.begin(), samples.rgb.end()});
  std::fprintf(stderr, "gate and frost: %.3g\n", error);
  CHECK(error < 2.1e-2);  // twice the value on lavapipe; it is the samples' own error, tables have 2.0e-3 to the judge
}

TEST_CASE("heads in step share the image of their gate, and turning all of it needs no other") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gates_in_the_air(3);
  for (std::size_t lamp = 0; lamp < 3; ++lamp) set_two_wheels(scene, lamp, lamp == 2 ? 50 : 70);
  const auto frame = make_frame(vulkan.device(), scene, with_tables(4, 4));
  const auto drawn = [&] {
    (void)draw(*frame, scene);
    return must(frame->read_gates());
  };
  GatesHead gates = drawn();
  CHECK(gates.states == 2);
  CHECK(gates.builds == 2);
  scene.set(1, "Gobo1Pos", 130);  // in the second lamp both wheels turn together
  scene.set(1, "Gobo2Pos", 200);
  gates = drawn();
  CHECK(gates.states == 2);
  CHECK(gates.builds == 0);
  scene.set(1, "Gobo2Pos", 201);
  gates = drawn();
  CHECK(gates.states == 3);
  CHECK(gates.builds == 1);
  // A state that was left and comes back has kept its image.
  scene.set(1, "Gobo2Pos", 200);
  (void)drawn();
  scene.set(1, "Gobo2Pos", 201);
  CHECK(drawn().builds == 0);
  CHECK(must(frame->read_gates()).sampled_beams == 0);
}

TEST_CASE("a gate that turns as a whole is drawn as one that was built at that angle") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gates_in_the_air(1);
  set_two_wheels(scene, 0, 70);
  scene.set(0, "Iris", 1);
  const auto frame = make_frame(vulkan.device(), scene, with_tables(4, 4, 32, 18));
  const RadianceImage first = draw(*frame, scene);
  scene.set(0, "Gobo1Pos", 130);
  scene.set(0, "Gobo2Pos", 200);
  const RadianceImage turned = draw(*frame, scene);
  CHECK(turned.rgb != first.rgb);
  CHECK(must(frame->read_gates()).builds == 0);
  const RadianceImage anew = draw_new(vulkan.device(), scene, with_tables(4, 4, 32, 18));
  CHECK(rel_l2(turned, {anew.rgb.begin(), anew.rgb.end()}) < 1e-5);
}

TEST_CASE("beams whose gates are past the budget are counted and sampled, the last ones of the patch") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gates_in_the_air(4);
  for (std::size_t lamp = 0; lamp < 4; ++lamp) set_two_wheels(scene, lamp, 20.0 * static_cast<double>(lamp));
  const FrameSettings two = with_tables(2, 8, 32, 18);
  const auto frame = make_frame(vulkan.device(), scene, two);
  const RadianceImage picture = draw(*frame, scene);
  GatesHead gates = must(frame->read_gates());
  CHECK(gates.states == 2);
  CHECK(gates.builds == 2);
  CHECK(gates.sampled_beams == 2);
  CHECK(draw(*frame, scene).rgb == picture.rgb);
  CHECK(draw_new(vulkan.device(), scene, two).rgb == picture.rgb);
  // The last two lamps alone, without tables, and all four: what differs is the light of the first two.
  Scene last = scene;
  for (const std::size_t lamp : {0u, 1u}) last.set(lamp, "Dimmer", 0);
  FrameSettings samples = two;
  samples.gobo_method = GoboMethod::kTaps;
  Scene early = scene;
  for (const std::size_t lamp : {2u, 3u}) early.set(lamp, "Dimmer", 0);
  const RadianceImage sampled = draw_new(vulkan.device(), last, samples);
  const RadianceImage from_tables = draw_new(vulkan.device(), early, two);
  std::vector<double> sum;
  for (std::size_t i = 0; i < sampled.rgb.size(); ++i) {
    sum.push_back(static_cast<double>(sampled.rgb[i]) + static_cast<double>(from_tables.rgb[i]));
  }
  CHECK(rel_l2(picture, sum) < 1e-6);
}

TEST_CASE("a frame builds no more gates than it may, those that stand still first, until all have images") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gates_in_the_air(3);
  for (std::size_t lamp = 0; lamp < 3; ++lamp) set_two_wheels(scene, lamp, 20.0 * static_cast<double>(lamp));
  const auto frame = make_frame(vulkan.device(), scene, with_tables(8, 1));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> drawn;  // builds, sampled beams
  for (int i = 0; i < 4; ++i) {
    set_two_wheels(scene, 0, 1.0 + i);  // the first lamp never stands still
    (void)draw(*frame, scene);
    const GatesHead gates = must(frame->read_gates());
    drawn.emplace_back(gates.builds, gates.sampled_beams);
  }
  // The first frame knows of no other; then the second and the third lamp, then the one that moves.
  CHECK(drawn == std::vector<std::pair<std::uint32_t, std::uint32_t>>{{1, 2}, {1, 2}, {1, 1}, {1, 0}});
  CHECK(draw(*frame, scene).rgb == draw_new(vulkan.device(), scene, with_tables(8, 8)).rgb);
}

TEST_CASE("gates take memory within their budget, and none in a rig without gobos") {
  const auto bytes_of = [](const Scene& scene, std::uint32_t gates) {
    std::uint64_t bytes = 0;
    FrameSettings settings;
    settings.gobo_gates = gates;
    for (const int binding : {FL_BINDING_GATES, FL_BINDING_GATE_IMAGES_OUT}) {
      bytes += binding_bytes(static_cast<std::uint32_t>(binding),
                             {scene.rig, scene.compiled, scene.compiled.needs, settings});
    }
    return bytes;
  };
  CHECK(bytes_of(lamps_scene(5, 3), 16) == 0);
  const Scene scene = gates_scene(1);
  CHECK(bytes_of(scene, 0) == 0);
  CHECK(bytes_of(scene, 3) == 3 * kGateImageBytes + sizeof(GatesHead) + 6 * sizeof(GateRow));
  const auto planned = [&](std::uint32_t planes, std::uint32_t gates) {
    return plan_gobo_tables(scene.compiled, std::vector<std::uint32_t>(scene.compiled.images.size(), planes), gates);
  };
  CHECK(planned(1, 16).gates == 16);
  CHECK(planned(1, 16).gate_planes == 1);
  CHECK(planned(3, 16).gate_planes == 3);
  CHECK(planned(3, 16).gates == kGateBytesMax / (3 * kGateBytes));
  CHECK(planned(1, 1000).gates == kGateBytesMax / kGateBytes);
  // One wheel in each beam, and no animation wheel: only while it is between two slots.
  Scene plain = demo_scene(3, true);
  const GoboTablePlan few =
      plan_gobo_tables(plain.compiled, std::vector<std::uint32_t>(plain.compiled.images.size(), 1), 16);
  CHECK(few.gates == kGatesBetweenSlots);
}

}  // namespace
}  // namespace footlight::render
