// Tubes: the light of strobes near them, against that of a line, and their flashes.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "fixtures/model/color.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr double kLengthM = 0.4, kFluxLm = 60'000, kFaceM = 0.125;  // of generic/strobe; its face below its top
constexpr double kAlbedo = 0.5;

// A strobe whose face is so far above a white floor. more: keys of its row.
Scene strobe_scene(double above_m, const std::string& mode, const std::string& more = "") {
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"Strobe\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0\n[[fixture]]\nname = \"S\"\n"
      "type = \"generic/strobe\"\nmode = \"" + mode + "\"\nuniverse = 1\naddress = 1\nposition = [0, 0, " +
          std::to_string(above_m + kFaceM) + "]\n" + more +
          "\n[[box]]\nname = \"Floor\"\nmin = [-20, -20, -1]\nmax = [20, 20, 0]\nalbedo = [0.5, 0.5, 0.5]\n",
      "strobe.toml"));
  scene.compile();
  return scene;
}

// Illuminance of the floor at a place, lx, by the luminance that a camera beside sees.
double lux_at(Frame& frame, const Scene& scene, double x_m) {
  fixtures::Camera camera = scene.rig.cameras.front();
  camera.position_m = {x_m + 0.3, -3, 1.5};
  camera.target_m = {x_m, 0, 0};
  camera.fov_deg = 0.2;
  must(frame.draw(view_of(camera), 10));
  const RadianceImage image = must(frame.read_radiance());
  const auto middle = 3 * (static_cast<std::size_t>(image.height / 2) * static_cast<std::size_t>(image.width) +
                           static_cast<std::size_t>(image.width / 2));
  const glm::dvec3 rgb(image.rgb[middle], image.rgb[middle + 1], image.rgb[middle + 2]);
  return fixtures::luminance(rgb) * 3.14159265358979 / kAlbedo;  // its white is that of 5,600 K
}

// Of a line that shines by Lambert's law, on a plane parallel to it, x_m beside its middle.
double line_lux(double distance_m, double x_m) {
  const auto part = [&](double s) {
    return s / (distance_m * distance_m + s * s) + std::atan(s / distance_m) / distance_m;
  };
  const double half = kLengthM / 2;
  return kFluxLm / (3.14159265358979 * kLengthM) * 0.5 * (part(half - x_m) + part(half + x_m));
}

TEST_CASE("near a tube the floor has the light of a line within half a per cent") {
  HeadlessVulkan vulkan;
  double worst = 0;
  for (const double distance_m : {0.6, 1.0, 2.0, 5.0}) {
    const Scene scene = strobe_scene(distance_m, "1 channel");
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(9, 9));
    frame->step(scene.levels, 0);
    for (const double x_m : {0.0, 0.2, 0.7, 2.0}) {
      CAPTURE(distance_m);
      CAPTURE(x_m);
      const double error = lux_at(*frame, scene, x_m) / line_lux(distance_m, x_m) - 1;
      worst = std::max(worst, std::abs(error));
      CHECK(std::abs(error) < 0.005);
    }
  }
  print_error("tube, from the light of a line", worst);
}

TEST_CASE("a tube has the mean light of its flashes over an exposure, and the level of its dimmer") {
  HeadlessVulkan vulkan;
  Scene scene = strobe_scene(2, "3 channels");
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(9, 9));
  const auto lux = [&](int dimmer, int rate, int duration, std::int64_t exposure_ns) {
    scene.slots(0)[0] = static_cast<std::uint8_t>(dimmer);
    scene.slots(0)[1] = static_cast<std::uint8_t>(rate);
    scene.slots(0)[2] = static_cast<std::uint8_t>(duration);
    frame->step(scene.levels, exposure_ns);
    return lux_at(*frame, scene, 0);
  };
  const double full = lux(255, 255, 0, 0);
  CHECK(full == doctest::Approx(line_lux(2, 0)).epsilon(0.005));
  CHECK(lux(51, 255, 0, 0) == doctest::Approx(0.2 * full).epsilon(1e-4));
  CHECK(lux(255, 0, 0, 0) == 0);
  // 30 flashes of 5 ms in a second.
  CHECK(lux(255, 250, 0, 1000 * kMs) == doctest::Approx(0.15 * full).epsilon(0.01));
}

TEST_CASE("a tube that tilts shines where it points, as the judge has it") {
  HeadlessVulkan vulkan;
  Scene scene = strobe_scene(2, "1 channel", "rotation = [35, 10, 20]\n");
  scene.rig.haze.scattering_per_m = 0.03;
  view_from(scene, {-3, -4, 2}, {0, 0.5, 1});
  scene.compile();
  const double error = rel_l2(drawn_light(vulkan.device(), scene, 32, 18, true), judged_light(scene, 32, 18));
  print_error("tube in haze, above a floor", error);
  CHECK(error < 2e-3);
}

}  // namespace
}  // namespace footlight::render
