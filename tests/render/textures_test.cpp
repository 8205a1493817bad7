// Textures of objects of files, compared with the means of their images.
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "fixtures/builtin/builtin.h"
#include "fixtures/gobos/png.h"
#include "fixtures/model/srgb.h"
#include "render/frame.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using namespace render::testing;
using footlight::testing::HeadlessVulkan;
using footlight::testing::quad_glb;
using footlight::testing::TexturedQuad;

constexpr std::uint8_t kDark = 40;
constexpr std::uint8_t kBright = 200;
double light_of(std::uint8_t coded) { return fixtures::linear_of_srgb(coded / 255.0); }

// Cells x cells squares of so many texels a side, dark in the upper left corner.
std::string checkers(int cells, int texels) {
  std::vector<std::uint8_t> rgb;
  const int size = cells * texels;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) rgb.insert(rgb.end(), 3, (x / texels + y / texels) % 2 == 0 ? kDark : kBright);
  }
  const auto bytes = fixtures::png_of(size, size, 3, rgb);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A camera at a height of 1 m that sees an upright square of 2 m, `away_m` in front of it and turned by `turn_deg`.
Scene quad_scene(const TexturedQuad& quad, double away_m, double turn_deg) {
  Scene scene;
  scene.rig = fixtures::demo_rig();
  scene.rig.scenery.clear();
  scene.rig.boxes.clear();
  scene.rig.fixtures.clear();
  scene.rig.displays.clear();
  scene.rig.haze = {};
  scene.rig.ambient_lx = 100;
  scene.rig.cameras = {{"front", {0, -away_m, 1}, {0, 0, 1}, 40, 4}};
  scene.rig.files = std::make_shared<footlight::testing::MemoryFiles>(
      std::map<std::string, std::string>{{"print.glb", quad_glb(quad)}});
  fixtures::SceneObject object;
  object.name = "print";
  object.parts.push_back({"print.glb", glm::rotate(glm::dmat4(1), glm::radians(turn_deg), glm::dvec3(0, 0, 1))});
  scene.rig.objects.push_back(object);
  scene.compile();
  return scene;
}

TexturedQuad square(std::string image) {
  TexturedQuad quad;
  quad.width_m = quad.height_m = 2;
  quad.image = std::move(image);
  return quad;
}

FrameSettings texture_settings(int width, int height) {
  FrameSettings settings = judged_settings(width, height);
  settings.bodies = true;
  return settings;
}

// Red reflectance of each pixel, below 0 where the picture is black: light over that of a white texture.
std::vector<double> reflectances(vk::Device& device, const TexturedQuad& quad, double away_m, double turn_deg,
                                 int width, int height, FrameSettings settings) {
  settings.width = width;
  settings.height = height;
  TexturedQuad white = quad;
  const auto bytes = fixtures::png_of(1, 1, 3, std::vector<std::uint8_t>(3, 255));
  white.image.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const RadianceImage shown = draw_new(device, quad_scene(quad, away_m, turn_deg), settings);
  const RadianceImage all = draw_new(device, quad_scene(white, away_m, turn_deg), settings);
  std::vector<double> shares;
  for (std::size_t i = 0; i < all.rgb.size(); i += 3) {
    const double most = static_cast<double>(all.rgb[i]);
    shares.push_back(most > 0 ? static_cast<double>(shown.rgb[i]) / most : -1);
  }
  return shares;
}

TEST_CASE("a square of checkers shows the reflectance of each of them, times the colour of its material") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TexturedQuad quad = square(checkers(2, 16));
  // The square fills the picture's height of 32 pixels: 2 tan(20 deg) away.
  const double away_m = 1 / std::tan(glm::radians(20.0));
  const auto shares = reflectances(vulkan.device(), quad, away_m, 0, 32, 32, texture_settings(32, 32));
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      if (x == 15 || x == 16 || y == 15 || y == 16) continue;  // between two
      const double expected = light_of(x / 16 == y / 16 ? kDark : kBright);
      CHECK(shares[static_cast<std::size_t>(32 * y + x)] == doctest::Approx(expected).epsilon(0.03).scale(0.03));
    }
  }
  const RadianceImage shown = draw_new(vulkan.device(), quad_scene(quad, away_m, 0), texture_settings(32, 32));
  const std::size_t bright = 3 * (32 * 4 + 28);
  CHECK(shown.rgb[bright + 1] == doctest::Approx(shown.rgb[bright] / 2).epsilon(0.01));  // its green factor is 0.5
  CHECK(shown.rgb[bright + 2] == doctest::Approx(shown.rgb[bright]).epsilon(0.01));
}

