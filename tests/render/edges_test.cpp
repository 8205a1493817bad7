// Smooth edges of solid things, against pictures with 4 x 4 pixels for one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "render/image.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/model_bytes.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::box_3ds;
using footlight::testing::HeadlessVulkan;
using footlight::testing::MemoryFiles;

constexpr int kWidth = 128;
constexpr int kHeight = 72;
constexpr int kSide = 4;

FrameSettings sized(std::uint32_t edge_samples, TriangleMethod triangles = TriangleMethod::kRasteriser) {
  FrameSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.edge_samples = edge_samples;
  settings.triangles = triangles;
  settings.widen_thin = false;
  return settings;
}

// kSide x kSide pixels for one, with the same levels of bodies.
FrameSettings fine() {
  FrameSettings settings = sized(0);
  settings.width *= kSide;
  settings.height *= kSide;
  settings.body_error_px *= kSide;
  return settings;
}

// The root mean square of the errors of pixels, each as a share of the larger value.
struct Errors {
  double before = 0;  // jagged
  double after = 0;
  int pixels = 0;  // that differ between both
};
Errors errors_of(const RadianceImage& jagged, const RadianceImage& smooth, const RadianceImage& fine) {
  Errors errors;
  for (std::size_t p = 0; p < fine.rgb.size(); p += 3) {
    if (std::equal(&jagged.rgb[p], &jagged.rgb[p] + 3, &smooth.rgb[p])) continue;
    ++errors.pixels;
    double before = 0;
    double after = 0;
    double most = 1e-9;
    for (std::size_t c = p; c < p + 3; ++c) {
      const double value = fine.rgb[c];
      before = std::max(before, std::abs(jagged.rgb[c] - value));
      after = std::max(after, std::abs(smooth.rgb[c] - value));
      most = std::max({most, value, static_cast<double>(jagged.rgb[c]), static_cast<double>(smooth.rgb[c])});
    }
    errors.before += before * before / (most * most);
    errors.after += after * after / (most * most);
  }
  errors.before = std::sqrt(errors.before / std::max(errors.pixels, 1));
  errors.after = std::sqrt(errors.after / std::max(errors.pixels, 1));
  return errors;
}

// The demo's heads among boxes that are neither parallel to the picture nor to each other in it, and an object. lit:
// with beams in haze; else with the light of the room alone.
Scene solid_scene(bool lit) {
  Scene scene = demo_scene(5, false);
  scene.rig.boxes.push_back({"box", {-2, -3, 1}, {-1, -1, 3.5}, {0.8, 0.2, 0.2}});
  scene.rig.boxes.push_back({"box", {1, -4, 0.5}, {1.4, 0, 4.2}, {0.2, 0.7, 0.3}});
  scene.rig.boxes.push_back({"box", {-6, -2, 4}, {6, -1.8, 4.2}, {0.5, 0.5, 0.9}});
  scene.rig.ambient_lx = lit ? 5 : 100;
  if (!lit) {
    scene.rig.haze.scattering_per_m = 0;
    scene.rig.haze.absorption_per_m = 0;
  }
  scene.rig.files =
      std::make_shared<MemoryFiles>(std::map<std::string, std::string>{{"box.3ds", box_3ds(2000, 300, 1000)}});
  fixtures::SceneObject object;
  object.name = "box";
  glm::dmat4 pose(1);
  pose[0] = {0.9, 0.3, 0.2, 0};
  pose[2] = {-0.2, 0.1, 0.9, 0};
  pose[3] = {0.2, -2, 1.5, 1};
  object.parts.push_back({"box.3ds", pose});
  scene.rig.objects.push_back(object);
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  if (!lit) {
    for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Dimmer", 0);
  }
  scene.camera = {"c", {3.3, -12, 2.6}, {0.3, 0, 3.4}, 40, 4};
  return scene;
}

TEST_CASE("edges of boxes, bodies and objects are nearer to a picture with 4 x 4 pixels for one") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    bool lit;
    std::uint32_t samples;
    double error_max;  // a tenth more than lavapipe gave, as a share of the error of jagged edges
  };
  for (const bool lit : {false, true}) {
    const Scene scene = solid_scene(lit);
    const RadianceImage reference = averaged(draw_new(vulkan.device(), scene, fine()), kSide);
    const auto frame = make_frame(vulkan.device(), scene, sized(16));
    const auto picture = [&](std::uint32_t samples, TriangleMethod triangles) {
      must(frame->change(sized(samples, triangles)));
      return draw(*frame, scene);
    };
    const RadianceImage jagged = picture(0, TriangleMethod::kRasteriser);
    for (const Case& c : {Case{false, 4, 0.3}, Case{false, 16, 0.46}, Case{true, 16, 0.63}}) {
      if (c.lit != lit) continue;
      const Errors errors = errors_of(jagged, picture(c.samples, TriangleMethod::kRasteriser), reference);
      std::fprintf(stderr, "%s, %u samples: %d pixels, error %.3f before, %.3f after\n",
                   lit ? "lit in haze" : "light of the room", c.samples, errors.pixels, errors.before, errors.after);
      CHECK(errors.pixels > kWidth * kHeight / 50);
      CHECK(errors.after < c.error_max * errors.before);
      // Bodies that compute shaders draw have the same edges.
      const Errors computed = errors_of(jagged, picture(c.samples, TriangleMethod::kCompute), reference);
      CHECK(computed.after < c.error_max * errors.before);
    }
  }
}

