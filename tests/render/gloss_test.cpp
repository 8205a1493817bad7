// Floors that mirror: pictures against the judge, which sends rays from each place of a floor, and what must hold of
// them anywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fixtures/model/gloss.h"
#include "render/frame.h"
#include "render/mirror.h"
#include "render/reference/gloss_judge.h"
#include "render/reference/norms.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 32, kHeight = 18;

// Lamps in haze over a floor with its top at 0, in front of a wall and beside a box; seen from above the floor.
Scene lamps_over_floor(fixtures::Gloss gloss) {
  Scene scene = lamps_scene(3, 16);
  scene.rig.ambient_lx = 2;
  scene.rig.boxes = {{"floor", {-14, -14, -0.3}, {14, 14, 0}, glm::dvec3(0.06), gloss},
                     {"wall", {-10, 9, 0}, {10, 9.3, 7}, {0.6, 0.5, 0.4}},
                     {"riser", {-3, 2, 0}, {-1, 4, 1}, {0.3, 0.4, 0.6}}};
  scene.compile();
  const Scene levels = lamps_scene(3, 16);
  scene.levels = levels.levels;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", 8.0 + 3.0 * static_cast<double>(i));
  view_from(scene, {0.5, -10, 2.5}, {0, 0, 0.8});
  return scene;
}

// A room of grey walls without haze, where all light is the same: what a floor mirrors is as bright as itself.
Scene even_room(fixtures::Gloss gloss) {
  Scene scene;
  scene.rig.name = "room";
  scene.rig.haze = {0, 0, 0, 0};
  scene.rig.ambient_lx = 10;
  const glm::dvec3 grey(0.5);
  scene.rig.boxes = {{"floor", {-5, -5, -1}, {5, 5, 0}, grey, gloss}, {"top", {-5, -5, 4}, {5, 5, 5}, grey},
                     {"left", {-6, -6, -1}, {-5, 6, 5}, grey},        {"right", {5, -6, -1}, {6, 6, 5}, grey},
                     {"front", {-6, -6, -1}, {6, -5, 5}, grey},       {"back", {-6, 5, -1}, {6, 6, 5}, grey}};
  scene.rig.cameras.push_back({"room", {0.3, -4, 2}, {0, 0, 0.5}, 60, 4});
  scene.compile();
  return scene;
}

RadianceImage drawn(vk::Device& device, const Scene& scene, std::uint32_t gloss_px, int width = kWidth,
                    int height = kHeight) {
  return drawn_light(device, scene, width, height, true,
                     [&](FrameSettings& settings) { settings.gloss_px = gloss_px; });
}

std::vector<double> judged(const Scene& scene, int rays, double tolerance) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeScene judge = judge_scene(scene.rig, walker);
  judge.gloss_rays = rays;
  JudgeOptions options;
  options.stated_error = false;
  options.tolerance = tolerance;
  return judge_image(judge, view_of(scene.rig.cameras[0]), kWidth, kHeight, options).rgb;
}

double largest_difference(const RadianceImage& a, const RadianceImage& b) {
  REQUIRE(a.rgb.size() == b.rgb.size());
  double most = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    most = std::max(most, std::abs(static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i])));
  }
  return most;
}

bool all_finite(const RadianceImage& image) {
  return std::all_of(image.rgb.begin(), image.rgb.end(), [](float value) { return std::isfinite(value); });
}

TEST_CASE("a smooth floor mirrors beams, boxes and haze as the judge does") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_over_floor({1, 0});
  const std::vector<double> judge = judged(scene, 1, 1e-4);
  const double same_size = rel_l2(drawn(vulkan.device(), scene, 1), judge);
  print_error("smooth floor, a pixel a pixel", same_size);
  CHECK(same_size < 2e-3);
  const double matt = rel_l2(drawn(vulkan.device(), scene, 0), judge);
  print_error("smooth floor, matt", matt);
  CHECK(matt > 0.1);
}

TEST_CASE("a rough floor mirrors as the judge does, blurred") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double roughness : {0.05, 0.1, 0.2}) {
    const Scene scene = lamps_over_floor({1, roughness});
    const std::vector<double> judge = judged(scene, 256, 1e-3);
    const double error = rel_l2(drawn(vulkan.device(), scene, 1), judge);
    const double half = rel_l2(drawn(vulkan.device(), scene, 2), judge);
    print_error(("rough floor " + std::to_string(roughness)).c_str(), error);
    print_error("the same, half the size", half);
    const Scene smooth = lamps_over_floor({1, 0});
    const double sharp = rel_l2(drawn(vulkan.device(), smooth, 1), judge);
    print_error("the same, not blurred", sharp);
    CHECK(error < 0.2);
    CHECK(half < 0.5);
  }
}

