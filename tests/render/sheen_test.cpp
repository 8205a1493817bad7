// Surfaces with sheen: pictures against the judge, which has the same reflection (shared/sheen.h) in double, and
// objects against boxes.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "render/live_error.h"
#include "render/probe_tables.h"
#include "render/reference/norms.h"
#include "render/sheen_tables.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 32, kHeight = 18;

void without_haze(Scene& scene) { scene.rig.haze = {0, 0, 0, 0}; }

void recompile(Scene& scene) {
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
}

// Lamps over a floor, before a wall of metal, with a matt box.
Scene lamps_over(fixtures::Sheen floor, fixtures::Sheen wall) {
  Scene scene = lamps_scene(3, 24);
  without_haze(scene);
  scene.rig.ambient_lx = 2;
  scene.rig.boxes = {{"floor", {-14, -14, -0.3}, {14, 14, 0}, {0.06, 0.05, 0.04}, {}, floor},
                     {"wall", {-10, 9, 0}, {10, 9.3, 7}, {0.9, 0.7, 0.4}, {}, wall},
                     {"riser", {-3, 2, 0}, {-1, 4, 1}, {0.3, 0.4, 0.6}}};
  recompile(scene);
  view_from(scene, {0.5, -10, 2.5}, {0, 0, 0.8});
  return scene;
}

PictureNorms error_of(vk::Device& device, const Scene& scene, const char* what, GoboMethod gobos = GoboMethod::kTaps) {
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.gobo_method = gobos;
  settings.gobo_taps = 256;
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  const fixtures::Camera& camera = scene.rig.cameras.empty() ? scene.camera : scene.rig.cameras[0];
  const JudgedImage image =
      judge_image(judge, view_of(camera), kWidth, kHeight, {.tolerance = 1e-5, .stated_error = false});
  auto frame = make_frame(device, scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(camera), 0));
  const PictureNorms norms = picture_norms(must(frame->read_radiance()).rgb, image.rgb);
  print_error(what, norms.rel_l2);
  return norms;
}

TEST_CASE("surfaces with sheen reflect beams as the judge does, smooth and rough, plastic and metal") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double roughness : {0.0, 0.35}) {
    const Scene scene = lamps_over({roughness, 0}, {roughness, 1});
    const PictureNorms norms =
        error_of(vulkan.device(), scene, ("sheen, roughness " + std::to_string(roughness)).c_str());
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < 5e-5);
  }
  // The same rig without sheen is another picture.
  const Scene scene = lamps_over({0.35, 0}, {0.35, 1});
  const Scene matt = lamps_over({1, 0}, {1, 0});
  const RadianceImage with = drawn_light(vulkan.device(), scene, kWidth, kHeight, true);
  const std::vector<double> reference(with.rgb.begin(), with.rgb.end());
  CHECK(rel_l2(drawn_light(vulkan.device(), matt, kWidth, kHeight, true), reference) > 0.1);
}

TEST_CASE("surfaces with sheen reflect beams of every shape as the judge does, as nearly as matt ones") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto check = [&](Scene scene, const std::string& what) {
    without_haze(scene);
    recompile(scene);
    const PictureNorms matt = error_of(vulkan.device(), scene, ("matt, " + what).c_str());
    for (fixtures::StageBox& box : scene.rig.boxes) box.sheen = fixtures::Sheen{0.3, 0.5};
    recompile(scene);
    const PictureNorms norms = error_of(vulkan.device(), scene, ("sheen, " + what).c_str());
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < 1.5 * matt.rel_l2 + 1e-5);
  };
  check(measured_scene(20, 30, 25), "measured beams");
  check(rectangle_scene(2.5, 30, 2), "rectangle");
  Scene gobo = optics_scene(false);
  gobo.set(0, "Gobo1WheelIndex", 2);
  gobo.set(0, "Blade1A", 0.3);
  check(gobo, "gobo and blade");
}

