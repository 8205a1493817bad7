// Beams thinner than a pixel, supersampling, and the rounding to 8 bits.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fixtures/simulate/walker.h"
#include "render/beam.h"
#include "render/reference/judge.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

FrameSettings small_settings(int width = 160, int height = 90) {
  FrameSettings settings = judged_settings(width, height);
  settings.widen_thin = true;
  return settings;
}

// A laser from the left that crosses the picture, 16 m away, at an upward angle. zoom_deg: full angle of the beam.
Scene laser_scene(double radius_m, double profile_power, double rise_deg, double zoom_deg) {
  Scene scene = lamps_scene(1, 1);
  scene.rig.haze = {0.02, 0, 0.3, 40};
  scene.rig.types[0].beams[0].radius_m = radius_m;
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.type = 0;
  lamp.position_m = {-12, 2, 3.013};
  lamp.rotation_deg = {0, -90 - rise_deg, 0};
  for (fixtures::Channel& channel : scene.rig.types[0].modes[0].channels) {
    fixtures::ChannelFunction& function = channel.functions.front();
    if (function.attribute == "Zoom") function.physical_to = 170;
  }
  scene.compile();
  // Sets the profile in the compiled table, because frost gives profiles that no fixture type has.
  for (fixtures::TypeRow& type : scene.compiled.types) type.profile_power = static_cast<float>(profile_power);
  scene.compiled.needs.profile = true;
  scene.set(0, "Zoom", zoom_deg);
  for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(0, color, 1);
  return scene;
}

// Green radiance summed over each column of a picture, times the height of a pixel at a depth of 1.
std::vector<double> column_sums(const RadianceImage& picture, const View& view) {
  std::vector<double> sums(static_cast<std::size_t>(picture.width), 0.0);
  for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) {
    sums[i % sums.size()] += static_cast<double>(picture.rgb[3 * i + 1]) * 2 * view.tan_half_fov / picture.height;
  }
  return sums;
}

// The judge's value for one column, over 40 rays through the laser's cross section.
double judged_sum(const JudgeScene& judge, const View& view, int width, int height, int x) {
  const JudgeBeam& beam = judge.beams.at(0);
  const Ray middle = pixel_ray(view, width, height, x, 0);
  const double across = (2 * (x + 0.5) / width - 1) * view.tan_half_fov * width / height;
  // The point where the beam's axis crosses the plane through the camera and the column.
  const glm::dvec3 n = glm::cross(view.forward + view.right * across, view.up);
  const double along = glm::dot(n, view.position_m - beam.lens_m) / glm::dot(n, beam.axis);
  const glm::dvec3 at = beam.lens_m + beam.axis * along - view.position_m;
  const double depth = glm::dot(at, view.forward);
  const double up = glm::dot(at, view.up) / depth;
  const double reach = 2 * (beam.lens_radius_m + beam.spread * along) / depth;
  constexpr int kRays = 40;
  double sum = 0;
  for (int i = 0; i < kRays; ++i) {
    const double high = up + reach * ((i + 0.5) * 2 / kRays - 1);
    const Ray ray{middle.origin_m, glm::normalize(view.forward + view.right * across + view.up * high)};
    sum += judge_radiance(judge, ray, 1e-6).y * 2 * reach / kRays;
  }
  return sum;
}

// Makes the lamp's beams rectangular, with radius_m as half their width. Keeps the profile and the levels.
void make_rectangular(Scene& scene, double aspect) {
  const float profile_power = scene.compiled.types.front().profile_power;
  const auto levels = scene.levels;
  scene.rig.types[0].beams[0].type = fixtures::BeamType::kRectangle;
  scene.rig.types[0].beams[0].rectangle_ratio = aspect;
  scene.compile();
  scene.levels = levels;
  for (fixtures::TypeRow& type : scene.compiled.types) type.profile_power = profile_power;
  scene.compiled.needs.profile = true;
}

// Largest relative difference between the sums of some columns and the judge's.
double worst_column(vk::Device& device, const Scene& scene, std::initializer_list<int> columns) {
  const View view = view_of(scene.camera);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgeScene judge = judge_scene(scene.rig, walker);
  const auto sums = column_sums(draw_new(device, scene, small_settings()), view);
  double worst = 0;
  for (const int x : columns) {
    const double expected = judged_sum(judge, view, 160, 90, x);
    REQUIRE(expected > 0);
    worst = std::max(worst, std::abs(sums[static_cast<std::size_t>(x)] / expected - 1));
  }
  return worst;
}

