// Frames that show how they were computed, and the light on surfaces.
#include <cmath>
#include <cstdio>

#include "render/beam.h"
#include "render/reference/judge.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

TEST_CASE("the classes of a pixel's beams add up to the beams that its ray crosses") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_scene(31, 300);
  FrameSettings settings = judged_settings(192, 108);
  settings.view = FrameView::kClasses;
  settings.tile_error = FrameSettings{}.tile_error;
  settings.tile_beams = 0;
  const RadianceImage classes = draw_new(vulkan.device(), scene, settings);
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t i = 0; i < 192 * 108; i += 97) pixels.push_back(i);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgedPixels judged =
      judge_pixels(judge_scene(scene.rig, walker, gobos_of_judge(scene)), view_of(scene.camera), 192, 108, pixels);
  double sums[3] = {};
  double all = 0;
  int apart = 0;  // pixels whose ray touches a beam's edge
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      sums[c] += classes.rgb[3 * pixels[i] + c];
      sum += classes.rgb[3 * pixels[i] + c];
    }
    all += judged.hits[i];
    if (std::abs(sum - judged.hits[i]) > 1e-3) ++apart;
    CHECK(std::abs(sum - judged.hits[i]) < 2.001);
  }
  std::fprintf(stderr, "%.0f beams: %.0f for the pixel, %.0f smooth, %.0f records; %d of %zu pixels apart\n", all,
               sums[0], sums[1], sums[2], apart, pixels.size());
  CHECK(apart < static_cast<int>(pixels.size() / 50));
  for (const double sum : sums) CHECK(sum > 0.01 * all);
}

TEST_CASE("a frame of lux has the illuminance of each surface, from the definition") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(32, 12);
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"floor", {-40, -40, -0.2}, {40, 40, 0}, glm::dvec3(0.3)});
  scene.rig.ambient_lx = 2;
  scene.compile();
  scene.levels = levels;
  FrameSettings settings = judged_settings(96, 54);
  settings.view = FrameView::kLux;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  frame->set_work_light_lx(100);  // only to see by
  const RadianceImage lux = draw(*frame, scene);
  const std::vector<BeamRow> beams = must(frame->read_beams());
  REQUIRE(beams.size() == 12);
  const View view = view_of(scene.camera);
  int floor = 0;
  int lit = 0;
  for (int y = 0; y < 54; ++y) {
    for (int x = 0; x < 96; ++x) {
      const Ray ray = pixel_ray(view, 96, 54, x, y);
      const double t_m = -view.position_m.z / ray.direction.z;
      const glm::dvec3 away = ray.direction * t_m;
      const glm::dvec3 place = view.position_m + away;
      if (!(t_m > 0) || std::max(std::abs(place.x), std::abs(place.y)) > 39.9) continue;
      ++floor;
      glm::dvec3 expected(2);
      for (const BeamRow& row : beams) {
        const auto in_light = [&](const glm::dvec3& v) {
          return glm::dvec3(glm::dot(glm::dvec3(row.x_axis), v), glm::dot(glm::dvec3(row.y_axis), v),
                            glm::dot(glm::dvec3(row.axis), v));
        };
        const f64::BeamShape beam{row.x_axis.w, row.y_axis.w, row.axis.w, row.eye.w};
        glm::dvec2 rho;
        double r_m = 0;
        const double share = f64::beam_illuminance(beam, glm::dvec3(row.eye) + in_light(away), rho, r_m);
        if (!(share > 0)) continue;
        const double facing = -glm::dot(in_light({0, 0, 1}), f64::beam_direction(beam, rho));
        const double passes = std::exp(-(scene.rig.haze.scattering_per_m + scene.rig.haze.absorption_per_m) * r_m);
        expected += glm::dvec3(row.j0) * (share * passes * std::max(facing, 0.0));
      }
      if (expected.x + expected.y + expected.z > 6.1) ++lit;
      for (int c = 0; c < 3; ++c) {
        const double shown = lux.rgb[static_cast<std::size_t>(3 * (96 * y + x) + c)];
        CHECK(std::abs(shown - expected[c]) < 1e-4 * expected[c]);
      }
    }
  }
  CHECK(floor > 500);
  CHECK(lit > 100);
}

}  // namespace
}  // namespace footlight::render
