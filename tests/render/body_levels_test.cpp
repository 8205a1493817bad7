// Which bodies a picture draws, at which level, and by which of the two rasterisers.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// The demo's fixtures without light, haze and boxes, every third one mirrored and stretched. A pixel is black unless it
// shows a body.
Scene dark_scene() {
  Scene scene = demo_scene(5, false);
  scene.rig.boxes.clear();
  scene.rig.haze = {};
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.haze.absorption_per_m = 0;
  scene.rig.ambient_lx = 100;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); i += 3) {
    glm::dmat4 pose(1);
    pose[0] *= -1;
    pose[2] *= 1.5;
    pose[3] = glm::dvec4(scene.rig.fixtures[i].position_m, 1);
    scene.rig.fixtures[i].pose = pose;
  }
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Dimmer", 0);
  scene.camera = {"c", {0, -12, 2}, {0, 0, 4}, 40, 4};
  return scene;
}

FrameSettings sized(int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.edge_samples = 0;  // a pixel is what its middle shows
  return settings;
}

bool shows(const RadianceImage& image, int x, int y) {
  return image.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(x))] > 0;
}

int pixels_shown(const RadianceImage& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += shows(image, x, y) ? 1 : 0;
  }
  return count;
}

double rel_l2(const RadianceImage& a, const RadianceImage& b) {
  double error = 0;
  double all = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    const double x = static_cast<double>(a.rgb[i]);
    error += (static_cast<double>(b.rgb[i]) - x) * (static_cast<double>(b.rgb[i]) - x);
    all += x * x;
  }
  return std::sqrt(error / all);
}

std::vector<fixtures::Camera> cameras(const Scene& scene) {
  const auto& fixtures = scene.rig.fixtures;
  std::vector<fixtures::Camera> all = {
      {"front", {0, -12, 2}, {0, 0, 4}, 40, 4},
      {"far", {0, -5000, 20}, {0, 0, 4}, 1, 4},
      {"below", {0.1, 0, -30}, {0, 0, 6}, 40, 4},
      {"within a body", fixtures[0].position_m - glm::dvec3(0, 0, 0.4), {0, -5, 3}, 50, 4},
      {"close", fixtures[1].position_m + glm::dvec3(0.3, -0.3, -0.5), fixtures[1].position_m, 50, 4},
      {"behind all", {0, -12, 2}, {0, -24, 2}, 40, 4},
  };
  Random random(7);
  for (int i = 0; i < 10; ++i) {
    const glm::dvec3 from(random.between(-6, 6), random.between(-6, 6), random.between(0, 8));
    const glm::dvec3 to(random.between(-6, 6), random.between(-6, 6), random.between(0, 8));
    all.push_back({"random " + std::to_string(i), from, to, random.between(5, 50), 4});
  }
  return all;
}

TEST_CASE(
    "no body is missing at the edge of a picture: the same pixels in the middle of a picture three times as large") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Scene scene = dark_scene();
  const auto frame = make_frame(vulkan.device(), scene, sized(8, 8));
  const auto around = make_frame(vulkan.device(), scene, sized(8, 8));
  for (const auto& [width, height] : {std::pair{63, 37}, std::pair{1, 1}}) {
    for (const TriangleMethod triangles : {TriangleMethod::kRasteriser, TriangleMethod::kCompute}) {
      FrameSettings settings = sized(width, height);
      settings.body_error_px = 0;
      settings.triangles = triangles;
      FrameSettings larger = settings;
      larger.width *= 3;
      larger.height *= 3;
      must(frame->change(settings));
      must(around->change(larger));
      int bodies = 0;
      for (const fixtures::Camera& camera : cameras(scene)) {
        CAPTURE(camera.name);
        CAPTURE(static_cast<int>(triangles));
        scene.camera = camera;
        const RadianceImage image = draw(*frame, scene);
        scene.camera.fov_deg = 2 * std::atan(3 * std::tan(camera.fov_deg * kDegree / 2)) / kDegree;
        const RadianceImage whole = draw(*around, scene);
        int others = 0;
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            others += shows(image, x, y) != shows(whole, x + width, y + height) ? 1 : 0;
          }
        }
        bodies += pixels_shown(image);
        // Corners are rounded to 1/256 of a pixel, once in each picture.
        CHECK(others <= pixels_shown(image) / 100 + (width > 1 ? 1 : 0));
      }
      CHECK(bodies > (width > 1 ? 2000 : 0));
    }
  }
}

