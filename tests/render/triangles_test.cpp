// Triangles that compute shaders draw, against those of the rasteriser: large ones, ones behind the camera, textures.
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "fixtures/gobos/png.h"
#include "render/frame.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::box_3ds;
using footlight::testing::file_3ds;
using footlight::testing::HeadlessVulkan;
using footlight::testing::MemoryFiles;
using footlight::testing::quad_glb;
using footlight::testing::TexturedQuad;

FrameSettings sized(int width, int height, TriangleMethod triangles, std::uint32_t edge_samples = 0) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.triangles = triangles;
  settings.edge_samples = edge_samples;
  return settings;
}

// Objects of this 3DS box of 1 m, in the light of the room.
Scene boxes_scene(const std::vector<glm::dmat4>& poses) {
  Scene scene;
  scene.rig.name = "boxes";
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = 100;
  scene.rig.files =
      std::make_shared<MemoryFiles>(std::map<std::string, std::string>{{"box.3ds", box_3ds(1000, 1000, 1000)}});
  fixtures::SceneObject object;
  object.name = "boxes";
  for (const glm::dmat4& pose : poses) object.parts.push_back({"box.3ds", pose});
  scene.rig.objects.push_back(object);
  scene.compile();
  return scene;
}

glm::dmat4 box_at(const glm::dvec3& low_m, const glm::dvec3& size_m, double turn_deg) {
  const glm::dmat4 moved = glm::translate(glm::dmat4(1), low_m);
  return glm::scale(glm::rotate(moved, glm::radians(turn_deg), glm::dvec3(0.3, 0.2, 1)), size_m);
}

// Pixels that one picture shows and the other does not, and those whose brightness differs by 2 %.
struct Unlike {
  int shown = 0;
  int others = 0;
  int brightness = 0;
};
Unlike unlike(const RadianceImage& one, const RadianceImage& other) {
  Unlike all;
  for (std::size_t i = 0; i < one.rgb.size(); i += 3) {
    all.shown += one.rgb[i] > 0 ? 1 : 0;
    all.others += (one.rgb[i] > 0) != (other.rgb[i] > 0) ? 1 : 0;
    all.brightness += std::abs(one.rgb[i] - other.rgb[i]) > 0.02F * one.rgb[i] ? 1 : 0;
  }
  return all;
}

// A long bar, a wall, small boxes, and a floor that reaches behind the camera.
Scene mixed_scene() {
  return boxes_scene({box_at({-20, 6, -1.5}, {40, 0.2, 0.2}, 8), box_at({-9, 12, -6}, {19, 0.5, 14}, 3),
                      box_at({0.4, 3, 0}, {0.3, 0.3, 0.3}, 30), box_at({-1, 2.5, 0.2}, {0.15, 0.2, 0.25}, 50),
                      box_at({-30, -30, -2.1}, {60, 90, 0.1}, 0)});
}

TEST_CASE("compute shaders draw objects as the rasteriser does, also large ones and those behind the camera") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = mixed_scene();
  const auto raster = make_frame(vulkan.device(), scene, sized(320, 180, TriangleMethod::kRasteriser));
  const auto compute = make_frame(vulkan.device(), scene, sized(320, 180, TriangleMethod::kCompute));
  const fixtures::Camera cameras[] = {{"front", {0, -3, 0.5}, {0, 5, 0}, 60, 4},
                                      {"in the bar", {-1, 6.15, -1.4}, {10, 6, 1}, 80, 4},
                                      {"in a box", {0.45, 3.2, 0.15}, {3, 8, 0.5}, 100, 4},
                                      {"on the floor", {0, -8, -1.99}, {0.3, 4, -2}, 40, 4},
                                      {"away", {0, -3, 0.5}, {0, -40, 80}, 60, 4}};
  for (const fixtures::Camera& camera : cameras) {
    CAPTURE(camera.name);
    scene.camera = camera;
    const RadianceImage one = draw(*raster, scene);
    const Unlike pixels = unlike(one, draw(*compute, scene));
    CHECK((pixels.shown > 5000 || camera.name == "away"));
    CHECK(pixels.others <= pixels.shown / 500 + 1);
    CHECK(pixels.brightness <= pixels.shown / 100 + 1);
  }
}