// Floods far above a floor and behind each other, so that each lights whole tiles.
Scene washes_over(fixtures::Sheen floor, int count) {
  Scene scene = lamps_scene(5, count);
  without_haze(scene);
  for (int i = 0; i < count; ++i) {
    fixtures::PatchedFixture& lamp = scene.rig.fixtures[static_cast<std::size_t>(i)];
    lamp.position_m = {-6 + 12.0 * (i % 5) / 4, -4 + i / 5, 9};
    lamp.rotation_deg = {2.0 * (i % 7), 3.0 * (i % 3), 0};
  }
  scene.rig.boxes = {{"floor", {-20, -20, -0.3}, {20, 20, 0}, {0.2, 0.3, 0.1}, {}, floor}};
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, 0.3 + 0.02 * (i % 10));
    scene.set(i, "Zoom", 60);
  }
  scene.camera = {"above", {0.5, -10, 5}, {0, -1, 0}, 22, 4};
  return scene;
}

TEST_CASE("sheen of beams that are added together for a tile is that pixel by pixel, within the tile error") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    double roughness;
    double tile_error;
    double rel_l2_max;  // three times what lavapipe gave
  };
  constexpr double kTileError = FrameSettings{}.tile_error;
  for (const Case& c : {Case{0.35, kTileError, 2e-4}, Case{0.7, kTileError, 2e-4}, Case{0.1, kTileError, 2e-4}}) {
    const Scene scene = washes_over({c.roughness, 0.5}, 30);
    FrameSettings settings = judged_settings(256, 144);
    settings.shadows = false;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const RadianceImage each = draw(*frame, scene);
    settings.tile_error = c.tile_error;
    must(frame->change(settings));
    const RadianceImage together = draw(*frame, scene);
    const PictureNorms norms = picture_norms(together, each);
    print_error(("sheen, added together, roughness " + std::to_string(c.roughness)).c_str(), norms.rel_l2);
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < c.rel_l2_max);
    if (c.roughness > 0.3) CHECK(norms.rel_l2 > 0);  // some are added together
    CHECK(draw(*frame, scene).rgb == together.rgb);
  }
}

TEST_CASE("shadow maps hide highlights as exact shadows do") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_scene(false);
  without_haze(scene);
  scene.rig.boxes.push_back({"in front", {-0.6, 3, 2.9}, {0.1, 3.3, 3.2}, glm::dvec3(0.5)});
  for (fixtures::StageBox& box : scene.rig.boxes) box.sheen = fixtures::Sheen{0.35, 0.5};
  recompile(scene);
  const auto drawn = [&](std::uint32_t map_px, bool shadows) {
    FrameSettings settings = judged_settings(kWidth, kHeight);
    settings.shadow_map_px = map_px;
    settings.shadows = shadows;
    return draw_new(vulkan.device(), scene, settings);
  };
  const RadianceImage exact = drawn(0, true);
  const std::vector<double> reference(exact.rgb.begin(), exact.rgb.end());
  const double open = rel_l2(drawn(0, false), reference);
  const double error = rel_l2(drawn(256, true), reference);
  print_error("sheen, shadow maps", error);
  print_error("sheen, without shadows", open);
  CHECK(open > 0.1);
  CHECK(error < 0.3 * open);
}

