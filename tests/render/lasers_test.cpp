// Scanned lasers: pictures against brute force over the path of the scanner, and what must hold of them anywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>

#include "fixtures/laser/figure.h"
#include "fixtures/simulate/walker.h"
#include "render/frame.h"
#include "render/reference/laser_judge.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 96, kHeight = 54;

// Fixture 0 is a laser 3 m up that looks along +y, away from the camera. boxes: text of the rig file.
Scene laser_scene(const std::string& boxes,
                  const std::string& haze = "scattering_per_m = 0.02\nabsorption_per_m = 0.001") {
  Scene scene;
  scene.rig = must(fixtures::parse_rig("[rig]\nname = \"Lasers\"\nambient_lx = 0\n[haze]\nreach_m = 30\n" + haze +
                                           "\n[[fixture]]\nname = \"Laser\"\ntype = \"generic/laser\"\nuniverse = 1\n"
                                           "address = 1\nposition = [0, 0, 3]\nrotation = [90, 0, 0]\n" +
                                           boxes +
                                           "\n[[camera]]\nname = \"main\"\nposition = [0.3, -9, 1.7]\n"
                                           "target = [0, 0, 3]\nfov_deg = 50\n",
                                       "lasers.toml"));
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  scene.set(0, "Dimmer", 1);
  return scene;
}
const std::string kWall = "[[box]]\nname = \"Wall\"\nmin = [-20, 8, -5]\nmax = [20, 9, 12]\nalbedo = [0.5, 0.4, 0.3]\n";

// Shows a figure by its number and its size, of the scanner's range.
void show(Scene& scene, int figure, double size_x, double size_y, int beams = 8) {
  scene.set(0, "LaserFigure", figure);
  scene.set(0, "LaserSizeX", size_x);
  scene.set(0, "LaserSizeY", size_y);
  scene.set(0, "LaserCount", beams);
}

FrameSettings laser_settings() {
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.widen_thin = true;
  settings.tile_error = FrameSettings{}.tile_error;  // strips
  return settings;
}

RadianceImage drawn(vk::Device& device, const Scene& scene, std::int64_t dt_ns = 0) {
  auto frame = make_frame(device, scene, laser_settings());
  frame->step(scene.levels, dt_ns);
  must(frame->draw(view_of(scene.camera), 0));
  return must(frame->read_radiance());
}

std::vector<double> judged(const Scene& scene, std::int64_t dt_ns = 0, double step_px = 0.3) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, dt_ns);
  JudgeScene judge;
  judge.haze = scene.rig.haze;
  judge.boxes = scene.rig.boxes;
  return judge_lasers(judge, must(judged_lasers(scene.rig, walker, light_range_m(scene.rig))), view_of(scene.camera),
                      kWidth, kHeight, step_px);
}

TEST_CASE("lasers in the air and on a wall are near brute force over the scanner's path") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    int figure;
    double size_x, size_y;
    int beams;
    bool wall;
    double most;
  };
  for (const Case& c :
       {Case{"a beam, air", 1, 1, 1, 1, false, 1.5e-3}, Case{"a beam, wall", 1, 1, 1, 1, true, 2.5e-3},
        Case{"a fan of 8, air", 3, 0.9, 1, 8, false, 1.5e-3}, Case{"a fan of 8, wall", 3, 0.9, 1, 8, true, 2.9e-3},
        Case{"a line, air", 2, 0.8, 1, 1, false, 2e-3}, Case{"a line, wall", 2, 0.8, 1, 1, true, 2.4e-3},
        Case{"a circle, wall", 4, 0.7, 0.5, 1, true, 2.5e-3}, Case{"a star, wall", 8, 0.7, 0.7, 1, true, 2.5e-3}}) {
    CAPTURE(std::string(c.what));
    Scene scene = laser_scene(c.wall ? kWall : "");
    show(scene, c.figure, c.size_x, c.size_y, c.beams);
    const double error = rel_l2(drawn(vulkan.device(), scene), judged(scene));
    print_error(c.what, error);
    CHECK(error < c.most);
  }
}