// Pictures to look at: FOOTLIGHT_GLOSS_PICTURES names a folder.
TEST_CASE("pictures of a floor that mirrors have light" *
          doctest::skip(std::getenv("FOOTLIGHT_GLOSS_PICTURES") == nullptr)) {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(1, false);
  const std::vector<std::uint8_t> levels = scene.levels;
  const auto number = [](const char* name, double usual) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::atof(text) : usual;
  };
  scene.rig.boxes[0].gloss = {number("FOOTLIGHT_GLOSS", 0.05), number("FOOTLIGHT_ROUGHNESS", 0.1)};
  scene.compile();
  scene.levels = levels;
  FrameSettings settings;
  settings.width = 480;
  settings.height = 270;
  settings.edge_samples = 4;
  auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), scene.rig.cameras[0].exposure_ev));
  for (const auto& time : must(frame->read_times())) std::printf("%s %.2f ms\n", time.name.c_str(), time.gpu_ms);
  const ScreenImage screen = must(frame->read_screen());
  std::FILE* out = std::fopen((std::string(std::getenv("FOOTLIGHT_GLOSS_PICTURES")) + "/gloss.ppm").c_str(), "wb");
  REQUIRE(out != nullptr);
  std::fprintf(out, "P6 %d %d 255\n", screen.width, screen.height);
  for (std::size_t i = 0; i < screen.rgba.size(); i += 4) std::fwrite(&screen.rgba[i], 1, 3, out);
  std::fclose(out);
}

TEST_CASE("beside a floor that mirrors, shadow maps hide what exact shadows hide") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_over_floor({0.3, 0});
  scene.rig.boxes.push_back({"bar", {-6, -1, 2.2}, {6, -0.4, 2.8}, glm::dvec3(0.2)});
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  const auto picture = [&](std::uint32_t map_px, bool shadows) {
    const RadianceImage image = drawn_light(vulkan.device(), scene, 96, 54, true, [&](FrameSettings& settings) {
      settings.gloss_px = 2;
      settings.shadow_map_px = map_px;
      settings.shadows = shadows;
    });
    return image.rgb;
  };
  const std::vector<float> exact_rgb = picture(0, true);
  const std::vector<double> exact(exact_rgb.begin(), exact_rgb.end());
  const double maps = picture_norms(picture(64, true), exact).rel_l2;
  const double finer = picture_norms(picture(256, true), exact).rel_l2;
  const double none = picture_norms(picture(0, false), exact).rel_l2;
  std::fprintf(stderr, "maps beside a mirror: relL2 %.3g, with 256 texels %.3g, without shadows %.3g\n", maps, finer,
               none);
  CHECK(none > 0.05);
  CHECK(maps < 0.25 * none);
}

TEST_CASE("a floor in an even room is as bright as without gloss, however rough") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const RadianceImage matt = drawn(vulkan.device(), even_room({0, 0}), 2);
  for (const fixtures::Gloss gloss : {fixtures::Gloss{0.04, 0.1}, {1, 0}, {0.5, 0.5}}) {
    const RadianceImage mirrors = drawn(vulkan.device(), even_room(gloss), 2);
    CHECK(all_finite(mirrors));
    const double difference = largest_difference(matt, mirrors);
    CHECK_MESSAGE(difference < 1e-3 * static_cast<double>(matt.rgb[0]), difference, " of ", matt.rgb[0], " at ",
                  gloss.share, ", ", gloss.roughness);
  }
}

TEST_CASE("the mirrored share of the light is within 0 and 1 and grows towards a slant") {
  for (const double share : {0.0, 0.04, 0.5, 1.0}) {
    double before = 1;
    for (double cosine = 0; cosine <= 1; cosine += 1.0 / 64) {
      const double now = gloss_share({share, 0}, cosine);
      CHECK(now >= share);
      CHECK(now <= before);
      before = now;
    }
    CHECK(before == doctest::Approx(share));
  }
}

TEST_CASE("a camera in or below the plane of a floor sees nothing mirrored, and one pixel is finite") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_over_floor({1, 0.1});
  for (const double z : {0.0, -1e-9, 1e-4, -0.1, -3.0}) {
    view_from(scene, {0.5, -16, z}, {0, 0, z + 0.2});
    const RadianceImage mirrors = drawn(vulkan.device(), scene, 2);
    CHECK(all_finite(mirrors));
    CHECK(largest_difference(mirrors, drawn(vulkan.device(), scene, 0)) == 0);
  }
  view_from(scene, {0, 0, 1e-2}, {0, 0, -1});  // straight down, near the floor
  CHECK(all_finite(drawn(vulkan.device(), scene, 2)));
  view_from(scene, {0.5, -10, 2.5}, {0, 0, 0});
  const RadianceImage one = drawn(vulkan.device(), scene, 2, 1, 1);
  CHECK(all_finite(one));
  CHECK(sum_of(one) > 0);
  CHECK(all_finite(drawn(vulkan.device(), scene, 8, 33, 3)));
}

