// Boxes and bodies that hide light: pictures compared with the judge's traced paths.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "render/frame.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "render/shadow_tables.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using namespace render::testing;
using footlight::testing::HeadlessVulkan;

JudgedImage judged(const Scene& scene, int width, int height) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  return judge_image(judge, view_of(scene.camera), width, height, {.tolerance = 1e-5, .stated_error = false});
}

// Lamps over a floor, with `boxes` boxes in the beam of each.
Scene cluttered_scene(std::uint64_t seed, int lamps, int boxes) {
  Scene scene = lamps_scene(seed, lamps);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  Random random(seed);
  const auto between = [&](double from, double to) {
    return glm::dvec3(random.between(from, to), random.between(from, to), random.between(from, to));
  };
  for (const JudgeBeam& beam : judge_scene(scene.rig, walker).beams) {
    for (int i = 0; i < boxes; ++i) {
      const double z = random.between(0.4, 5);
      const double w = beam.lens_radius_m + std::min(beam.spread, 1.0) * z;
      const glm::dvec3 low = beam.lens_m + z * beam.axis + w * between(-1, 1);
      scene.rig.boxes.push_back({"box", low, low + between(0.2, 1.2) * w, glm::dvec3(0.5)});
    }
  }
  scene.rig.boxes.push_back({"floor", {-30, -30, -3.2}, {30, 30, -3}, glm::dvec3(0.3)});
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  return scene;
}

TEST_CASE("boxes hide light in the air and on surfaces as the judge's traced paths say") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = cluttered_scene(3, 16, 2);
  FrameSettings settings = judged_settings(96, 54);
  const JudgedImage judge = judged(scene, 96, 54);
  // The lit parts of a chord each by itself, and all of them from one polynomial.
  for (const int nodes : {5, FL_CUT_NODES}) {
    settings.nodes = static_cast<std::uint32_t>(nodes);
    CAPTURE(nodes);
    settings.shadows = true;
    const PictureNorms shaded = picture_norms(draw_new(vulkan.device(), scene, settings).rgb, judge.rgb);
    settings.shadows = false;
    const PictureNorms lit = picture_norms(draw_new(vulkan.device(), scene, settings).rgb, judge.rgb);
    std::fprintf(stderr, "shadows, %d nodes: relL2 %.3g, p99 %.3g, max %.3g; without %.3g\n", nodes, shaded.rel_l2,
                 shaded.p99, shaded.max, lit.rel_l2);
    CHECK(shaded.nonfinite == 0);
    CHECK(shaded.rel_l2 < 1e-4);
    CHECK(lit.rel_l2 > 0.05);
  }
}

TEST_CASE("shadow maps come nearer to the judge with more texels, in the air and on surfaces") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = cluttered_scene(3, 16, 2);
  FrameSettings settings = judged_settings(96, 54);
  settings.nodes = 5;
  const JudgedImage judge = judged(scene, 96, 54);
  double before = 1;
  for (const std::uint32_t px : {16u, 64u, 256u}) {
    settings.shadow_map_px = px;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const PictureNorms norms = picture_norms(draw(*frame, scene).rgb, judge.rgb);
    std::fprintf(stderr, "maps of %u: relL2 %.3g, p99 %.3g, max %.3g\n", px, norms.rel_l2, norms.p99, norms.max);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < 0.7 * before);
    before = norms.rel_l2;
    CHECK(must(frame->read_counts()).shadows >= 32);
    CHECK(must(frame->read_counts()).shadows_lost == 0);
  }
  CHECK(before < 1e-2);
}