// Two walls, one beside the other, one of them a box and the other triangles: they are as bright.
TEST_CASE("an object with sheen is as bright as a box with the same material") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_over({0.3, 0}, {0.4, 1});
  scene.rig.boxes.pop_back();
  scene.rig.boxes[1].albedo = glm::dvec3(341.0 / 1023);  // as the visibility buffer has it
  recompile(scene);
  const auto drawn = [&](const Scene& of) {
    return drawn_light(vulkan.device(), of, kWidth, kHeight, true,
                       [](FrameSettings& settings) { settings.bodies = true; });
  };
  const RadianceImage boxes = drawn(scene);
  Scene mesh = scene;
  fixtures::Scenery gauze = fixtures::default_scenery(fixtures::SceneryKind::kGauze);
  gauze.position_m = {0, 9 + 0.004, 0};  // half its thickness behind the face of the wall
  gauze.width_m = 20;
  gauze.height_m = 7;
  gauze.albedo = scene.rig.boxes[1].albedo;
  gauze.sheen = scene.rig.boxes[1].sheen;
  mesh.rig.scenery.push_back(gauze);
  mesh.rig.boxes.erase(mesh.rig.boxes.begin() + 1);
  recompile(mesh);
  const std::vector<double> reference(boxes.rgb.begin(), boxes.rgb.end());
  const double error = rel_l2(drawn(mesh), reference);
  print_error("sheen, object beside box", error);
  CHECK(error < 2e-3);
  gauze.sheen.reset();
  mesh.rig.scenery.back() = gauze;
  recompile(mesh);
  CHECK(rel_l2(drawn(mesh), reference) > 0.05);
}

TEST_CASE("a rig without sheen has no code for it, and the table of a rig with it has each material once") {
  const Scene matt = lamps_over({1, 0}, {1, 0});
  CHECK(!matt.compiled.needs.sheen);
  CHECK(lamps_over({0.9, 0}, {1, 0}).compiled.needs.sheen);
  SheenTable table;
  CHECK(table.number({}) == 0);
  CHECK(table.number(fixtures::Sheen{1, 0}) == 0);
  CHECK(table.number(fixtures::Sheen{0.5, 0}) == 1);
  CHECK(table.number(fixtures::Sheen{0.5, 1}) == 2);
  CHECK(table.number(fixtures::Sheen{0.5, 0}) == 1);
  CHECK(table.joined() == 0);
  CHECK(!table.warning("hall"));
  for (int i = 0; i < 200; ++i) CHECK(table.number(fixtures::Sheen{0.001 * i, 0}) < FL_SHEENS_MAX);
  CHECK(table.rows().size() == FL_SHEENS_MAX);
  CHECK(table.joined() == 139);  // of 202 different ones
  CHECK(table.number(fixtures::Sheen{0.001 * 199, 0}) < FL_SHEENS_MAX);
  CHECK(table.joined() == 139);  // each counts once
  CHECK(table.rows()[table.number(fixtures::Sheen{0.51, 0.99})].metal == 1);
  const auto warning = table.warning("hall");
  REQUIRE(warning);
  CHECK(warning->severity == fixtures::Severity::kWarning);  // printed when the rig is loaded
  CHECK(fixtures::text(*warning).find("203 materials that are not matt, and a picture has 63") != std::string::npos);
  CHECK(fixtures::text(*warning).find("140 of them look like the most similar of the first 63") != std::string::npos);
}

TEST_CASE("the live error of a picture with sheen is small") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_over({0.3, 0}, {0.4, 1});
  FrameSettings settings = judged_settings(kWidth, kHeight);
  auto frame = make_frame(vulkan.device(), scene, settings);
  const auto live = must(LiveError::create(vulkan.device(), *frame, scene.compiled.needs));
  REQUIRE(live != nullptr);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  for (int i = 0; i < 6; ++i) {
    must(vulkan.device().run_once([&](VkCommandBuffer commands) { live->record(commands); }));
    must(live->take(i));
  }
  CHECK(live->estimate().samples > 24);
  CHECK(live->estimate().rel_l2 < 2e-5);
}

// The same lamps in haze, with a probe between floor and wall.
Scene probed_scene(fixtures::Sheen floor) {
  Scene scene = lamps_scene(3, 16);
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", 16.0 + 2.5 * static_cast<double>(i));
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.ambient_lx = 2;
  scene.rig.boxes = {{"floor", {-14, -14, -0.3}, {14, 14, 0}, {0.06, 0.05, 0.04}, {}, floor},
                     {"wall", {-10, 9, 0}, {10, 9.3, 7}, {0.9, 0.7, 0.4}},
                     {"riser", {-3, 2, 0}, {-1, 4, 1}, {0.3, 0.4, 0.6}}};
  scene.rig.probes = {{{-10, -10, 0}, {10, 9, 7}, 1, {{0, 3, 1.5}}}};
  scene.compile();
  scene.levels = levels;
  view_from(scene, {0.5, -10, 2.5}, {0, 0, 0.8});
  scene.camera = scene.rig.cameras[0];
  return scene;
}