constexpr float kBoxPoints[] = {0, 0, 0,    1000, 0, 0,    0, 1000, 0,    1000, 1000, 0,
                                0, 0, 1000, 1000, 0, 1000, 0, 1000, 1000, 1000, 1000, 1000};
constexpr std::uint16_t kBoxCorners[] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};

// Closed boxes, one of them mirrored, one whose triangles face inwards, and one without two of its sides.
Scene shells_scene() {
  Scene scene = boxes_scene({});
  std::vector<std::uint16_t> corners(std::begin(kBoxCorners), std::end(kBoxCorners));
  const std::vector<float> points(std::begin(kBoxPoints), std::end(kBoxPoints));
  std::vector<std::uint16_t> inward;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    inward.insert(inward.end(), {corners[i], corners[i + 2], corners[i + 1]});
  }
  const std::vector<std::uint16_t> open(corners.begin() + 12, corners.end());
  scene.rig.files = std::make_shared<MemoryFiles>(
      std::map<std::string, std::string>{{"box.3ds", box_3ds(1000, 1000, 1000)},
                                         {"inward.3ds", file_3ds(points, inward, {255, 0, 128})},
                                         {"open.3ds", file_3ds(points, open, {255, 0, 128})}});
  fixtures::SceneObject object;
  object.name = "shells";
  object.parts.push_back({"box.3ds", box_at({0, 0, 0}, {1, 1, 1}, 10)});
  object.parts.push_back({"box.3ds", box_at({3, 0, 0}, {-1, 1, 0.7}, 20)});
  object.parts.push_back({"inward.3ds", box_at({4, 0, 0}, {1, 1, 1}, 30)});
  object.parts.push_back({"open.3ds", box_at({6, 0, 0}, {1, 1, 1}, 40)});
  scene.rig.objects.push_back(object);
  scene.compile();
  return scene;
}

// The rasteriser draws both sides of all triangles.
TEST_CASE("triangles that face away are left out of closed objects only, and not round the camera") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = shells_scene();
  for (const std::uint32_t samples : {0U, 16U}) {
    const auto raster = make_frame(vulkan.device(), scene, sized(240, 135, TriangleMethod::kRasteriser, samples));
    const auto compute = make_frame(vulkan.device(), scene, sized(240, 135, TriangleMethod::kCompute, samples));
    std::vector<fixtures::Camera> cameras = {{"front", {3, -5, 1.5}, {3, 0, 0.4}, 50, 4},
                                             {"behind", {3, 6, 1.5}, {3, 0, 0.4}, 50, 4},
                                             {"above", {3, 0.2, 6}, {3, 0.4, 0}, 50, 4},
                                             {"below", {3, 0.2, -6}, {3, 0.4, 0}, 50, 4}};
    for (const double x_m : {0.5, 2.5, 4.5, 6.5}) {
      cameras.push_back({"within", {x_m, 0.6, 0.4}, {3, 3, 0.7}, 90, 4});
      cameras.push_back({"close", {x_m, -0.4, 0.5}, {x_m, 1, 0.5}, 90, 4});
    }
    for (const fixtures::Camera& camera : cameras) {
      CAPTURE(camera.name);
      CAPTURE(camera.position_m.x);
      scene.camera = camera;
      const RadianceImage one = draw(*raster, scene);
      const Unlike pixels = unlike(one, draw(*compute, scene));
      CHECK(pixels.shown > 2000);
      CHECK(pixels.others <= pixels.shown / 500 + 1);
      CHECK(pixels.brightness <= pixels.shown / 100 + 1);
    }
  }
}

