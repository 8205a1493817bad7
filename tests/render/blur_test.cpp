// Depth of field against pictures from many points of the lens.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 96;
constexpr int kHeight = 54;
constexpr int kMargin = 12;  // pixels that the lens's points may move a picture by
constexpr double kFocusM = 8;

// Blocks of several brightnesses at 5, 8 and 14 m before a wall at 20 m, lit evenly.
Scene blocks() {
  std::string text =
      "[rig]\nname = \"b\"\nambient_lx = 100\n[haze]\nscattering_per_m = 0\n"
      "[[box]]\nname = \"wall\"\nmin = [-30, 20, -20]\nmax = [30, 21, 20]\nalbedo = [0.2, 0.2, 0.2]\n";
  const auto box = [&](const char* name, double x, double y, double z, double side, double albedo) {
    text += std::string("[[box]]\nname = \"") + name + "\"\nmin = [" + std::to_string(x) + ", " + std::to_string(y) +
            ", " + std::to_string(z) + "]\nmax = [" + std::to_string(x + side) + ", " + std::to_string(y + 0.02) +
            ", " + std::to_string(z + side) + "]\nalbedo = [" + std::to_string(albedo) + ", " + std::to_string(albedo) +
            ", " + std::to_string(albedo) + "]\n";
  };
  box("near", -0.4, 5, -0.2, 0.2, 0.7);
  box("sharp", -0.1, 8, -0.3, 0.4, 0.5);
  box("far", 0.45, 14, 0.05, 0.5, 0.9);
  box("far dark", -1.1, 14, 0.2, 0.4, 0.05);
  text += "[[camera]]\nname = \"c\"\nposition = [0, 0, 0]\ntarget = [0, 8, 0]\nfov_deg = 6\nexposure_ev = 4\n";
  Scene scene;
  scene.rig = must(fixtures::parse_rig(text, "b.toml"));
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  return scene;
}

FrameSettings settings_of(int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.edge_samples = 0;
  return settings;
}

// The mean of pictures from the points of the lens that move what is in focus by whole pixels.
std::vector<double> from_lens(vk::Device& device, const Scene& scene, double f_stop) {
  const int width = kWidth + 2 * kMargin;
  const int height = kHeight + 2 * kMargin;
  const auto frame = make_frame(device, scene, settings_of(width, height));
  View view = view_of(scene.camera);
  const double pixel = 2 * view.tan_half_fov / kHeight;  // at a depth of 1
  const double lens_m = 0.5 * 0.012 / view.tan_half_fov / f_stop;
  view.tan_half_fov *= static_cast<double>(height) / kHeight;
  const double step_m = kFocusM * pixel;
  const int side = static_cast<int>(std::floor(lens_m / step_m));
  REQUIRE(side >= 3);
  REQUIRE(side <= kMargin);
  std::vector<double> sum(3 * kWidth * kHeight);
  int count = 0;
  for (int y = -side; y <= side; ++y) {
    for (int x = -side; x <= side; ++x) {
      if (std::hypot(x, y) * step_m > lens_m) continue;
      View moved = view;
      moved.position_m += step_m * (static_cast<double>(x) * view.right + static_cast<double>(y) * view.up);
      must(frame->draw(moved, 0));
      const RadianceImage one = must(frame->read_radiance());
      for (int row = 0; row < kHeight; ++row) {
        for (int column = 0; column < kWidth; ++column) {
          const int from_row = row + kMargin + y;
          const int from_column = column + kMargin - x;
          for (int c = 0; c < 3; ++c) {
            sum[static_cast<std::size_t>(3 * (row * kWidth + column) + c)] +=
                one.rgb[static_cast<std::size_t>(3 * (from_row * width + from_column) + c)];
          }
        }
      }
      ++count;
    }
  }
  for (double& each : sum) each /= count;
  return sum;
}

double total(const std::vector<float>& rgb) { return std::accumulate(rgb.begin(), rgb.end(), 0.0); }

TEST_CASE("a blurred picture is close to the mean of pictures from points of the lens, and keeps its light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = blocks();
  FrameSettings settings = settings_of(kWidth, kHeight);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage sharp = draw(*frame, scene);
  const std::uint64_t bytes = frame->bytes();
  settings.f_stop = 1;
  settings.focus_m = kFocusM;
  must(frame->change(settings));
  const RadianceImage blurred = draw(*frame, scene);
  CHECK(frame->bytes() - bytes >= 16u * kWidth * kHeight);
  const std::vector<double> reference = from_lens(vulkan.device(), scene, settings.f_stop);
  const double error = picture_norms(blurred.rgb, reference).rel_l2;
  const double unblurred = picture_norms(sharp.rgb, reference).rel_l2;
  const double kept = total(blurred.rgb) / total(sharp.rgb) - 1;
  std::fprintf(stderr, "blur: relL2 %.3g, of the sharp picture %.3g; light %+.3g\n", error, unblurred, kept);
  CHECK(error < 0.06);
  CHECK(error < unblurred / 3);
  CHECK(std::abs(kept) < 5e-3);
  CHECK(draw(*frame, scene).rgb == blurred.rgb);
  settings.f_stop = 0;
  must(frame->change(settings));
  CHECK(draw(*frame, scene).rgb == sharp.rgb);
  CHECK(frame->bytes() == bytes);
}

TEST_CASE("a surface of one brightness stays as it is at every distance, to the border of the picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = blocks();
  for (fixtures::StageBox& box : scene.rig.boxes) box.albedo = glm::dvec3(0.5);
  scene.compile();
  FrameSettings settings = settings_of(kWidth, kHeight);
  settings.f_stop = 1;
  settings.focus_m = kFocusM;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage image = draw(*frame, scene);
  const auto [low, high] = std::minmax_element(image.rgb.begin(), image.rgb.end());
  CHECK(*high < *low * 1.01f);
}

TEST_CASE("f-stops and focuses that no lens has are refused") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = blocks();
  const auto frame = make_frame(vulkan.device(), scene, settings_of(16, 16));
  for (const auto& [f_stop, focus_m] : {std::pair{0.1, 5.0}, {100.0, 5.0}, {2.0, 0.0}, {std::nan(""), 5.0}}) {
    FrameSettings settings = settings_of(16, 16);
    settings.f_stop = f_stop;
    settings.focus_m = focus_m;
    const Status refused = frame->change(settings);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("f-stop") != std::string::npos);
  }
}

}  // namespace
}  // namespace footlight::render