FrameSettings probe_settings(bool probes) {
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.bounce = true;
  settings.probes = probes;
  return settings;
}

std::vector<double> minus(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<double> out(a.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<double>(a[i]) - static_cast<double>(b[i]);
  return out;
}

TEST_CASE("a shiny floor mirrors wall and beams as rays from the floor find them, within a third of that light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    double roughness;
    double most;  // that error; lavapipe gave 0.18 and 0.28
  };
  for (const auto& [roughness, most] : {Case{0.2, 0.25}, Case{0.35, 0.34}}) {
    const Scene scene = probed_scene({roughness, 0});
    const auto frame = make_frame(vulkan.device(), scene, probe_settings(true));
    const RadianceImage with = draw(*frame, scene);
    must(frame->change(probe_settings(false)));
    const std::vector<double> mirrored = minus(with.rgb, draw(*frame, scene).rgb);
    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
    const JudgeOptions options{.tolerance = 1e-2, .stated_error = false};
    const auto judged = [&](int rays) {
      judge.sheen_rays = rays;
      return judge_image(judge, view_of(scene.rig.cameras[0]), kWidth, kHeight, options).rgb;
    };
    const std::vector<double> all = judged(256), none = judged(0);
    std::vector<double> expected(all.size());
    double sum = 0, expected_sum = 0, error = 0, square = 0, whole = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      expected[i] = all[i] - none[i];
      sum += mirrored[i];
      expected_sum += expected[i];
      error += (mirrored[i] - expected[i]) * (mirrored[i] - expected[i]);
      square += expected[i] * expected[i];
      whole += all[i] * all[i];
    }
    const std::string what = "probes, roughness " + std::to_string(roughness);
    print_error((what + ": of mirrored light").c_str(), std::sqrt(error / square));
    print_error((what + ": of the picture").c_str(), std::sqrt(error / whole));
    print_error((what + ": of the picture without").c_str(), std::sqrt(square / whole));
    print_error((what + ": sum over that of the rays").c_str(), sum / expected_sum);
    CHECK(std::sqrt(error / square) < most);
    CHECK(std::abs(sum / expected_sum - 1) < 0.15);
  }
}

TEST_CASE("a shiny floor mirrors a lit display as rays from the floor find it, within a third, and none from behind") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = probed_scene({0.2, 0});
  without_haze(scene);
  scene.rig.ambient_lx = 0;
  fixtures::Display wall;
  wall.position_m = {0.5, 8.95, 2.4};
  wall.width_m = 6;
  wall.height_m = 3;
  wall.nits = 500;
  wall.color = {1, 0.3, 0.1};
  wall.columns = 12;
  wall.rows = 6;
  scene.rig.displays.push_back(wall);
  const auto mirrored_by = [&](const Scene& of) {
    const auto frame = make_frame(vulkan.device(), of, probe_settings(true));
    const RadianceImage with = draw(*frame, of);
    CHECK(draw(*frame, of).rgb == with.rgb);
    must(frame->change(probe_settings(false)));
    return minus(with.rgb, draw(*frame, of).rgb);
  };
  const auto dark = [](Scene& of) {
    of.compile();
    for (std::size_t i = 0; i < of.rig.fixtures.size(); ++i) of.set(i, "Dimmer", 0);
  };
  dark(scene);
  const std::vector<double> mirrored = mirrored_by(scene);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeScene judge = judge_scene(scene.rig, walker);
  const auto judged = [&](int rays) {
    judge.sheen_rays = rays;
    const JudgeOptions options{.tolerance = 1e-2, .stated_error = false};
    return judge_image(judge, view_of(scene.rig.cameras[0]), kWidth, kHeight, options).rgb;
  };
  const std::vector<double> all = judged(128), none = judged(0);
  double sum = 0, expected_sum = 0, error = 0, square = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double expected = all[i] - none[i];
    sum += mirrored[i];
    expected_sum += expected;
    error += (mirrored[i] - expected) * (mirrored[i] - expected);
    square += expected * expected;
  }
  print_error("probes, a display: of mirrored light", std::sqrt(error / square));
  print_error("probes, a display: sum over that of the rays", sum / expected_sum);
  CHECK(std::sqrt(error / square) < 0.34);  // a texel is 3 degrees wide; lavapipe gave 0.28
  CHECK(std::abs(sum / expected_sum - 1) < 0.15);
  scene.rig.displays[0].rotation_deg = {0, 0, 180};
  dark(scene);
  double behind = 0;
  for (const double light : mirrored_by(scene)) behind += std::abs(light);
  CHECK(behind < 0.01 * std::abs(sum));
}