TEST_CASE("a frame with other settings of its mirror draws what a new one draws") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_over_floor({0.5, 0.1});
  FrameSettings settings = judged_settings(40, 24);
  auto frame = make_frame(vulkan.device(), scene, settings);
  for (const std::uint32_t gloss_px : {0u, 1u, 3u}) {
    settings.gloss_px = gloss_px;
    must(frame->change(settings));
    CHECK(largest_difference(draw(*frame, scene), draw_new(vulkan.device(), scene, settings)) == 0);
  }
  settings.gloss_px = 9;
  CHECK_FALSE(frame->change(settings));
}

TEST_CASE("a rig without gloss has no pass, no constant and no memory for it") {
  const Scene matt = lamps_over_floor({0, 0.1});
  const Scene mirrors = lamps_over_floor({0.04, 0.1});
  CHECK_FALSE(matt.compiled.needs.gloss);
  CHECK(mirrors.compiled.needs.gloss);
  const FrameSettings settings = judged_settings();
  const auto has_pass = [](const std::vector<PassPlan>& plan) {
    return std::any_of(plan.begin(), plan.end(), [](const PassPlan& pass) { return pass.name == "gloss"; });
  };
  const std::vector<PassPlan> plan = plan_frame(matt.compiled.needs, settings);
  CHECK_FALSE(has_pass(plan));
  for (const PassPlan& pass : plan) {
    const vk::SpecConstant on{FL_SPEC_GLOSS, 1};
    CHECK_MESSAGE(std::count(pass.constants.begin(), pass.constants.end(), on) == 0, pass.name);
  }
  CHECK(has_pass(plan_frame(mirrors.compiled.needs, settings)));
  const auto bytes = [&](const Scene& scene, std::uint32_t gloss_px) {
    FrameSettings own = settings;
    own.gloss_px = gloss_px;
    std::uint64_t sum = 0;
    for (const PassMemory& pass : plan_memory({scene.rig, scene.compiled, scene.compiled.needs, own})) {
      sum += pass.bytes;
    }
    return sum;
  };
  CHECK(bytes(matt, 2) == bytes(matt, 0));
  CHECK(bytes(mirrors, 0) == bytes(matt, 0));
  CHECK(bytes(mirrors, 2) > bytes(matt, 2));
}

TEST_CASE("a mirrored camera sees the same pixels of a scene that is mirrored itself") {
  const View view = view_of({"any", {1, -8, 2}, {0.3, 0, 1}, 50, 4});
  const View other = mirrored(view, 0.5);
  CHECK(other.position_m.z == doctest::Approx(-1));
  const glm::dvec3 place(2, 3, 1.7), below(2, 3, 2 * 0.5 - 1.7);
  const auto seen = [](const View& from, const glm::dvec3& point) {
    const glm::dvec3 way = point - from.position_m;
    return glm::dvec3(glm::dot(way, from.right), glm::dot(way, from.up), glm::dot(way, from.forward));
  };
  CHECK(glm::length(seen(view, below) - seen(other, place)) < 1e-12);
}

TEST_CASE("gloss of a rig file is read, and refused where its floors are at two heights") {
  const auto rig = [](const std::string& more) {
    return fixtures::parse_rig("[rig]\nname = \"Gloss\"\n" + more, "gloss.toml");
  };
  const std::string floor = "[[box]]\nname = \"Floor\"\nmin = [-2, -1, -1]\nmax = [2, 3, 0.03]\ngloss = 0.04\n";
  const auto read = must(rig(floor + "roughness = 0.2\n[[scenery]]\nkind = \"dance-floor\"\nname = \"Dance\"\n"
                                     "position = [10, 0, 0]\nrotation = [0, 0, 90]\nwidth_m = 6\ngloss = 0.1\n"));
  const auto tops = fixtures::gloss_tops(read);
  REQUIRE(tops.size() == 2);
  CHECK(tops[0].gloss.roughness == 0.2);
  CHECK(tops[0].center_m == glm::dvec3(0, 1, 0.03));
  CHECK(tops[1].gloss.share == 0.1);
  CHECK(tops[1].half_x_m.y == doctest::Approx(3));
  const auto refused = [&](const std::string& more) {
    const auto bad = rig(more);
    REQUIRE_FALSE(bad);
    return bad.error().message;
  };
  CHECK(refused(floor + "[[box]]\nname = \"Riser\"\nmin = [0, 0, 0]\nmax = [1, 1, 0.4]\ngloss = 0.04\n")
            .find("\"Riser\" at 0.4 m: expected one height of gloss") != std::string::npos);
  CHECK(
      refused("[[scenery]]\nkind = \"riser\"\nname = \"R\"\nrotation = [5, 0, 0]\ngloss = 0.04\n").find("not level") !=
      std::string::npos);
  CHECK(refused("[[box]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ngloss = 1.5\n").find("gloss") != std::string::npos);
  CHECK(refused("[[box]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nroughness = 0.1\n").find("gloss") != std::string::npos);
}

}  // namespace
}  // namespace footlight::render