TEST_CASE("from every side the rows of shadow maps come nearer to exact shadows than maps of half the texels do") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = cluttered_scene(5, 16, 3);
  FrameSettings settings = judged_settings(128, 72);
  // Beside the beams, above and below them, behind the lenses, and among the beams, where some have no rows.
  std::vector<fixtures::Camera> cameras = {scene.camera,
                                           {"left", {-14, 2, 4}, {0, 2, 2}, 50, 8},
                                           {"right", {12, 9, 1}, {0, 2, 2}, 60, 8},
                                           {"behind", {3, -16, 6}, {0, 4, 2}, 40, 8},
                                           {"above", {1, 3, 16}, {0.5, 3, 0}, 60, 8},
                                           {"among", {0.3, 1.5, 2.5}, {1.5, 6, 2}, 70, 8}};
  // Beside the lens of the widest beam, along its edge: many of the rays through it never come to its axis.
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const std::vector<JudgeBeam> beams = judge_scene(scene.rig, walker).beams;
  const JudgeBeam& widest = *std::max_element(
      beams.begin(), beams.end(), [](const JudgeBeam& a, const JudgeBeam& b) { return a.spread < b.spread; });
  const glm::dvec3 aside = glm::normalize(glm::cross(widest.axis, glm::dvec3(0.3, 0.2, 1)));
  const glm::dvec3 eye = widest.lens_m + aside;
  cameras.push_back({"the lens", eye, eye + 8.0 * widest.axis + 0.1 * widest.spread * 8.0 * aside, 50, 8});
  for (const fixtures::Camera& camera : cameras) {
    CAPTURE(camera.name);
    scene.camera = camera;
    const auto picture = [&](std::uint32_t px) {
      settings.shadow_map_px = px;
      settings.shadows = true;
      return draw_new(vulkan.device(), scene, settings).rgb;
    };
    const std::vector<float> exact_rgb = picture(0);
    const std::vector<double> exact(exact_rgb.begin(), exact_rgb.end());
    const PictureNorms rows = picture_norms(picture(64), exact);
    const PictureNorms samples = picture_norms(picture(32), exact);
    settings.shadows = false;
    const PictureNorms none = picture_norms(draw_new(vulkan.device(), scene, settings).rgb, exact);
    std::fprintf(stderr, "rows from %s: relL2 %.3g, with 32 texels %.3g, without shadows %.3g\n", camera.name.c_str(),
                 rows.rel_l2, samples.rel_l2, none.rel_l2);
    CHECK(rows.nonfinite == 0);
    CHECK(rows.rel_l2 < 0.9 * samples.rel_l2);
    CHECK(rows.rel_l2 < 0.2 * none.rel_l2);
  }
}