TEST_CASE("checkers that are smaller than pixels show their mean, far away, seen at a slant and repeated") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const double mean = 0.5 * (light_of(kDark) + light_of(kBright));
  const auto check = [&](const TexturedQuad& quad, double away_m, double turn_deg, double off_max, const char* what) {
    const auto shares = reflectances(vulkan.device(), quad, away_m, turn_deg, 32, 18, texture_settings(32, 18));
    double sum = 0, square_sum = 0;
    int count = 0;
    for (const double share : shares) {
      if (share < 0) continue;
      sum += share;
      square_sum += (share - mean) * (share - mean);
      ++count;
    }
    REQUIRE(count > 20);
    const double rms = std::sqrt(square_sum / count) / mean;
    std::fprintf(stderr, "%s: %d pixels, mean %.4f of %.4f, rms %.3g of it\n", what, count, sum / count, mean, rms);
    CHECK(sum / count == doctest::Approx(mean).epsilon(0.01));
    CHECK(rms < off_max);
  };
  check(square(checkers(128, 2)), 4, 0, 0.02, "128 checkers");
  check(square(checkers(128, 2)), 3, 70, 0.05, "turned by 70 degrees");
  TexturedQuad repeated = square(checkers(2, 2));
  repeated.uvs = {0, 60, 60, 60, 60, 0, 0, 0};
  check(repeated, 4, 0, 0.02, "2 checkers, repeated 60 times");
}

TEST_CASE("edges of textured objects are smooth, and what is within them stays as it is") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TexturedQuad quad = square(checkers(8, 4));
  FrameSettings settings = texture_settings(64, 36);
  const Scene scene = quad_scene(quad, 2, 10);
  const RadianceImage jagged = draw_new(vulkan.device(), scene, settings);
  settings.edge_samples = 4;
  const RadianceImage smooth = draw_new(vulkan.device(), scene, settings);
  for (int y = 8; y < 28; ++y) {
    for (int x = 24; x < 40; ++x) {
      const auto at = static_cast<std::size_t>(3 * (64 * y + x));
      CHECK(smooth.rgb[at] == jagged.rgb[at]);
    }
  }
  int mixed = 0;
  for (std::size_t i = 0; i < smooth.rgb.size(); i += 3) mixed += jagged.rgb[i] == 0 && smooth.rgb[i] > 0 ? 1 : 0;
  CHECK(mixed > 10);
}

TEST_CASE("a rig without textures has no tables of them, and a damaged image leaves the plain colour with a warning") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  TexturedQuad quad = square("no picture");
  const auto frame = make_frame(vulkan.device(), quad_scene(quad, 4, 0), texture_settings(16, 9));
  CHECK(frame->resources().rig.texture_count == 0);
  CHECK(frame->resources().rig.textures.handle == VK_NULL_HANDLE);
  CHECK(frame->resources().rig.object_uvs.handle == VK_NULL_HANDLE);
  const auto& diagnostics = frame->resources().rig.diagnostics;
  REQUIRE(diagnostics.size() >= 1);
  CHECK(std::any_of(diagnostics.begin(), diagnostics.end(), [](const fixtures::Diagnostic& each) {
    return each.code == "mesh-texture" && each.assumed == "its materials have their plain colour";
  }));
  const RadianceImage plain = draw_new(vulkan.device(), quad_scene(quad, 4, 0), texture_settings(16, 9));
  const std::size_t middle = 3 * (16 * 4 + 8);
  CHECK(plain.rgb[middle] > 0);
  CHECK(plain.rgb[middle + 1] == doctest::Approx(plain.rgb[middle] / 2).epsilon(0.01));
  quad.image = checkers(2, 2);
  const auto textured = make_frame(vulkan.device(), quad_scene(quad, 4, 0), texture_settings(16, 9));
  CHECK(textured->resources().rig.texture_count == 1);
}

}  // namespace
