// Beams that are taken together for a tile against the same beams computed pixel by pixel.
#include <cstdio>

#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

PictureNorms against_general(vk::Device& device, const Scene& scene, FrameSettings settings, const char* what) {
  const double error = settings.tile_error;
  settings.tile_error = 0;
  const auto frame = make_frame(device, scene, settings);
  const RadianceImage general = draw(*frame, scene);
  settings.tile_error = error;
  must(frame->change(settings));
  const RadianceImage tiles = draw(*frame, scene);
  const std::vector<double> reference(general.rgb.begin(), general.rgb.end());
  const PictureNorms norms = picture_norms(tiles.rgb, reference);
  std::fprintf(stderr, "%s, tile error %.1g: relL2 %.3g, p99 %.3g, p99.9 %.3g, max %.3g\n", what, error, norms.rel_l2,
               norms.p99, norms.p999, norms.max);
  CHECK(norms.nonfinite == 0);
  return norms;
}

TEST_CASE("beams that are taken together for tiles give the picture of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double error : {1e-7, 4e-3}) {
    for (const int count : {1, 65, 300}) {
      FrameSettings settings = judged_settings(320, 180);
      settings.tile_error = error;
      (void)against_general(vulkan.device(), lamps_scene(20, count), settings, fmt::format("{} lamps", count).c_str());
    }
    FrameSettings settings = judged_settings(480, 270);
    settings.tile_error = error;
    (void)against_general(vulkan.device(), demo_scene(3, false), settings, "demo");
    settings.bodies = true;
    (void)against_general(vulkan.device(), demo_scene(3, false), settings, "demo with bodies");
  }
}

}  // namespace
}  // namespace footlight::render