TEST_CASE("shadow maps suit rigs with more than a million pairs, with fewer texels where tables are small") {
  Scene scene = optics_scene(false);
  for (int i = 0; i < 1200; ++i) scene.rig.boxes.push_back({"box", {0, 1, 0}, {1, 2, 1}, glm::dvec3(0.5)});
  scene.compile();
  const auto suited = [&](std::uint32_t beams, std::uint32_t px, std::uint64_t range_bytes = FL_MAP_BYTES_MAX) {
    fixtures::CompiledRig compiled = scene.compiled;
    compiled.beams_max = beams;
    FrameSettings settings = judged_settings();
    settings.shadow_map_px = px;
    return suited_map_px({scene.rig, compiled, compiled.needs, settings}, range_bytes);
  };
  CHECK(suited(800, kShadowsSuited) == 0);
  CHECK(suited(900, kShadowsSuited) == 64);
  CHECK(suited(800, 128) == 128);
  CHECK(suited(900, 0) == 0);
  CHECK(suited(40'000, kShadowsSuited) == 32);
  // Rows for mirrors do not decide, and exact shadows keep within what lists can number.
  Scene ball = scene;
  ball.compiled.beams_max = 40'000;
  ball.compiled.mirror_rows = 39'200;
  const FrameSettings usual = judged_settings();
  REQUIRE(usual.shadow_map_px == kShadowsSuited);
  const MemoryShape shape{ball.rig, ball.compiled, ball.compiled.needs, usual};
  CHECK(suited_map_px(shape, FL_MAP_BYTES_MAX) == 0);
  CHECK(shadow_bytes(shape) == FL_SHADOW_ROWS_MAX * sizeof(ShadowRow));
  CHECK(suited(1000, 64, 5'000'000) == 32);
  CHECK(suited(1000, 64, 1'000'000) == 0);
  FrameSettings off = judged_settings();
  off.shadows = false;
  CHECK(suited_map_px({scene.rig, scene.compiled, scene.compiled.needs, off}, FL_MAP_BYTES_MAX) == 0);
}

TEST_CASE("a frame made for shadow maps refuses exact shadows, and the other way round") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  scene.rig.boxes.push_back({"box", {-0.6, 3, 2.9}, {0.1, 3.3, 3.2}, glm::dvec3(0.5)});
  scene.compile();
  FrameSettings settings = judged_settings(16, 9);
  settings.shadow_map_px = 32;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  CHECK(frame->settings().shadow_map_px == 32);
  settings.shadow_map_px = 0;
  const auto refused = frame->change(settings);
  REQUIRE(!refused);
  CHECK(refused.error().message.find("made for shadow maps: expected a new frame") != std::string::npos);
  settings.shadow_map_px = kShadowsSuited;
  CHECK(frame->change(settings));
  CHECK(frame->settings().shadow_map_px == 32);
  settings.shadow_map_px = 48;
  CHECK(!frame->change(settings));
}

TEST_CASE("whatever shapes a beam, its light behind a box is dark as the judge computes it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto check = [&](Scene scene, const char* what, double rel_l2_max) {
    scene.rig.boxes.push_back({"in front", {-0.6, 3, 2.9}, {0.1, 3.3, 3.2}, glm::dvec3(0.5)});
    scene.rig.boxes.push_back({"behind", {0.2, 5, 2.2}, {0.9, 5.5, 3.1}, glm::dvec3(0.5)});
    const std::vector<std::uint8_t> levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    FrameSettings settings = judged_settings(64, 36);
    settings.nodes = 5;
    settings.gobo_taps = 256;
    settings.gobo_method = GoboMethod::kTaps;
    const JudgedImage judge = judged(scene, 64, 36);
    const PictureNorms norms = picture_norms(draw_new(vulkan.device(), scene, settings).rgb, judge.rgb);
    settings.shadows = false;
    const PictureNorms lit = picture_norms(draw_new(vulkan.device(), scene, settings).rgb, judge.rgb);
    std::fprintf(stderr, "%s: relL2 %.3g, without shadows %.3g\n", what, norms.rel_l2, lit.rel_l2);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < rel_l2_max);
    CHECK(lit.rel_l2 > 0.02);
  };
  // Bounds are three times what lavapipe gave.
  Scene scene = optics_scene(false);
  scene.set(0, "Blade1A", 0.3);
  scene.set(0, "Iris", 0.7);
  scene.set(0, "Frost1", 0.2);
  check(scene, "blade, iris, frost", 1e-3);
  scene = optics_scene(false);
  scene.set(0, "Gobo1WheelIndex", 2);
  scene.set(0, "Prism1", 1);
  check(scene, "gobo and prism", 2e-2);
  scene = rectangle_scene(2.5, 30, 2);
  check(scene, "rectangle", 1e-3);
}

// 200 washes above a stage with boxes.
TEST_CASE("beams that are taken together for tiles have the shadows of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Random random(26);
  Scene scene = lamps_above_boxes(random);
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, random.between(0.2, 1));
    scene.set(i, "Zoom", random.between(10, 40));
  }
  FrameSettings settings = judged_settings(256, 144);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage each = draw(*frame, scene);
  settings.tile_error = FrameSettings{}.tile_error;
  must(frame->change(settings));
  const RadianceImage together = draw(*frame, scene);
  const PictureNorms norms = picture_norms(together, each);
  settings.shadows = false;
  must(frame->change(settings));
  const PictureNorms lit = picture_norms(draw(*frame, scene), each);
  std::fprintf(stderr, "tiles with shadows: relL2 %.3g, p99 %.3g, max %.3g; without %.3g\n", norms.rel_l2, norms.p99,
               norms.max, lit.rel_l2);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < 3e-4);
  CHECK(norms.rel_l2 > 0);  // some are taken together
  CHECK(lit.rel_l2 > 0.02);
  settings.shadows = true;
  must(frame->change(settings));
  CHECK(draw(*frame, scene).rgb == together.rgb);
}