// No pixel is near the place where a beam goes to: the closed form alone draws the air.
TEST_CASE("lasers that are seen from the side are near brute force") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    int figure;
    double size;
    double most;
  };
  for (const Case& c : {Case{"a beam from the side", 1, 1, 1e-3}, Case{"a line from the side", 2, 0.3, 1e-3}}) {
    CAPTURE(std::string(c.what));
    Scene scene = laser_scene("");
    show(scene, c.figure, c.size, c.size);
    scene.camera.position_m = {9, 5, 1.7};
    scene.camera.target_m = {0, 5, 3};
    const double error = rel_l2(drawn(vulkan.device(), scene), judged(scene));
    print_error(c.what, error);
    CHECK(error < c.most);
  }
}

TEST_CASE("a beam of a laser that comes towards the camera is near brute force") {
  HeadlessVulkan vulkan;
  Scene scene = laser_scene("", "scattering_per_m = 0.02\nabsorption_per_m = 0.001");
  scene.rig.haze.reach_m = 11;
  show(scene, 1, 1, 1);
  fixtures::Camera& camera = scene.camera;
  camera.position_m = {0.02, 12, 3.01};
  camera.target_m = {0, 0, 3};
  const double error = rel_l2(drawn(vulkan.device(), scene), judged(scene));
  print_error("a beam towards the camera", error);
  CHECK(error < 2e-3);
}

TEST_CASE("an exposure of a part of a pass of a laser shows that part, with all of the light") {
  HeadlessVulkan vulkan;
  Scene scene = laser_scene(kWall);
  show(scene, 4, 0.7, 0.5);
  // 96 points at 30,000 a second take 3.2 ms.
  for (const std::int64_t dt_ns : {std::int64_t{1'600'000}, std::int64_t{3'000'000}}) {
    CAPTURE(dt_ns);
    const RadianceImage part = drawn(vulkan.device(), scene, dt_ns);
    CHECK(rel_l2(part, judged(scene, dt_ns)) < 4e-3);
    const RadianceImage whole = drawn(vulkan.device(), scene, 20'000'000);
    CHECK(sum_of(part) == doctest::Approx(sum_of(whole)).epsilon(0.06));
    CHECK(rel_l2(whole, judged(scene, dt_ns)) > 0.05);
  }
}

TEST_CASE("a laser whose scanner stands still draws a dot, and one for which no time has gone by its figure") {
  HeadlessVulkan vulkan;
  Scene scene = laser_scene(kWall);
  show(scene, 2, 0.8, 1);
  const RadianceImage figure = drawn(vulkan.device(), scene);
  scene.set(0, "LaserScan", 0);
  const RadianceImage dot = drawn(vulkan.device(), scene, 20'000'000);
  CHECK(rel_l2(dot, judged(scene, 20'000'000)) < 2.9e-3);
  const auto brightest = [](const RadianceImage& image) {
    return static_cast<double>(*std::max_element(image.rgb.begin(), image.rgb.end()));
  };
  CHECK(brightest(dot) > 3 * brightest(figure));
}

TEST_CASE("a laser draws the same picture to the bit each time") {
  HeadlessVulkan vulkan;
  Scene scene = laser_scene(kWall);
  show(scene, 6, 0.7, 0.5, 3);
  const auto run = [&] {
    auto frame = make_frame(vulkan.device(), scene, laser_settings());
    for (int i = 0; i < 3; ++i) {
      frame->step(scene.levels, 17'000'000);
      must(frame->draw(view_of(scene.camera), 0));
    }
    return must(frame->read_radiance()).rgb;
  };
  CHECK(run() == run());
}