TEST_CASE("a laser of 4 mm has as much light as the judge's in every column of 160 x 90 pixels, at every angle") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  double worst = 0;
  for (const double m : {0.25, 1.0 / 3, 0.5, 1.0, 2.0, 3.0, 4.0}) {
    for (const double rise_deg : {0.0, 1.3, 20.0, -45.0}) {
      CAPTURE(m);
      CAPTURE(rise_deg);
      const Scene scene = laser_scene(0.002, m, rise_deg, 0);
      worst = std::max(worst, worst_column(vulkan.device(), scene, {25, 40, 41, 42, 43, 51}));
    }
  }
  std::fprintf(stderr, "laser in the haze: sums over columns differ by %.3g at most\n", worst);
  CHECK(worst < 0.012);
}

TEST_CASE("a rectangular laser has as much light as the judge's in every column, at every aspect ratio") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  double worst = 0;
  for (const double aspect : {0.5, 2.0, 14.0}) {
    for (const double rise_deg : {0.0, 20.0}) {
      CAPTURE(aspect);
      CAPTURE(rise_deg);
      Scene scene = laser_scene(0.002, 1.0 / 3, rise_deg, 0);
      make_rectangular(scene, aspect);
      const double off = worst_column(vulkan.device(), scene, {25, 40, 43});
      CHECK(off < 0.012);
      worst = std::max(worst, off);
    }
  }
  std::fprintf(stderr, "rectangular laser in the haze: sums over columns differ by %.3g at most\n", worst);
}

TEST_CASE("a rectangular laser lights no pixel that is more than four pixels from its axis") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = laser_scene(0.002, 1, 0, 0);
  make_rectangular(scene, 14);
  const RadianceImage picture = draw_new(vulkan.device(), scene, small_settings());
  std::size_t fewest = 90;
  std::size_t most = 0;
  for (std::size_t x = 25; x < 140; ++x) {
    std::size_t lit = 0;
    for (std::size_t y = 0; y < 90; ++y) lit += picture.rgb[(y * 160 + x) * 3 + 1] > 0 ? 1 : 0;
    fewest = std::min(fewest, lit);
    most = std::max(most, lit);
  }
  CHECK(fewest >= 2);
  CHECK(most <= 5);
}

TEST_CASE("a rectangular beam many pixels wide and a fiftieth of a pixel high has all of its light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = laser_scene(0.6, 1.0 / 3, 0, 0);
  make_rectangular(scene, 300);
  scene.rig.cameras = {{"c", {0, -1, 18}, {0, 2, 3}, 55, 4}};  // sees it from its narrow side
  scene.camera = scene.rig.cameras.front();
  const double worst = worst_column(vulkan.device(), scene, {40, 41, 42, 43, 51, 100});
  std::fprintf(stderr, "thin bar in the haze: sums over columns differ by %.3g at most\n", worst);
  CHECK(worst < 0.02);
}

TEST_CASE("the light of a widening beam changes by less than a tenth where it becomes as wide as a pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  // 2 cm to 34 cm of radius; a pixel is 19 cm.
  const Scene scene = laser_scene(0.02, 2, 1.3, 1.5);
  const View view = view_of(scene.camera);
  const auto sums = column_sums(draw_new(vulkan.device(), scene, small_settings()), view);
  const auto fine = column_sums(draw_new(vulkan.device(), scene, judged_settings(800, 450)), view);
  double worst = 0;
  for (std::size_t x = 25; x < 140; ++x) {
    double expected = 0;
    for (std::size_t i = 0; i < 5; ++i) expected += fine[5 * x + i] / 5;
    worst = std::max(worst, std::abs(sums[x] / expected - 1));
  }
  std::fprintf(stderr, "widening beam: sums over columns differ by %.3g at most\n", worst);
  // Just above the limit of widening the beam is 1.3 pixels wide. There it has the sampling error of any picture.
  CHECK(worst < 0.1);
}

// Light that the floor at z = 0 reflects: green radiance times the floor's area, summed over the picture.
double floor_light(const RadianceImage& picture, const View& view) {
  double light = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Ray ray = pixel_ray(view, picture.width, picture.height, x, y);
      if (!(ray.direction.z < -1e-3)) continue;
      const double t_m = -view.position_m.z / ray.direction.z;
      const double depth = glm::dot(ray.direction, view.forward);
      const double pixel = 2 * view.tan_half_fov / picture.height;
      // Area of the floor behind the pixel: solid angle times distance squared, over the cosine.
      const double area = pixel * pixel * depth * depth * depth * t_m * t_m / -ray.direction.z;
      light += static_cast<double>(picture.rgb[static_cast<std::size_t>(y * picture.width + x) * 3 + 1]) * area;
    }
  }
  return light;
}