TEST_CASE("thin plates in beams that are taken together hide what they hide of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(31, 160);
  Random random(32);
  for (auto& fixture : scene.rig.fixtures) fixture.position_m.z = random.between(6, 10);
  for (int i = 0; i < 24; ++i) {
    const glm::dvec3 low(-6, -5 + 0.45 * i, random.between(1, 4));
    scene.rig.boxes.push_back({"plate", low, low + glm::dvec3(12, 0.05, 0.05), glm::dvec3(0.4)});
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, random.between(0.2, 1));
    scene.set(i, "Zoom", random.between(1, 30));  // some are thinner than a pixel, and widened
  }
  FrameSettings settings = judged_settings(128, 72);
  settings.widen_thin = true;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage each = draw(*frame, scene);
  settings.tile_error = FrameSettings{}.tile_error;
  must(frame->change(settings));
  const RadianceImage together = draw(*frame, scene);
  const PictureNorms norms = picture_norms(together, each);
  std::fprintf(stderr, "tiles with plates: relL2 %.3g, p99 %.3g, max %.3g\n", norms.rel_l2, norms.p99, norms.max);
  CHECK(norms.nonfinite == 0);
  CHECK(*std::min_element(together.rgb.begin(), together.rgb.end()) >= 0);
  CHECK(norms.rel_l2 < 1e-3);
  CHECK(norms.rel_l2 > 0);
  settings.tile_error = 1e-6;
  must(frame->change(settings));
  CHECK(picture_norms(draw(*frame, scene), each).rel_l2 < 1e-5);
}