TEST_CASE("edges of 24 bodies in one tile are nearer to a picture with 4 x 4 pixels for one") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = solid_scene(false);
  scene.rig.boxes.clear();
  scene.rig.objects.clear();
  const fixtures::PatchedFixture first = scene.rig.fixtures[0];
  scene.rig.fixtures.clear();
  for (int i = 0; i < 24; ++i) {
    scene.rig.fixtures.push_back(first);
    scene.rig.fixtures.back().name = "Head " + std::to_string(i + 1);
    scene.rig.fixtures.back().address = 1 + 20 * i;
    scene.rig.fixtures.back().position_m = {0.35 * (i % 6), 0.3 * (i % 5), 5 + 0.35 * (i / 6)};
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Dimmer", 0);
  scene.camera = {"c", {0.9, -23, 5.5}, {0.9, 0, 5.5}, 40, 4};
  const RadianceImage reference = averaged(draw_new(vulkan.device(), scene, fine()), kSide);
  const RadianceImage jagged = draw_new(vulkan.device(), scene, sized(0));
  const Errors errors = errors_of(jagged, draw_new(vulkan.device(), scene, sized(16)), reference);
  std::fprintf(stderr, "24 bodies: %d pixels, error %.3f before, %.3f after\n", errors.pixels, errors.before,
               errors.after);
  CHECK(errors.pixels > 50);
  CHECK(errors.after < 0.6 * errors.before);
}

TEST_CASE("smooth edges are the same in every picture, bit for bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = solid_scene(true);
  const auto frame = make_frame(vulkan.device(), scene, sized(16, TriangleMethod::kCompute));
  const RadianceImage first = draw(*frame, scene);
  CHECK(first.rgb == draw(*frame, scene).rgb);
  must(frame->change(sized(0, TriangleMethod::kCompute)));
  const RadianceImage jagged = draw(*frame, scene);
  CHECK(jagged.rgb == draw_new(vulkan.device(), scene, sized(0, TriangleMethod::kCompute)).rgb);
  CHECK(jagged.rgb != first.rgb);
  must(frame->change(sized(16, TriangleMethod::kCompute)));
  CHECK(first.rgb == draw(*frame, scene).rgb);
}

// One box, or one object of the same form, in front of nothing, in the light of the room.
Scene plate_scene(bool object, double width_m) {
  Scene scene;
  scene.rig.name = "plate";
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.ambient_lx = 100;
  const double half = width_m / 2;
  if (object) {
    scene.rig.files = std::make_shared<MemoryFiles>(
        std::map<std::string, std::string>{{"box.3ds", box_3ds(static_cast<float>(1000 * width_m), 100, 2000)}});
    fixtures::SceneObject plate;
    plate.name = "plate";
    glm::dmat4 pose(1);
    pose[3] = glm::dvec4(-half, -0.05, -1, 1);
    plate.parts.push_back({"box.3ds", pose});
    scene.rig.objects.push_back(plate);
  } else {
    scene.rig.boxes.push_back({"box", {-half, -0.05, -1}, {half, 0.05, 1}, {0.5, 0.5, 0.5}});
  }
  scene.compile();
  return scene;
}

double sum_of(const RadianceImage& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum;
}

TEST_CASE("a plate keeps its light while the camera moves by parts of a pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const bool object : {false, true}) {
    CAPTURE(object);
    Scene scene = plate_scene(object, 0.6);
    // [jagged, smooth]: the least and the largest sum
    double low[2] = {1e30, 1e30};
    double high[2] = {0, 0};
    for (int smooth = 0; smooth < 2; ++smooth) {
      const auto frame = make_frame(vulkan.device(), scene, sized(smooth == 0 ? 0 : 16));
      for (int step = 0; step < 8; ++step) {
        // A pixel is 0.15 m wide here. The camera turns, so the plate's distance hardly changes.
        const double shift = 0.15 * step / 8;
        scene.camera = {"c", {0, -15, 0}, {shift, 0, 0.4 * shift}, 40, 4};
        const double sum = sum_of(draw(*frame, scene));
        low[smooth] = std::min(low[smooth], sum);
        high[smooth] = std::max(high[smooth], sum);
      }
    }
    std::fprintf(stderr, "%s: light changes by %.3g jagged, %.3g smooth\n", object ? "object" : "box",
                 high[0] / low[0] - 1, high[1] / low[1] - 1);
    CHECK(high[0] / low[0] > 1.1);
    CHECK(high[1] / low[1] < 1.02);
  }
}

TEST_CASE("a number of samples that the shader lacks is refused, and edges can be added to a frame without them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = plate_scene(false, 1);
  const auto refused = Frame::create(vulkan.device(), scene.rig, scene.compiled, sized(5));
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message == "5 samples of a pixel with an edge: expected 0, 4, 8 or 16");
  const auto frame = make_frame(vulkan.device(), scene, sized(0));
  const RadianceImage jagged = draw(*frame, scene);
  must(frame->change(sized(8)));
  const RadianceImage smooth = draw(*frame, scene);
  CHECK(smooth.rgb != jagged.rgb);
  CHECK(smooth.rgb == draw_new(vulkan.device(), scene, sized(8)).rgb);
}

}  // namespace
}  // namespace footlight::render