TEST_CASE("one round over triangles gives the same bits as two") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene boxes = mixed_scene();
  boxes.camera = {"front", {0, -3, 0.5}, {0, 5, 0}, 60, 4};
  Scene heads = demo_scene(5, false);
  heads.camera = {"close", {0, -6, 2}, {0, 0, 5}, 60, 4};
  for (const Scene* scene : {&boxes, &heads}) {
    for (const std::uint32_t samples : {0U, 16U}) {
      FrameSettings settings = sized(240, 135, TriangleMethod::kTwoRounds, samples);
      const auto frame = make_frame(vulkan.device(), *scene, settings);
      const RadianceImage two = draw(*frame, *scene);
      settings.triangles = TriangleMethod::kCompute;
      must(frame->change(settings));
      CHECK(two.rgb == draw(*frame, *scene).rgb);
    }
  }
}

TEST_CASE("more parts of large triangles than there is room for are drawn, and their edges") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Each box has the camera inside, so its triangles reach behind it; the last one hides all others.
  std::vector<glm::dmat4> poses;
  for (int i = 0; i < 9000; ++i) {
    const double half = 100 + 0.01 * (9000 - i);
    poses.push_back(box_at({-half, -half, -half}, {2 * half, 2 * half, 2 * half}, 0));
  }
  Scene many = boxes_scene(poses);
  Scene nearest = boxes_scene({poses.back()});
  many.camera = nearest.camera = {"c", {0, 0, 0}, {100, 95, 60}, 100, 4};
  for (const std::uint32_t samples : {0U, 16U}) {
    CAPTURE(samples);
    const FrameSettings settings = sized(48, 32, TriangleMethod::kCompute, samples);
    const RadianceImage seen = draw_new(vulkan.device(), nearest, settings);
    CHECK(seen.rgb[0] > 0);
    CHECK(unlike(seen, draw_new(vulkan.device(), many, settings)).brightness == 0);
  }
}

TEST_CASE("a picture whose edges are drawn in parts has the same bits") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = mixed_scene();
  scene.rig.boxes.push_back({"box", {-3, 5, -1.2}, {-1.5, 6, 2}, {0.8, 0.2, 0.2}});
  scene.compile();
  scene.camera = {"front", {0, -3, 0.5}, {0, 5, 0}, 60, 4};
  FrameSettings settings = sized(150, 90, TriangleMethod::kRasteriser, 16);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage whole = draw(*frame, scene);
  settings.edge_samples = 0;
  must(frame->change(settings));
  CHECK(whole.rgb != draw(*frame, scene).rgb);
  for (const int pixels : {1, 150 * 32}) {
    settings.edge_samples = 16;
    settings.edge_pixels = pixels;
    must(frame->change(settings));
    CHECK(whole.rgb == draw(*frame, scene).rgb);
  }
}

TEST_CASE("compute shaders show the textures of objects as the rasteriser does") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < 64 * 64; ++i) rgb.insert(rgb.end(), 3, static_cast<std::uint8_t>(60 + 2 * (i % 64) + i / 64));
  const auto bytes = fixtures::png_of(64, 64, 3, rgb);
  TexturedQuad quad;
  quad.width_m = quad.height_m = 2;
  quad.image = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  Scene scene;
  scene.rig.name = "print";
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = 100;
  scene.rig.files = std::make_shared<MemoryFiles>(std::map<std::string, std::string>{{"print.glb", quad_glb(quad)}});
  fixtures::SceneObject object;
  object.name = "print";
  object.parts.push_back({"print.glb", glm::rotate(glm::dmat4(1), 0.5, glm::dvec3(0, 0, 1))});
  scene.rig.objects.push_back(object);
  scene.compile();
  scene.camera = {"c", {0.4, -3, 1.2}, {0, 0, 1}, 40, 4};
  const RadianceImage one = draw_new(vulkan.device(), scene, sized(160, 90, TriangleMethod::kRasteriser));
  const Unlike pixels = unlike(one, draw_new(vulkan.device(), scene, sized(160, 90, TriangleMethod::kCompute)));
  CHECK(pixels.shown > 4000);
  CHECK(pixels.others <= pixels.shown / 500 + 1);
  CHECK(pixels.brightness <= pixels.shown / 100 + 1);
}

}  // namespace
}  // namespace footlight::render