TEST_CASE("a fixture hides light of others, and none of its own") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Two heads above a floor, both straight down: the upper one lights the lower one's back.
  Scene scene;
  scene.rig = fixtures::demo_rig();
  fixtures::PatchedFixture upper = scene.rig.fixtures.front();
  upper.pose.reset();
  upper.position_m = {0, 0, 7};
  upper.rotation_deg = {0, 0, 0};
  fixtures::PatchedFixture lower = upper;
  lower.name = "lower";
  lower.position_m = {0, 0, 4};
  lower.address = upper.address + 64;
  scene.rig.boxes = {{"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)}};
  scene.rig.cameras = {{"above", {0, -0.1, 30}, {0, 0, 0}, 20, 4}};
  const auto lux_below = [&](const std::vector<fixtures::PatchedFixture>& rig, bool shadows) {
    scene.rig.fixtures = rig;
    scene.compile();
    scene.camera = scene.rig.cameras.front();
    scene.set(0, "Dimmer", 1);
    scene.set(0, "Zoom", 6);
    FrameSettings settings = judged_settings(65, 65);
    settings.bodies = true;
    settings.shadows = shadows;
    settings.view = render::FrameView::kLux;
    const RadianceImage lux = draw_new(vulkan.device(), scene, settings);
    double sum = 0;
    for (std::size_t i = 0; i < lux.rgb.size(); i += 3) sum += static_cast<double>(lux.rgb[i]);
    return sum;
  };
  const double alone = lux_below({upper}, true);
  CHECK(alone > 1000);
  CHECK(alone == doctest::Approx(lux_below({upper}, false)).epsilon(1e-6));
  const double behind = lux_below({upper, lower}, true);
  const double through = lux_below({upper, lower}, false);
  std::fprintf(stderr, "alone %.6g, behind a body %.6g, through it %.6g\n", alone, behind, through);
  CHECK(behind < 0.8 * alone);
  CHECK(through > 0.95 * alone);
}

TEST_CASE("an object from a file hides light where its triangles are, and a hall around the lamp hides none") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // A lamp straight down on a floor, and below it a 3DS box of 2 x 1 x 0.5 m whose lowest corner is at an origin.
  Scene scene;
  scene.rig = fixtures::demo_rig();
  scene.rig.scenery.clear();
  fixtures::PatchedFixture lamp = scene.rig.fixtures.front();
  lamp.pose.reset();
  lamp.position_m = {0, 0, 7};
  lamp.rotation_deg = {0, 0, 0};
  scene.rig.fixtures = {lamp};
  scene.rig.boxes = {{"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)}};
  scene.rig.cameras = {{"below the box", {0, -6, 1}, {0, 0, 0}, 20, 4}};
  scene.rig.ambient_lx = 0;
  scene.camera = scene.rig.cameras.front();
  scene.rig.files = std::make_shared<footlight::testing::MemoryFiles>(
      std::map<std::string, std::string>{{"box.3ds", footlight::testing::box_3ds(2000, 1000, 500)},
                                         {"hall.3ds", footlight::testing::box_3ds(20000, 20000, 12000)}});
  const auto floor_lux = [&](const char* file, const glm::dvec3& origin_m, bool shadows) {
    scene.rig.objects.clear();
    if (file[0] != 0) {
      fixtures::SceneObject object;
      object.name = file;
      object.parts.push_back({file, glm::translate(glm::dmat4(1), origin_m)});
      scene.rig.objects.push_back(object);
    }
    scene.compile();
    scene.set(0, "Dimmer", 1);
    scene.set(0, "Zoom", 12);
    FrameSettings settings = judged_settings(64, 36);
    settings.bodies = true;
    settings.shadows = shadows;
    settings.view = render::FrameView::kLux;
    const RadianceImage lux = draw_new(vulkan.device(), scene, settings);
    double sum = 0;
    for (const float value : lux.rgb) sum += static_cast<double>(value);
    return sum;
  };
  const double open = floor_lux("", {}, true);
  CHECK(open > 100);
  CHECK(floor_lux("box.3ds", {-1, -0.5, 3}, false) == doctest::Approx(open).epsilon(1e-6));
  CHECK(floor_lux("box.3ds", {-1, -0.5, 3}, true) < 1e-3 * open);                          // in the way
  CHECK(floor_lux("box.3ds", {3, -0.5, 3}, true) == doctest::Approx(open).epsilon(1e-6));  // beside the beam
  CHECK(floor_lux("hall.3ds", {-10, -13, -0.5}, true) ==
        doctest::Approx(open).epsilon(1e-6));  // around lamp and camera
}

TEST_CASE("a wall that ends in the plane of a lens hides nothing of its beam, wherever the camera is") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgeBeam beam = judge_scene(scene.rig, walker).beams.front();
  REQUIRE(beam.axis.y > 0.999);
  scene.rig.boxes.push_back({"behind the lens", beam.lens_m - glm::dvec3(0.5, 0.4, 0.5),
                             beam.lens_m + glm::dvec3(0.5, 0, 0.5), glm::dvec3(0.5)});
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  FrameSettings settings = judged_settings(16, 9);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  Random random(5);
  for (int i = 0; i < 12; ++i) {
    scene.camera.position_m += glm::dvec3(random.between(-0.3, 0.3), random.between(-0.3, 0.3), 0.1);
    settings.shadows = true;
    must(frame->change(settings));
    const RadianceImage shaded = draw(*frame, scene);
    settings.shadows = false;
    must(frame->change(settings));
    // The far wall hides a little, at most a pixel of 1e-4 of the light; the wall behind the lens would hide all of it.
    CHECK(picture_norms(shaded, draw(*frame, scene)).rel_l2 < 1e-3);
  }
}

TEST_CASE("a beam that is blocked at its lens gives no light, and 5,000 shadows of one beam are counted") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  scene.rig.boxes.push_back({"around the lamp", {-0.5, -0.5, 2.5}, {0.5, 0.5, 3.5}, glm::dvec3(0.5)});
  scene.compile();
  FrameSettings settings = judged_settings();
  for (const std::uint32_t px : {0u, 64u}) {
    settings.shadow_map_px = px;
    const RadianceImage dark = draw_new(vulkan.device(), scene, settings);
    CHECK(*std::max_element(dark.rgb.begin(), dark.rgb.end()) == 0);
  }

  scene = optics_scene(false);
  for (int i = 0; i < 5000; ++i) {
    const double y = 1 + 1e-3 * i;
    scene.rig.boxes.push_back({"plate", {-0.01, y, 2.99}, {0.01, y + 1e-4, 3.01}, glm::dvec3(0.5)});
  }
  scene.compile();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  const RadianceImage picture = draw(*frame, scene);
  const CountsRow counts = must(frame->read_counts());
  CHECK(counts.shadows == 5001);  // and the wall's
  CHECK(counts.shadows_lost == 5001 - FL_BEAM_SHADOWS_MAX);
  CHECK(std::all_of(picture.rgb.begin(), picture.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
}

TEST_CASE("bodies behind others, and several in one place, hide what the judge says") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  for (int i = 0; i < 3; ++i) scene.rig.boxes.push_back({"first", {-0.3, 1.5, 2.8}, {0.05, 1.6, 3.1}, glm::dvec3(0.5)});
  for (int i = 0; i < 30; ++i) {
    const double y = 1.7 + 0.1 * i;
    scene.rig.boxes.push_back({"behind", {-0.2, y, 2.85}, {0, y + 0.05, 3.05}, glm::dvec3(0.5)});
  }
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(48, 27));
  const PictureNorms norms = picture_norms(draw(*frame, scene).rgb, judged(scene, 48, 27).rgb);
  std::fprintf(stderr, "behind others: relL2 %.3g, p99 %.3g, max %.3g\n", norms.rel_l2, norms.p99, norms.max);
  CHECK(must(frame->read_counts()).shadows >= 33);
  FrameSettings lit = judged_settings(48, 27);
  lit.shadows = false;
  CHECK(picture_norms(draw_new(vulkan.device(), scene, lit).rgb, judged(scene, 48, 27).rgb).rel_l2 > 0.01);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < 1e-3);
}