TEST_CASE("compute shaders draw whole models as the rasteriser does") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = dark_scene();
  FrameSettings settings = sized(320, 180);
  settings.body_error_px = 0;
  settings.triangles = TriangleMethod::kRasteriser;
  const auto raster = make_frame(vulkan.device(), scene, settings);
  settings.triangles = TriangleMethod::kCompute;
  const auto compute = make_frame(vulkan.device(), scene, settings);
  for (const fixtures::Camera& camera : cameras(scene)) {
    CAPTURE(camera.name);
    scene.camera = camera;
    const RadianceImage one = draw(*raster, scene);
    const RadianceImage other = draw(*compute, scene);
    int others = 0;  // show something else
    int unlike = 0;  // have another brightness: of two faces in one plane, rounding chooses
    for (std::size_t i = 0; i < one.rgb.size(); i += 3) {
      others += (one.rgb[i] > 0) != (other.rgb[i] > 0) ? 1 : 0;
      unlike += std::abs(one.rgb[i] - other.rgb[i]) > 0.02F * one.rgb[i] ? 1 : 0;
    }
    CHECK(others <= pixels_shown(one) / 500 + 1);
    CHECK(unlike <= pixels_shown(one) / 100 + 1);
  }
}

TEST_CASE("plainer levels have fewer triangles and change few pixels") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const Scene scene = dark_scene();
  FrameSettings settings = sized(320, 180);
  settings.body_error_px = 0;
  const auto whole = make_frame(vulkan.device(), scene, settings);
  const RadianceImage exact = draw(*whole, scene);
  const BodyCounts all = must(whole->read_bodies());
  CHECK(all.bodies == 24);
  CHECK(all.drawn == 24);
  CHECK(all.drawn_triangles == all.triangles);
  std::uint64_t triangles = all.triangles;
  double error = 0;
  for (const double error_px : {0.25, 0.5, 2.0}) {
    CAPTURE(error_px);
    settings.body_error_px = error_px;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const RadianceImage image = draw(*frame, scene);
    const BodyCounts counts = must(frame->read_bodies());
    CHECK(counts.drawn == 24);
    CHECK(counts.drawn_triangles < triangles);
    triangles = counts.drawn_triangles;
    int others = 0;
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 320; ++x) others += shows(exact, x, y) != shows(image, x, y) ? 1 : 0;
    }
    // Half a pixel along the outline of a body of ten pixels is a fifth of it.
    CHECK(others <= 0.4 * error_px * pixels_shown(exact));
    CHECK(rel_l2(exact, image) > error);
    error = rel_l2(exact, image);
  }
  CHECK(triangles < all.triangles / 4);
}

TEST_CASE(
    "bodies behind the camera are left out, and those far away are not unless they are below a sixteenth of a pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = dark_scene();
  FrameSettings settings = sized(320, 180);
  const auto drawn = [&](const fixtures::Camera& camera) {
    scene.camera = camera;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    (void)draw(*frame, scene);
    const BodyCounts counts = must(frame->read_bodies());
    return counts.drawn;
  };
  CHECK(drawn({"away", {0, -20, 2}, {0, -40, 2}, 40, 4}) == 0);
  // A body of 0.5 m is 0.1 pixels wide at 1.2 km, and 0.01 pixels at 12 km.
  CHECK(drawn({"far", {0, -1200, 2}, {0, 0, 2}, 40, 4}) == 24);
  CHECK(drawn({"farther", {0, -12000, 2}, {0, 0, 2}, 40, 4}) == 0);
  settings.body_error_px = 0;
  CHECK(drawn({"farther", {0, -12000, 2}, {0, 0, 2}, 40, 4}) == 24);
}

TEST_CASE("bodies at the same place look the same in every picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = dark_scene();
  // Every body has a twin in its place: each pixel has two triangles of the same depth.
  const std::size_t count = scene.rig.fixtures.size();
  for (std::size_t i = 0; i < count; ++i) {
    fixtures::PatchedFixture twin = scene.rig.fixtures[i];
    twin.name += " twin";
    twin.shares_address = true;
    scene.rig.fixtures.push_back(twin);
  }
  scene.compile();
  for (const TriangleMethod triangles : {TriangleMethod::kRasteriser, TriangleMethod::kCompute}) {
    FrameSettings settings = sized(160, 90);
    settings.triangles = triangles;
    const RadianceImage first = draw_new(vulkan.device(), scene, settings);
    CHECK(pixels_shown(first) > 100);
    const auto frame = make_frame(vulkan.device(), scene, settings);
    for (int i = 0; i < 3; ++i) CHECK(draw(*frame, scene).rgb == first.rgb);
  }
}

TEST_CASE("settings of bodies out of range are refused") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = dark_scene();
  const auto frame = make_frame(vulkan.device(), scene, sized(64, 36));
  FrameSettings settings = sized(64, 36);
  settings.body_error_px = -1;
  CHECK(!frame->change(settings));
}

}  // namespace
}  // namespace footlight::render