TEST_CASE("a shiny floor mirrors a person in a bright coat brighter than one in a black coat") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = probed_scene({0.2, 0});
  without_haze(scene);
  fixtures::Scenery person = fixtures::default_scenery(fixtures::SceneryKind::kPerson);
  person.position_m = {0, 4, 0};
  const auto mirrored = [&](double albedo) {
    person.albedo = glm::dvec3(albedo);
    scene.rig.scenery = {person};
    const std::vector<std::uint8_t> levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    FrameSettings settings = probe_settings(true);
    settings.bodies = true;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const RadianceImage with = draw(*frame, scene);
    settings.probes = false;
    must(frame->change(settings));
    const std::vector<double> light = minus(with.rgb, draw(*frame, scene).rgb);
    return std::accumulate(light.begin(), light.end(), 0.0);
  };
  const double bright = mirrored(0.9), black = mirrored(0);
  print_error("probes, a person in a bright coat over one in black", bright / black);
  CHECK(bright > 1.001 * black);
}

TEST_CASE("what a floor mirrors is the same to the bit in each picture, and late where a picture has a part of a map") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = probed_scene({0.35, 0});
  const auto frame = make_frame(vulkan.device(), scene, probe_settings(true));
  const RadianceImage whole = draw(*frame, scene);
  CHECK(draw(*frame, scene).rgb == whole.rgb);
  must(frame->change(probe_settings(false)));
  const RadianceImage without = draw(*frame, scene);
  CHECK(without.rgb != whole.rgb);
  // A frame that was made without has none of its buffers.
  const auto other = make_frame(vulkan.device(), scene, probe_settings(false));
  CHECK(draw(*other, scene).rgb == without.rgb);
  CHECK_FALSE(other->change(probe_settings(true)).has_value());
  CHECK(other->resources().rig.probe_light.size_bytes <= 16);
  // A quarter of the map a picture: with other levels it takes four pictures until all of it is new.
  FrameSettings parts = probe_settings(true);
  must(frame->change(parts));
  std::vector<std::uint8_t> bright = scene.levels;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Dimmer", 0.25);
  const RadianceImage dim = draw(*frame, scene);
  std::swap(scene.levels, bright);
  CHECK(draw(*frame, scene).rgb == whole.rgb);
  parts.probe_texels = FL_PROBE_TEXELS / 4;
  must(frame->change(parts));
  std::swap(scene.levels, bright);
  for (int picture = 0; picture < 3; ++picture) CHECK(draw(*frame, scene).rgb != dim.rgb);
  CHECK(draw(*frame, scene).rgb == dim.rgb);
  // The picture after another state, or after some without the pass, mirrors nothing of the state before.
  std::swap(scene.levels, bright);
  const FrameState state = must(frame->save_state());
  must(frame->load_state(state));
  CHECK(draw(*frame, scene).rgb == whole.rgb);
  std::swap(scene.levels, bright);
  must(frame->change(probe_settings(false)));
  must(frame->change(parts));
  CHECK(draw(*frame, scene).rgb == dim.rgb);
  std::swap(scene.levels, bright);
  frame->forget_air();
  CHECK(draw(*frame, scene).rgb == whole.rgb);
}