TEST_CASE("bars in a beam hide the same if each is cut into 30 pieces, in tiles of hundreds of shadows too") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto picture = [&](int pieces, int width, int height) {
    Scene scene = optics_scene(false);
    for (int bar = 0; bar < 24; ++bar) {
      const double z = 2.7 + 0.025 * bar;
      for (int i = 0; i < pieces; ++i) {
        const double x = -0.4 + 0.8 * i / pieces;
        const double over = i + 1 < pieces ? 1e-3 : 0;  // pieces overlap, so that no light passes between them
        scene.rig.boxes.push_back({"bar", {x, 2, z}, {x + 0.8 / pieces + over, 2.01, z + 0.01}, glm::dvec3(0.5)});
      }
    }
    const std::vector<std::uint8_t> levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(width, height));
    const RadianceImage drawn = draw(*frame, scene);
    CHECK(must(frame->read_counts()).shadows >= static_cast<std::uint32_t>(24 * pieces / 2));
    return drawn;
  };
  const auto lit = [&](int width, int height) {
    Scene scene = optics_scene(false);
    return draw_new(vulkan.device(), scene, judged_settings(width, height));
  };
  CHECK(picture_norms(picture(1, 128, 72), lit(128, 72)).rel_l2 > 0.01);
  // One tile has all of the beam, more pieces than a tile has room for; then tiles have parts of it.
  for (const auto& [width, height] : {std::pair{16, 9}, std::pair{128, 72}}) {
    const PictureNorms norms = picture_norms(picture(30, width, height), picture(1, width, height));
    std::fprintf(stderr, "pieces of bars, %d x %d: relL2 %.3g, p99 %.3g, max %.3g\n", width, height, norms.rel_l2,
                 norms.p99, norms.max);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < 1e-4);
  }
}

}  // namespace
