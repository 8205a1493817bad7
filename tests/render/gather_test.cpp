// Dark beams are left out; the rows of the lit beams have the right order and pose.
#include <cmath>
#include <cstdio>
#include <limits>

#include "fixtures/simulate/walker.h"
#include "render/beam.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// Lamps over a floor in work light.
Scene lamps_over_floor(std::uint64_t seed, int count) {
  Scene scene = lamps_scene(seed, count);
  scene.rig.boxes.push_back({"floor", {-10, -10, -1}, {10, 10, -0.2}, {0.2, 0.3, 0.4}});
  scene.rig.ambient_lx = 20;
  auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  return scene;
}

TEST_CASE("a dark frame has no beam, dispatches no beam work and shows only the work light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_over_floor(1, 100);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings());
  (void)draw(*frame, scene);  // lit, so that the next frame must clear this state
  CHECK(must(frame->read_counts()).live_count == 100);
  dim_lamps(scene, std::vector<bool>(100, false));
  const RadianceImage picture = draw(*frame, scene);
  const CountsRow counts = must(frame->read_counts());
  CHECK(counts.live_count == 0);
  CHECK(counts.dark_count == 100);
  CHECK(counts.tiles_groups[0] * counts.tiles_groups[1] * counts.tiles_groups[2] == 0);
  CHECK(counts.beams_groups[0] == 0);
  CHECK(counts.beams_groups[1] == 0);
  CHECK(must(frame->read_beams()).empty());

  JudgeScene judge;
  judge.boxes = scene.rig.boxes;
  judge.haze = scene.rig.haze;
  judge.ambient_lx = scene.rig.ambient_lx;
  const PictureNorms norms =
      picture_norms(picture.rgb, judge_image(judge, view_of(scene.camera), 64, 36, {.stated_error = false}).rgb);
  std::fprintf(stderr, "work light alone: relL2 %.3g, max %.3g\n", norms.rel_l2, norms.max);
  CHECK(norms.max < 2e-6);
  CHECK(norms.nonfinite == 0);
}

TEST_CASE("one lit fixture among many is the only beam, at the walker's pose") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_over_floor(2, 200);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings());
  const View view = view_of(scene.camera);
  for (const std::size_t lit : {std::size_t{0}, std::size_t{63}, std::size_t{64}, std::size_t{130}, std::size_t{199}}) {
    CAPTURE(lit);
    std::vector<bool> lamps(200, false);
    lamps[lit] = true;
    dim_lamps(scene, lamps);
    (void)draw(*frame, scene);
    const CountsRow counts = must(frame->read_counts());
    REQUIRE(counts.live_count == 1);
    CHECK(counts.dark_count == 199);
    CHECK(counts.beams_groups[0] == 4);  // 64 x 36 pixels in tiles of 16
    CHECK(counts.beams_groups[1] == 3);
    CHECK(counts.beams_groups[2] == 1);
    const auto beams = must(frame->read_beams());
    REQUIRE(beams.size() == 1);
    const BeamRow& beam = beams.front();
    CHECK(beam.head == lit);

    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    const auto judge = judge_scene(scene.rig, walker);
    REQUIRE(judge.beams.size() == 1);
    const JudgeBeam& expected = judge.beams.front();
    CHECK(glm::length(glm::dvec3(beam.x_axis) - expected.x_axis) < 1e-6);
    CHECK(glm::length(glm::dvec3(beam.y_axis) - expected.y_axis) < 1e-6);
    CHECK(glm::length(glm::dvec3(beam.axis) - expected.axis) < 1e-6);
    const glm::dvec3 eye = view.position_m - expected.lens_m;
    CHECK(glm::length(glm::dvec3(beam.eye) - glm::dvec3(glm::dot(expected.x_axis, eye), glm::dot(expected.y_axis, eye),
                                                        glm::dot(expected.axis, eye))) < 1e-5);
    CHECK(beam.x_axis.w == doctest::Approx(expected.lens_radius_m).epsilon(1e-6));
    CHECK(std::abs(static_cast<double>(beam.y_axis.w) - expected.spread) < 1e-6);
    CHECK(beam.axis.w == doctest::Approx(expected.range_m).epsilon(1e-6));
    CHECK(static_cast<double>(beam.eye.w) == expected.profile_power);
    CHECK(glm::length(glm::dvec3(beam.j0) - expected.strength_lm) < 1e-5 * glm::length(expected.strength_lm));
    CHECK(beam.gobo == 0);
  }
}

TEST_CASE("beam rows are in patch order over many workgroups, whichever fixtures are dark") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr std::size_t kCount = 1000;  // 16 workgroups; the last one is not full
  Scene scene = lamps_scene(3, kCount);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  Random random(4);
  for (const double share : {0.0, 0.02, 0.5, 0.98, 1.0}) {
    for (int round = 0; round < 4; ++round) {
      std::vector<bool> lit;
      std::vector<std::uint32_t> expected;
      for (std::size_t i = 0; i < kCount; ++i) {
        lit.push_back(random.between(0, 1) < share);
        if (lit.back()) expected.push_back(static_cast<std::uint32_t>(i));
      }
      dim_lamps(scene, lit);
      (void)draw(*frame, scene);
      std::vector<std::uint32_t> rows;
      for (const BeamRow& beam : must(frame->read_beams())) rows.push_back(beam.head);
      CHECK(rows == expected);
      const CountsRow counts = must(frame->read_counts());
      CHECK(counts.live_count + counts.dark_count == kCount);
      CHECK(counts.tiles_groups[0] == (expected.size() + FL_GROUP_MASK - 1) / FL_GROUP_MASK);
    }
  }
}

TEST_CASE("a beam is dark up to the threshold of the settings, and lit above it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(5, 256);  // 10,000 lm each, dimmed linearly to 0, 1, ... 255
  for (std::size_t i = 0; i < 256; ++i) {
    scene.slots(i)[static_cast<std::size_t>(slot_of_address(scene.rig.fixtures[i].address)) + kLampDimmerSlot] =
        static_cast<std::uint8_t>(i);
    for (const auto color : {"ColorAdd_R", "ColorAdd_B"}) scene.set(i, color, 0.2);
    scene.set(i, "ColorAdd_G", 1);  // the brightest channel is compared with the threshold
  }
  for (const double dark_lm : {0.0, 1.0, 5000.0, 9990.0, 10'000.0, std::numeric_limits<double>::infinity()}) {
    CAPTURE(dark_lm);
    FrameSettings settings = judged_settings(8, 8);
    settings.dark_lm = dark_lm;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    (void)draw(*frame, scene);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < 256; ++i) {
      if (10'000.0 * i / 255 > dark_lm) expected.push_back(i);
    }
    std::vector<std::uint32_t> rows;
    for (const BeamRow& beam : must(frame->read_beams())) rows.push_back(beam.head);
    CHECK(rows == expected);
  }
}

}  // namespace
}  // namespace footlight::render