TEST_CASE("what stands in a sheet of laser light hides what is behind it, in the air and on the wall") {
  HeadlessVulkan vulkan;
  // It hides the right half of the line.
  const std::string screen = "[[box]]\nname = \"Screen\"\nmin = [0, 3, 0]\nmax = [8, 3.1, 8]\nalbedo = [0, 0, 0]\n";
  Scene open = laser_scene(kWall);
  show(open, 2, 0.8, 1);
  Scene hidden = laser_scene(kWall + screen);
  show(hidden, 2, 0.8, 1);
  // From behind the screen, so that it hides nothing of the picture.
  for (Scene* scene : {&open, &hidden}) {
    scene->camera.position_m = {0.3, 4, 5.5};
    scene->camera.target_m = {0, 8, 3};
    scene->camera.fov_deg = 70;
  }
  const RadianceImage before = drawn(vulkan.device(), open);
  const RadianceImage after = drawn(vulkan.device(), hidden);
  double left[2] = {0, 0}, right[2] = {0, 0};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t at = 3 * static_cast<std::size_t>(y * kWidth + x) + 1;
      (x < kWidth / 2 - 4 ? left : right)[0] += x > kWidth / 2 + 4 || x < kWidth / 2 - 4 ? before.rgb[at] : 0;
      (x < kWidth / 2 - 4 ? left : right)[1] += x > kWidth / 2 + 4 || x < kWidth / 2 - 4 ? after.rgb[at] : 0;
    }
  }
  CHECK(left[0] > 0);
  CHECK(left[1] == doctest::Approx(left[0]).epsilon(0.01));
  CHECK(right[1] < 0.02 * right[0]);
}

TEST_CASE("no laser gives a picture that is not finite") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    std::function<void(Scene&)> change;
    bool dark = false;
  };
  const auto look = [](Scene& scene, glm::dvec3 from, glm::dvec3 to) {
    scene.camera.position_m = from;
    scene.camera.target_m = to;
  };
  for (const Case& c : {Case{"camera in the sheet",
                             [&](Scene& s) {
                               show(s, 2, 1, 1);
                               look(s, {0, 9, 3 - 0.0}, {0, 0, 3});
                             }},
                        Case{"camera in the beam",
                             [&](Scene& s) {
                               show(s, 1, 1, 1);
                               look(s, {0, 5, 3}, {0, 0, 3});
                             }},
                        Case{"camera at the lens",
                             [&](Scene& s) {
                               show(s, 4, 1, 1);
                               look(s, {0, 0.17, 3}, {0, 5, 3});
                             }},
                        Case{"no size", [&](Scene& s) { show(s, 8, 0, 0); }},
                        Case{"mirrored and beyond the range",
                             [&](Scene& s) {
                               show(s, 4, 1, 1);
                               s.set(0, "LaserX", 1);
                             }},
                        Case{"far away",
                             [&](Scene& s) {
                               show(s, 4, 0.5, 0.5);
                               look(s, {0, -1000, 3}, {0, 0, 3});
                               s.camera.fov_deg = 1;
                             }},
                        Case{"no divergence, seen along itself",
                             [&](Scene& s) {
                               s.rig.types[0].lasers[0].divergence_mrad = 0;
                               s.rig.types[0].lasers[0].diameter_m = 0;
                               s.compile();
                               s.set(0, "Dimmer", 1);
                               show(s, 1, 1, 1);
                               look(s, {0, 7, 3}, {0, 0, 3});
                             }},
                        Case{"a range of 180 degrees",
                             [&](Scene& s) {
                               s.rig.types[0].lasers[0].scan_pan_deg = 180;
                               s.compile();
                               s.set(0, "Dimmer", 1);
                               show(s, 2, 1, 1);
                             }},
                        Case{"the lens on a face of a box",
                             [&](Scene& s) {
                               s.rig.boxes.push_back({"Behind", {-1, -1, 1}, {1, 0.165, 5}, glm::dvec3(0.3)});
                               s.compile();
                               s.set(0, "Dimmer", 1);
                               show(s, 2, 1, 1);
                             }},
                        Case{"the lens in a box",
                             [&](Scene& s) {
                               s.rig.boxes.push_back({"Around", {-0.5, -0.5, 2.5}, {0.5, 0.5, 3.5}, glm::dvec3(0.3)});
                               s.compile();
                               s.set(0, "Dimmer", 1);
                               show(s, 2, 1, 1);
                             },
                             true}}) {
    CAPTURE(std::string(c.what));
    Scene scene = laser_scene(kWall);
    c.change(scene);
    const RadianceImage image = drawn(vulkan.device(), scene, 5'000'000);
    CHECK(std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
    CHECK((sum_of(image) > 0) == !c.dark);
  }
}