TEST_CASE("a probe in a rig without anything solid has a tree whose first node ends it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = probed_scene({0.35, 0});
  scene.rig.boxes.clear();
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  const auto frame = make_frame(vulkan.device(), scene, probe_settings(true));
  if (frame->resources().rig.has_bounce) CHECK(frame->resources().rig.bounce_tree.size_bytes >= sizeof(TreeRow));
  const RadianceImage picture = draw(*frame, scene);
  CHECK(std::all_of(picture.rgb.begin(), picture.rgb.end(), [](float value) { return std::isfinite(value); }));
}

TEST_CASE("a rig with a shiny floor has a probe of its own, out to its floor and walls, and a matt one has none") {
  Scene scene = lamps_over({0.35, 0}, {1, 0});
  CHECK(scene.compiled.needs.probes);
  CHECK(!lamps_over({0.55, 0}, {1, 0}).compiled.needs.probes);  // too rough
  const std::vector<fixtures::ReflectionProbe> own = scene_probes(scene.rig);
  REQUIRE(own.size() == 1);
  CHECK(own[0].min_m.z <= 0);  // the top of the floor
  CHECK(own[0].max_m.y == 9);  // the face of the wall
  for (const fixtures::PatchedFixture& lamp : scene.rig.fixtures) {
    CHECK(glm::all(glm::lessThan(own[0].min_m, lamp.position_m)));
    CHECK(glm::all(glm::lessThan(lamp.position_m, own[0].max_m)));
  }
  // Without walls at the sides and in front it ends where floor and wall do, at most 10 m from the lamps.
  double left = 1e9, right = -1e9;
  for (const fixtures::PatchedFixture& lamp : scene.rig.fixtures) {
    left = std::min(left, lamp.position_m.x - 0.5);
    right = std::max(right, lamp.position_m.x + 0.5);
  }
  double low_x = 1e9, high_x = -1e9;
  for (const fixtures::StageBox& box : scene.rig.boxes) {
    low_x = std::min(low_x, box.min_m.x);
    high_x = std::max(high_x, box.max_m.x);
  }
  CHECK(own[0].min_m.x == std::max(low_x, left - 10));
  CHECK(own[0].max_m.x == std::min(high_x, right + 10));
  // A display before a wall is where the box ends, unless it shines to the wall.
  fixtures::Display display;
  display.position_m = {0, 8.25, 3};
  display.width_m = 4;
  display.height_m = 2;
  scene.rig.displays = {display};
  CHECK(scene_probes(scene.rig)[0].max_m.y == 8.25);
  scene.rig.displays[0].rotation_deg = {0, 0, 180};
  CHECK(scene_probes(scene.rig)[0].max_m.y == 9);
  scene.rig.displays.clear();
  // Where its middle is inside something it stands above that.
  const glm::dvec3 middle = *own[0].position_m;
  scene.rig.boxes.push_back({"tower", {middle.x - 1, middle.y - 1, 0}, {middle.x + 1, middle.y + 1, middle.z + 0.5}});
  CHECK(scene_probes(scene.rig)[0].position_m->z > middle.z + 0.5);
  // Those of the file replace it, and stand in the middle of their boxes.
  scene.rig.probes = {{{-2, -2, 0}, {4, 4, 3}}};
  REQUIRE(scene_probes(scene.rig).size() == 1);
  CHECK(*scene_probes(scene.rig)[0].position_m == glm::dvec3(1, 1, 1.5));
}

}  // namespace
}  // namespace footlight::render