// A floor without haze, and a camera 10 m away that is aimed at its centre.
Scene floor_scene(double radius_m, double profile_power, double zoom_deg, double camera_m) {
  Scene scene = laser_scene(radius_m, profile_power, 0, zoom_deg);
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.boxes.push_back({"floor", {-20, -20, -1}, {20, 20, 0}, glm::dvec3(0.5)});
  scene.rig.cameras = {{"c", {0, -10, camera_m}, {0, 0, 0}, 40, 4}};
  scene.camera = scene.rig.cameras.front();
  scene.rig.fixtures.front().rotation_deg = {0, 0, 0};  // down
  return scene;
}

// Largest relative difference between the light on the floor and the lamp's, for some places of the lamp.
double worst_floor(vk::Device& device, Scene& scene, double lamp_m, int places) {
  const View view = view_of(scene.camera);
  double worst = 0;
  for (int i = 0; i < places; ++i) {
    scene.rig.fixtures.front().position_m = {0.013 * i, 0.11 * i, lamp_m};
    const float profile_power = scene.compiled.types.front().profile_power;
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    for (fixtures::TypeRow& type : scene.compiled.types) type.profile_power = profile_power;
    scene.compiled.needs.profile = true;
    const double light = floor_light(draw_new(device, scene, small_settings()), view);
    const double expected = scene.rig.types[0].beams[0].flux_lm * 0.5 / std::numbers::pi;
    worst = std::max(worst, std::abs(light / expected - 1));
  }
  return worst;
}

TEST_CASE("the spot of a thin beam on a floor has all of its light, at every offset between pixels and every angle") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  double worst = 0;
  for (const double height_m : {10.0, 4.0, 2.0}) {  // 45 to 11 degrees above the floor
    Scene scene = floor_scene(0.002, 1, 0, height_m);
    worst = std::max(worst, worst_floor(vulkan.device(), scene, 6, 8));
  }
  std::fprintf(stderr, "thin beam on a floor: light differs by %.3g at most\n", worst);
  CHECK(worst < 0.015);
}

TEST_CASE("the spot of a thin rectangular beam on a floor has all of its light, at every angle and width") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  double worst = 0;
  for (const double height_m : {10.0, 2.0}) {
    for (const auto& [aspect, radius_m] : {std::pair(14.0, 0.002), std::pair(1.0 / 14, 0.002), std::pair(200.0, 0.7)}) {
      CAPTURE(height_m);
      CAPTURE(aspect);
      Scene scene = floor_scene(radius_m, 1.0 / 3, 0, height_m);
      make_rectangular(scene, aspect);
      const double off = worst_floor(vulkan.device(), scene, 6, 2);
      CHECK(off < 0.03);
      worst = std::max(worst, off);
    }
  }
  std::fprintf(stderr, "thin bar on a floor: light differs by %.3g at most\n", worst);
}

TEST_CASE("the spot of a wide beam on a floor so near its lens that the spot is thin has all of its light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  double worst = 0;
  for (const double m : {0.25, 1.0, 4.0}) {
    for (const double zoom_deg : {40.0, 90.0}) {
      CAPTURE(m);
      CAPTURE(zoom_deg);
      Scene scene = floor_scene(0.002, m, zoom_deg, 10);
      const double off = worst_floor(vulkan.device(), scene, 0.02, 1);
      CHECK(off < 0.015);
      worst = std::max(worst, off);
    }
  }
  std::fprintf(stderr, "thin spot of a wide beam on a floor: light differs by %.3g at most\n", worst);
}

TEST_CASE("a beam along a floor lights nothing beside the plane of its lens, and all of its light is within its cone") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double zoom_deg : {22.6, 90.0, 119.0}) {
    CAPTURE(zoom_deg);
    Scene scene = floor_scene(0.05, 1, zoom_deg, 10);
    // A pixel is 4 cm across the line of sight.
    scene.rig.cameras = {{"c", {2, -42, 42}, {2, 0, 0}, 3.44, 4}};
    scene.camera = scene.rig.cameras.front();
    const View view = view_of(scene.camera);
    fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
    lamp.position_m = {0, 0, 1};
    lamp.rotation_deg = {0, -90, 0};
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    const RadianceImage picture = draw_new(vulkan.device(), scene, small_settings());
    const RadianceImage fine = draw_new(vulkan.device(), scene, judged_settings(640, 360));
    const auto largest = [](const RadianceImage& image) {
      return *std::max_element(image.rgb.begin(), image.rgb.end());
    };
    const double light = floor_light(picture, view);
    const double expected = floor_light(fine, view);
    std::fprintf(stderr, "beam along a floor: %.3g of the light, %.3g of the peak\n", light / expected,
                 static_cast<double>(largest(picture) / largest(fine)));
    CHECK(std::abs(light / expected - 1) < 0.01);
    CHECK(largest(picture) < 1.05f * largest(fine));
  }
}

