// Tiles contain every beam that lights them: pictures of many beams in haze compared with sums without tiles.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "render/beam.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// The sum of all beams along every pixel's ray, in double, by the formula of the GPU. A difference beyond rounding
// means that a tile lacks a beam.
std::vector<double> sum_without_tiles(const Scene& scene, const std::vector<BeamRow>& beams, const FrameSettings& s) {
  const fixtures::Haze& haze = scene.rig.haze;
  const f64::Medium medium{haze.anisotropy, haze.scattering_per_m + haze.absorption_per_m};
  const View view = view_of(scene.camera);
  std::vector<double> rgb;
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      const glm::dvec3 ray = pixel_ray(view, s.width, s.height, x, y).direction;
      glm::dvec3 total(0);
      for (const BeamRow& row : beams) {
        const f64::BeamShape beam{static_cast<double>(row.x_axis.w), static_cast<double>(row.y_axis.w),
                                  static_cast<double>(row.axis.w), static_cast<double>(row.eye.w)};
        const glm::dvec3 d(glm::dot(glm::dvec3(row.x_axis), ray), glm::dot(glm::dvec3(row.y_axis), ray),
                           glm::dot(glm::dvec3(row.axis), ray));
        f64::Chord chord;
        if (!f64::beam_chord(beam, glm::dvec3(row.eye), d, 0, kAirRangeM, chord)) continue;
        total += glm::dvec3(row.j0) * f64::chord_inscatter_gauss(beam, medium, chord, d, s.nodes, true);
      }
      for (int c = 0; c < 3; ++c) rgb.push_back(haze.scattering_per_m * total[c]);
    }
  }
  return rgb;
}

TEST_CASE("no tile lacks a beam, with counts around the sizes of groups and iterations") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    int count;
    int width;
    int height;
  };
  // The tile pass tests 64 beams per group and 256 per iteration. A walk lists 256 beams at a time; a thread reads one
  // word of masks in rigs of up to 2048 beams, and up to eight in larger ones. The scenes have narrow beams of 0.1
  // degrees, cylinders and washes of 60 degrees.
  for (const Case& c :
       {Case{1, 130, 70}, Case{65, 130, 70}, Case{257, 80, 45}, Case{1030, 48, 27}, Case{2600, 16, 9}}) {
    CAPTURE(c.count);
    const Scene scene = lamps_scene(20, c.count);
    const FrameSettings settings = judged_settings(c.width, c.height);
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const RadianceImage picture = draw(*frame, scene);
    const auto beams = must(frame->read_beams());
    REQUIRE(beams.size() == static_cast<std::size_t>(c.count));
    const PictureNorms norms = picture_norms(picture.rgb, sum_without_tiles(scene, beams, settings));
    std::fprintf(stderr, "%d beams without tiles: relL2 %.3g, p99 %.3g, p99.9 %.3g, max %.3g\n", c.count, norms.rel_l2,
                 norms.p99, norms.p999, norms.max);
    CHECK(norms.nonfinite == 0);
    // Measured: relL2 3.3e-5, and at most 6.3e-4 of a value (of at least a hundredth of the mean), at the edges of
    // narrow beams, where float moves a ray by 1e-3 of the radius. The bounds are about three times that. A missing
    // beam exceeds them, even the dimmest one of a tile.
    CHECK(norms.rel_l2 < 1e-4);
    CHECK(norms.max < 2e-3);
  }
}

TEST_CASE("a frame of many beams is the sum of frames of one beam each") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr std::size_t kCount = 70;
  Scene scene = lamps_scene(21, kCount);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(80, 45));
  const RadianceImage together = draw(*frame, scene);
  std::vector<double> sum(together.rgb.size());
  for (std::size_t lit = 0; lit < kCount; ++lit) {
    std::vector<bool> lamps(kCount, false);
    lamps[lit] = true;
    dim_lamps(scene, lamps);
    const RadianceImage one = draw(*frame, scene);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(one.rgb[i]);
  }
  const PictureNorms norms = picture_norms(together.rgb, sum);
  std::fprintf(stderr, "%zu beams against one by one: relL2 %.3g, max %.3g\n", kCount, norms.rel_l2, norms.max);
  // 70 roundings of a float sum, in the worst case all with the same sign.
  CHECK(norms.max < 70 * 6e-8);
}

}  // namespace
}  // namespace footlight::render
