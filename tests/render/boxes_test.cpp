// Which stage box a pixel shows, against rays cut with every box in double.
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// Boxes whose colours tell them apart, in the light of the room alone.
glm::dvec3 color_of(int number) {
  const double share = number / 512.0;
  return {0.5, 0.1 + 0.8 * share, 0.1 + 0.8 * std::fmod(37 * share, 1.0)};
}
Scene boxes_scene(int count) {
  Scene scene;
  scene.rig.name = "boxes";
  scene.rig.ambient_lx = 100;
  Random random(91);
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 low{random.between(-9, 8), random.between(-6, 9), random.between(-1, 7)};
    const glm::dvec3 size{random.between(0.02, 1.5), random.between(0.02, 1.5), random.between(0.02, 1.5)};
    scene.rig.boxes.push_back({"box", low, low + size, color_of(i)});
  }
  scene.compile();
  scene.camera = {"c", {0.5, -7, 2.6}, {0.3, 0, 3.1}, 70, 4};
  return scene;
}

// The number of the nearest box along a ray that begins outside of it.
std::optional<int> nearest_box(const Scene& scene, const glm::dvec3& from, const glm::dvec3& way) {
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<int> found;
  for (std::size_t b = 0; b < scene.rig.boxes.size(); ++b) {
    const fixtures::StageBox& box = scene.rig.boxes[b];
    double enter = -std::numeric_limits<double>::infinity();
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.min_m[axis] - from[axis]) / way[axis];
      const double c = (box.max_m[axis] - from[axis]) / way[axis];
      enter = std::max(enter, std::min(a, c));
      leave = std::min(leave, std::max(a, c));
    }
    if (!(enter > 0 && enter <= leave && enter < nearest)) continue;
    nearest = enter;
    found = static_cast<int>(b);
  }
  return found;
}

void check_pixels(const HeadlessVulkan& vulkan, const Scene& scene, int width, int height) {
  FrameSettings settings = judged_settings(width, height);
  settings.bodies = false;
  const RadianceImage picture = draw_new(vulkan.device(), scene, settings);
  const View view = view_of(scene.camera);
  int wrong = 0;
  int at_edges = 0;
  int shown = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto box_at = [&](double dx, double dy) {
        const double aspect = static_cast<double>(width) / height;
        const double half = view.tan_half_fov;
        const double right = (2 * (x + 0.5 + dx) / width - 1) * half * aspect;
        const double up = (1 - 2 * (y + 0.5 + dy) / height) * half;
        return nearest_box(scene, view.position_m, view.forward + right * view.right + up * view.up);
      };
      const std::optional<int> box = box_at(0, 0);
      bool at_edge = false;
      for (const auto& [dx, dy] : {std::array{0.01, 0.0}, std::array{-0.01, 0.0}, std::array{0.0, 0.01},
                                   std::array{0.0, -0.01}}) {
        at_edge = at_edge || box_at(dx, dy) != box;
      }
      if (at_edge) {
        ++at_edges;
        continue;
      }
      const float* const rgb = &picture.rgb[3 * static_cast<std::size_t>(y * width + x)];
      const glm::dvec3 albedo = box ? color_of(*box) : glm::dvec3(0);
      const bool right = box ? rgb[0] > 0 && std::abs(rgb[1] / rgb[0] - albedo.g / albedo.r) < 1e-4 &&
                                   std::abs(rgb[2] / rgb[0] - albedo.b / albedo.r) < 1e-4
                             : rgb[0] == 0;
      if (!right) ++wrong;
      if (box) ++shown;
    }
  }
  CHECK(wrong == 0);
  CHECK(at_edges < width * height / 10);
  CHECK(shown > width * height / 10);
}

TEST_CASE("each pixel shows the nearest of 500 boxes, also in tiles that the picture cuts") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene many = boxes_scene(500);
  check_pixels(vulkan, many, 203, 117);
  check_pixels(vulkan, many, 64, 64);
  check_pixels(vulkan, boxes_scene(64), 96, 54);
  check_pixels(vulkan, boxes_scene(65), 96, 54);
}

// Tests of a device whose atomics come in the order of threads pass without the rule, too.
TEST_CASE("of boxes with the same face the first one is shown, of one round and of several") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = boxes_scene(0);
  scene.rig.boxes.assign(400, {"far", {50, 50, 50}, {51, 51, 51}, glm::dvec3(0.1)});
  for (std::size_t at = 63; at < scene.rig.boxes.size(); at += at < 130 ? 1 : 10) {
    scene.rig.boxes[at] = {"wall", {-3, 0, 0}, {3, 1.0 + static_cast<double>(at), 6}, color_of(static_cast<int>(at))};
  }
  scene.compile();
  FrameSettings settings = judged_settings(32, 18);
  settings.bodies = false;
  const RadianceImage picture = draw_new(vulkan.device(), scene, settings);
  const float* const middle = &picture.rgb[3 * (9 * 32 + 16)];
  const glm::dvec3 albedo = color_of(63);
  REQUIRE(middle[0] > 0);
  CHECK(middle[1] / middle[0] == doctest::Approx(albedo.g / albedo.r).epsilon(1e-4));
}

}  // namespace
}  // namespace footlight::render