TEST_CASE("a thin line of a laser on a wall keeps its light at any distance of the camera") {
  HeadlessVulkan vulkan;
  double first = 0;
  for (const double away_m : {6.0, 30.0, 150.0}) {
    Scene scene = laser_scene(kWall, "scattering_per_m = 0");
    show(scene, 3, 0.3, 1, 5);
    scene.camera.position_m = {0, 8 - away_m, 3};
    scene.camera.target_m = {0, 8, 3};
    // Light towards the eye falls with the square of the distance; the pictures are of one size.
    scene.camera.fov_deg = 2 * std::atan(4 / away_m) * 180 / std::numbers::pi;
    const double sum = sum_of(drawn(vulkan.device(), scene));
    if (first == 0) first = sum;
    CHECK(sum == doctest::Approx(first).epsilon(0.02));
  }
}

// The relative L2 difference of a picture by strips from one of which each pixel is computed by the closed form.
double strip_error(vk::Device& device, const Scene& scene, int width, int height) {
  RadianceImage images[2];
  for (const bool strips : {false, true}) {
    FrameSettings settings = laser_settings();
    settings.width = width;
    settings.height = height;
    if (!strips) settings.tile_error = 0;
    auto frame = make_frame(device, scene, settings);
    frame->step(scene.levels, 0);
    must(frame->draw(view_of(scene.camera), 0));
    images[strips ? 1 : 0] = must(frame->read_radiance());
  }
  return rel_l2(images[1], std::vector<double>(images[0].rgb.begin(), images[0].rgb.end()));
}

TEST_CASE("the light of lasers by strips is near that of each pixel, with and without a wall") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    int figure;
    double size;
    int beams;
  };
  for (const Case& c : {Case{"a fan of 20", 3, 0.9, 20}, Case{"a line", 2, 0.8, 1}, Case{"a star", 8, 0.7, 1}}) {
    for (const bool wall : {false, true}) {
      CAPTURE(std::string(c.what));
      CAPTURE(wall);
      Scene scene = laser_scene(wall ? kWall : "");
      show(scene, c.figure, c.size, c.size, c.beams);
      scene.camera.position_m = {6, -2, 1.7};
      const double error = strip_error(vulkan.device(), scene, 333, 187);
      print_error(c.what, error);
      CHECK(error < 2e-4);
      CHECK(error > 0);  // not the same code
    }
  }
}

// A picture of one supertile has room for 64 strips.
TEST_CASE("rows of lasers for which there is no room are drawn tile by tile") {
  HeadlessVulkan vulkan;
  Scene scene = laser_scene("");
  show(scene, 3, 0.9, 0.9, 90);
  scene.camera.position_m = {6, -2, 1.7};
  const double error = strip_error(vulkan.device(), scene, 64, 64);
  print_error("a fan of 90 in one supertile", error);
  CHECK(error < 1e-3);
}

TEST_CASE("a rig without a laser has no pass for lasers, and says so") {
  const fixtures::Needs needs = fixtures::compile(fixtures::demo_rig())->needs;
  CHECK(!needs.laser);
  const auto out = left_out_passes(needs, {});
  CHECK(std::any_of(out.begin(), out.end(), [](const LeftOutPass& pass) { return pass.name == "lasers"; }));
}

}  // namespace
}  // namespace footlight::render