TEST_CASE("beams wider than two pixels are not widened, to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = laser_scene(0.5, 2, 10, 6);
  scene.rig.boxes.push_back({"floor", {-20, -20, -1}, {20, 20, 0}, glm::dvec3(0.5)});
  const auto levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  CHECK(draw_new(vulkan.device(), scene, small_settings()).rgb ==
        draw_new(vulkan.device(), scene, judged_settings(160, 90)).rgb);
}

TEST_CASE("in haze a wide beam from a small lens and a beam around the camera are not widened, to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto unchanged = [&](const Scene& scene) {
    return draw_new(vulkan.device(), scene, small_settings()).rgb ==
           draw_new(vulkan.device(), scene, judged_settings(160, 90)).rgb;
  };
  for (const double zoom_deg : {15.0, 40.0, 150.0}) {
    CAPTURE(zoom_deg);
    CHECK(unchanged(laser_scene(0.05, 1, 10, zoom_deg)));
  }
  Scene scene = laser_scene(0.02, 1, 0, 8);
  scene.rig.cameras = {{"c", {8, 2, 3.3}, {-12, 2, 3.013}, 40, 4}};
  scene.camera = scene.rig.cameras.front();
  CHECK(unchanged(scene));
  scene.rig.cameras = {{"c", {8, -10, 3.3}, {-12, 2, 3.013}, 40, 4}};  // beside it
  scene.camera = scene.rig.cameras.front();
  CHECK_FALSE(unchanged(scene));
}

TEST_CASE("with 2 x 2 supersampling a screen pixel is the tone map of the mean radiance of its four pixels") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(19, false);
  FrameSettings settings;
  settings.width = 96;
  settings.height = 54;
  settings.supersample = 2;
  settings.glare = 0;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.camera), 4.6));
  const ScreenImage screen = must(frame->read_screen());
  const RadianceImage fine = must(frame->read_radiance());
  REQUIRE(screen.width == 48);
  REQUIRE(screen.height == 27);
  RadianceImage mean{48, 27, {}};
  for (std::size_t y = 0; y < 27; ++y) {
    for (std::size_t x = 0; x < 48; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = [&](std::size_t i, std::size_t j) { return fine.rgb[((2 * y + j) * 96 + 2 * x + i) * 3 + c]; };
        mean.rgb.push_back((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4);
      }
    }
  }
  const ScreenImage expected = screen_of(mean, 4.6);
  int worst = 0;
  for (std::size_t i = 0; i < expected.rgba.size(); ++i) {
    worst = std::max(worst, std::abs(int{screen.rgba[i]} - int{expected.rgba[i]}));
  }
  CHECK(worst <= 1);

  settings.width = 97;
  const auto odd = Frame::create(vulkan.device(), scene.rig, scene.compiled, settings);
  REQUIRE(!odd);
  CHECK(odd.error().code == ErrorCode::kBadInput);
}

TEST_CASE("rounding to 8 bits has no mean error over 16 x 16 pixels, and does not change whole steps") {
  const auto shown = [](float value, std::uint32_t x, std::uint32_t y) {
    return std::lround(static_cast<double>(f32::dithered(glm::vec3(value), x, y).g) * 255);
  };
  double worst = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double value = 40 + i / 1000.0;  // steps
    double sum = 0;
    for (std::uint32_t at = 0; at < 256; ++at)
      sum += static_cast<double>(shown(float(value / 255), 700 + at % 16, 300 + at / 16));
    worst = std::max(worst, std::abs(sum / 256 - value));
  }
  std::fprintf(stderr, "dither: the mean of 256 pixels is off by %.3g steps at most\n", worst);
  CHECK(worst < 0.03);
  for (std::uint32_t x = 0; x < 300; ++x) {
    for (const int step : {0, 1, 100, 255}) CHECK(shown(static_cast<float>(step) / 255.0f, x, x * x) == step);
  }
}

}  // namespace
}  // namespace footlight::render
