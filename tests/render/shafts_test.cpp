// Shafts of sunlight behind panes: pictures against the judge, which traces paths to the glass, and what must hold of
// them anywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "fixtures/simulate/walker.h"
#include "render/beam.h"
#include "render/frame.h"
#include "render/reference/judge.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 80, kHeight = 45;

// Coloured fields with dark lines between them.
std::shared_ptr<const fixtures::PaneImage> picture(int width, int height) {
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{width, height, {}});
  Random random(7);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool line = x % 7 == 0 || y % 6 == 0;
      Random field(static_cast<std::uint64_t>(x / 7 + 100 * (y / 6)) + 3);
      const glm::vec3 color(field.between(0, 1), field.between(0, 1), field.between(0, 1));
      image->texels.push_back(line ? glm::vec3(0.01f) : color * static_cast<float>(random.between(0.8, 1)));
    }
  }
  return image;
}

// A pane 2 m wide and 3 m high in the plane y = 4, through which the sun shines down and towards the camera; no
// fixtures. boxes: text of the rig file.
const std::string kHaze = "scattering_per_m = 0.03\nabsorption_per_m = 0.005";
Scene pane_scene(const std::string& boxes, const std::string& haze = kHaze,
                 const std::string& direction = "[0.35, -0.8, -0.55]") {
  Scene scene;
  scene.rig = must(fixtures::parse_rig("[rig]\nname = \"Shafts\"\nambient_lx = 0\n[haze]\nreach_m = 40\n" + haze +
                                           "\n[sun]\ndirection = " + direction +
                                           "\n[[pane]]\nname = \"Pane\"\nposition = [0, 4, 3]\nwidth_m = 2\n"
                                           "height_m = 3\ncolor = [0.9, 0.8, 0.7]\n" +
                                           boxes +
                                           "\n[[camera]]\nname = \"main\"\nposition = [-5, -5, 1.7]\n"
                                           "target = [0, 2, 2]\nfov_deg = 60\n",
                                       "shafts.toml"));
  scene.compile();
  return scene;
}
// One in the shaft, one that reaches through the plane of the pane, one before the pane, which hides nothing, and one
// that lies in the shadow of the first.
const std::string kThings =
    "[[box]]\nname = \"A\"\nmin = [0.2, 1.6, 1.5]\nmax = [0.9, 2, 2.4]\nalbedo = [0.3, 0.3, 0.3]\n"
    "[[box]]\nname = \"B\"\nmin = [-1.5, 3.6, 3]\nmax = [-0.4, 4.5, 3.4]\nalbedo = [0.3, 0.3, 0.3]\n"
    "[[box]]\nname = \"C\"\nmin = [-1, 4.2, 4]\nmax = [1, 5, 4.4]\nalbedo = [0.3, 0.3, 0.3]\n"
    "[[box]]\nname = \"D\"\nmin = [0.7, 0.9, 0.6]\nmax = [1.2, 1.2, 1]\nalbedo = [0.3, 0.3, 0.3]\n";

// Three beside the first one, of which one is turned in its plane, and one in another plane.
const std::string kMorePanes =
    "[[pane]]\nposition = [2, 4, 3]\nwidth_m = 0.7\nheight_m = 2\ncolor = [0.2, 0.9, 0.4]\n"
    "[[pane]]\nposition = [-2, 4, 3.5]\nrotation = [0, 25, 0]\nwidth_m = 0.7\nheight_m = 1\n"
    "[[pane]]\nposition = [3, 4, 3]\nwidth_m = 0.7\nheight_m = 2\ncolor = [0.5, 0.5, 0.9]\n"
    "[[pane]]\nposition = [-3, 2, 3]\nrotation = [0, 0, 60]\nwidth_m = 0.8\nheight_m = 2\ncolor = [0.9, 0.4, 0.4]\n";
// Two that touch each other and the glass, on the side where the light goes.
const std::string kFlush =
    "[[box]]\nname = \"A\"\nmin = [-0.6, 3.8, 2]\nmax = [-0.1, 4, 4]\nalbedo = [0.3, 0.3, 0.3]\n"
    "[[box]]\nname = \"B\"\nmin = [-0.1, 3.8, 2]\nmax = [0.4, 4, 4]\nalbedo = [0.3, 0.3, 0.3]\n";
// One a millimetre before and one as much behind the plane of the first pane.
const std::string kNearPanes =
    "[[pane]]\nposition = [2, 4.001, 3]\nwidth_m = 0.7\nheight_m = 2\ncolor = [0.2, 0.9, 0.4]\n"
    "[[pane]]\nposition = [-2, 3.999, 3]\nwidth_m = 0.7\nheight_m = 2\ncolor = [0.9, 0.2, 0.4]\n";

RadianceImage drawn(vk::Device& device, const Scene& scene, bool judged = true) {
  return drawn_light(device, scene, kWidth, kHeight, judged);
}
RadianceImage drawn_by_tables(vk::Device& device, const Scene& scene, bool judged = true) {
  const auto tables = [](FrameSettings& settings) { settings.tile_error = FrameSettings{}.tile_error; };
  return drawn_light(device, scene, kWidth, kHeight, judged, tables);
}
std::vector<double> judged(const Scene& scene) { return judged_light(scene, kWidth, kHeight); }

TEST_CASE("shafts in the air and on surfaces are near the judge, with and without images and shadows") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    bool image;
    std::string boxes;
    double most;
    std::function<void(Scene&)> change = [](Scene&) {};
  };
  const auto looks = [](glm::dvec3 from, glm::dvec3 to) { return [=](Scene& scene) { view_from(scene, from, to); }; };
  for (const Case& c :
       {Case{"even, air", false, "", 1e-4}, Case{"even, floor", false, kFloor, 1e-3},
        Case{"image, air", true, "", 1e-3}, Case{"image, floor", true, kFloor, 1e-3},
        Case{"even, shadows", false, kFloor + kThings, 1e-3}, Case{"image, shadows", true, kFloor + kThings, 1e-3},
        Case{"image, shadows, air alone", true, kThings, 1e-3},
        Case{"image, in the shaft", true, kFloor + kThings, 1e-3, looks({0.4, 1.2, 1.1}, {0, 4, 3})},
        Case{"image, along the light", true, kFloor, 1e-3,
             looks(glm::dvec3(0, 4, 3) + 6.0 * glm::normalize(glm::dvec3(0.35, -0.8, -0.55)), {0, 4, 3})},
        Case{"image, from behind the pane", true, kFloor + kThings, 1e-3, looks({2, 9, 5}, {0, 2, 1})},
        Case{"image, with the sky", true, kFloor, 1e-3, [](Scene& scene) { scene.rig.sun.sky_lx = 3000; }},
        Case{"image, more panes in its plane and in another", true, kFloor + kThings + kMorePanes, 1e-3},
        Case{"image, boxes that touch the glass", true, kFloor + kFlush, 1e-3},
        Case{"image, more panes within millimetres of its plane", true, kFloor + kNearPanes, 1e-3},
        Case{"image, tilted, dense haze", true, kFloor + kThings, 1e-3, [](Scene& scene) {
               scene.rig.haze.scattering_per_m = 1;
               scene.rig.haze.absorption_per_m = 0.5;
               scene.rig.panes[0].rotation_deg = {20, 30, 40};
             }}}) {
    CAPTURE(std::string(c.what));
    Scene scene = pane_scene(c.boxes);
    if (c.image) scene.rig.panes[0].image = picture(36, 48);
    c.change(scene);
    scene.compile();
    const std::vector<double> judge = judged(scene);
    const double error = rel_l2(drawn(vulkan.device(), scene), judge);
    print_error(c.what, error);
    CHECK(error < c.most);
    // By tables; images may be farther off.
    const double tables = rel_l2(drawn_by_tables(vulkan.device(), scene), judge);
    print_error((std::string(c.what) + ", tables").c_str(), tables);
    CHECK(tables < (c.image ? 5e-3 : 1e-3));
  }
}

TEST_CASE("shafts in clouds of haze are near the judge") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene("", "scattering_per_m = 0.03\nnoise = 0.8\nsize_m = 3\nseed = 4");
  scene.rig.panes[0].image = picture(36, 48);
  scene.compile();
  const double error = rel_l2(drawn(vulkan.device(), scene), judged(scene));
  print_error("image, clouds", error);
  CHECK(error < 2e-2);
}

// The pixel that shows a place.
std::size_t pixel_of(const Scene& scene, const glm::dvec3& place_m) {
  const View view = view_of(scene.rig.cameras[0]);
  const glm::dvec3 away = place_m - view.position_m;
  const double scale = glm::dot(away, view.forward) * view.tan_half_fov;
  const int x = static_cast<int>(kWidth / 2.0 + glm::dot(away, view.right) / scale * kHeight / 2.0);
  const int y = static_cast<int>(kHeight / 2.0 - glm::dot(away, view.up) / scale * kHeight / 2.0);
  REQUIRE(x >= 0);
  REQUIRE(x < kWidth);
  REQUIRE(y >= 0);
  REQUIRE(y < kHeight);
  return 3 * static_cast<std::size_t>(y * kWidth + x);
}

TEST_CASE("the image of a pane stands upright as it is seen from the audience, and falls on the floor from there") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene(kFloor, "scattering_per_m = 0", "[0, -1, -1]");
  scene.rig.sun.sky_lx = 1000;
  scene.rig.panes[0].color = glm::dvec3(1);
  // From the top left: red, green, blue, white.
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{2, 2, {}});
  image->texels = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  scene.rig.panes[0].image = image;
  view_from(scene, {0, -4, 6}, {0, 2, 1});
  scene.rig.cameras[0].fov_deg = 90;
  scene.compile();
  const RadianceImage shown = drawn(vulkan.device(), scene);
  const auto at = [&](glm::dvec3 place_m) {
    const std::size_t pixel = pixel_of(scene, place_m);
    return glm::vec3(shown.rgb[pixel], shown.rgb[pixel + 1], shown.rgb[pixel + 2]);
  };
  const auto is_mostly = [](glm::vec3 color, int channel) {
    return color[channel] > 3 * color[(channel + 1) % 3] && color[channel] > 3 * color[(channel + 2) % 3];
  };
  // On the pane, and where the light of the same place meets the floor: as far towards the audience as it is high.
  CHECK(is_mostly(at({-0.7, 4, 4}), 0));
  CHECK(is_mostly(at({-0.7, 0, 0}), 0));
  CHECK(is_mostly(at({0.7, 4, 4}), 1));
  CHECK(is_mostly(at({0.7, 0, 0}), 1));
  CHECK(is_mostly(at({-0.7, 4, 2}), 2));
  CHECK(is_mostly(at({-0.7, 2, 0}), 2));
  CHECK(at({0.7, 4, 2}).r > 0.8f * at({0.7, 4, 2}).b);
  CHECK(at({0.7, 2, 0}).r > 0.8f * at({0.7, 2, 0}).b);
}

TEST_CASE("scenery in a shaft is lit and throws a shadow") {
  HeadlessVulkan vulkan;
  const std::string riser =
      "[[scenery]]\nkind = \"riser\"\nposition = [0, 1, 0]\nwidth_m = 1\ndepth_m = 1\nheight_m = 1\n";
  const auto shown = [&](const std::string& boxes, glm::dvec3 place_m) {
    Scene scene = pane_scene(boxes, "scattering_per_m = 0", "[0, -1, -1]");
    view_from(scene, {0, -6, 5}, {0, 1, 0});
    scene.compile();
    FrameSettings settings = judged_settings(kWidth, kHeight);
    settings.bodies = true;
    auto frame = make_frame(vulkan.device(), scene, settings);
    frame->step(scene.levels, 0);
    must(frame->draw(view_of(scene.rig.cameras[0]), 0));
    return must(frame->read_radiance()).rgb[pixel_of(scene, place_m)];
  };
  const glm::dvec3 behind{0, 0.1, 0};  // in the light that goes through the riser
  CHECK(shown(kFloor, behind) > 1);
  CHECK(shown(kFloor + riser, behind) == 0);
  CHECK(shown(kFloor + riser, {0, 1, 1}) > 1);
}

TEST_CASE("no pane gives a picture that is not finite, and only a sun in its plane leaves it dark") {
  HeadlessVulkan vulkan;
  struct Case {
    const char* what;
    std::string direction;
    std::function<void(Scene&)> change;
    bool dark = false;
    double most = 5e-3;  // of tables against cells
  };
  const std::string usual = "[0.35, -0.8, -0.55]";
  for (const Case& c :
       {Case{"the sun in the plane of the pane", "[1, 0, 0]", [](Scene&) {}, true},
        Case{"the sun nearly in the plane of the pane", "[1, -0.0002, -0.2]", [](Scene&) {}, false, 2e-2},
        Case{"the sun at the horizon", "[0, -1, 0]", [](Scene&) {}},
        Case{"the sun below the horizon", "[0, -1, 0.2]", [](Scene&) {}},
        Case{"the sun from the other side", "[0, 1, -0.4]", [&](Scene& s) { view_from(s, {4, 9, 2}, {0, 6, 2}); }},
        Case{"a shaft seen edge on", "[0, -1, -1]", [&](Scene& s) { view_from(s, {1, -5, 1}, {1, 2, 1.5}); }},
        Case{"a ray along the light", "[0, -1, 0]", [&](Scene& s) { view_from(s, {0, -3, 3}, {0, 4, 3}); }},
        Case{"the eye in the shaft", usual, [&](Scene& s) { view_from(s, {0.5, 2.8, 2.2}, {0, 4, 3}); }},
        Case{"the eye in the pane", usual, [&](Scene& s) { view_from(s, {0, 4, 3}, {0.2, 3, 2}); }},
        Case{"a plane far away", usual,
             [&](Scene& s) {
               s.rig.haze.reach_m = 10000;
               s.rig.boxes[0].min_m = {-9999, -9999, -1};
               s.rig.boxes[0].max_m = {9999, 9999, 0};
               view_from(s, {-900, -900, 40}, {0, 0, 3});
               s.rig.cameras[0].fov_deg = 2;
             }},
        Case{"a single texel", usual,
             [](Scene& s) { s.rig.panes[0].image = std::make_shared<fixtures::PaneImage>(); }},
        Case{"an image of one column", usual, [](Scene& s) { s.rig.panes[0].image = picture(1, 300); }},
        Case{"a huge image", usual, [](Scene& s) { s.rig.panes[0].image = picture(2048, 1024); }},
        Case{"haze that lets nothing through", usual,
             [&](Scene& s) {
               s.rig.haze.scattering_per_m = 10;
               s.rig.haze.absorption_per_m = 10;
               view_from(s, {0.5, 2.8, 2.2}, {0, 4, 3});
             }},
        Case{"decks that touch in the shaft", usual,
             [](Scene& s) {
               for (int i = 0; i < 12; ++i) {
                 const glm::dvec3 low(-1.1 + 0.17 * i, 2.3, 1.3);
                 s.rig.boxes.push_back({"deck", low, low + glm::dvec3(0.17, 0.7, 0.6), glm::dvec3(0.3)});
               }
             }},
        Case{"more boxes than a tile lists", usual,
             [](Scene& s) {
               for (int i = 0; i < 90; ++i) {
                 const glm::dvec3 low(-0.8 + 0.2 * (i % 9), 2.3, 1.2 + 0.2 * (i / 9));
                 s.rig.boxes.push_back({"box", low, low + glm::dvec3(0.05), glm::dvec3(0.3)});
               }
             }},
        Case{"no haze", usual, [](Scene& s) { s.rig.haze.scattering_per_m = 0; }}}) {
    CAPTURE(std::string(c.what));
    Scene scene = pane_scene(kFloor + kThings, "scattering_per_m = 0.03", c.direction);
    scene.rig.panes[0].image = picture(16, 16);
    c.change(scene);
    scene.compile();
    vk::Device& device = vulkan.device();
    const RadianceImage exact = drawn(device, scene), tables = drawn_by_tables(device, scene);
    for (const RadianceImage& image :
         {exact, tables, drawn(device, scene, false), drawn_by_tables(device, scene, false)}) {
      CHECK(std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
      CHECK((sum_of(image) > 0) == !c.dark);
    }
    if (c.dark) continue;
    const double error = rel_l2(tables, {exact.rgb.begin(), exact.rgb.end()});
    print_error(c.what, error);
    CHECK(error < c.most);
  }
}

TEST_CASE("levels of detail keep the light of a fine image") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene(kFloor);
  scene.rig.panes[0].image = picture(700, 900);
  scene.compile();
  const RadianceImage whole = drawn(vulkan.device(), scene, true);
  const RadianceImage pixels = drawn(vulkan.device(), scene, false);
  CHECK(sum_of(pixels) == doctest::Approx(sum_of(whole)).epsilon(0.02));
  const RadianceImage tables = drawn_by_tables(vulkan.device(), scene, false);
  CHECK(sum_of(tables) == doctest::Approx(sum_of(whole)).epsilon(0.02));
}

TEST_CASE("the steps of a pixel are the cells that its ray goes through, without a largest number") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene("", kHaze, "[0, -1, -1]");
  view_from(scene, {-6, 1, 1.5}, {0, 1, 1.5});  // across the light: a line through the image from its left to its right
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.view = FrameView::kSteps;
  for (const int columns : {1, 10, 1000}) {
    scene.rig.panes[0].image = picture(columns, 1);
    scene.compile();
    auto frame = make_frame(vulkan.device(), scene, settings);
    frame->step(scene.levels, 0);
    must(frame->draw(view_of(scene.rig.cameras[0]), 0));
    const float steps = must(frame->read_radiance()).rgb[pixel_of(scene, {0, 1.02, 1.52})];
    CHECK(steps >= static_cast<float>(columns + 1));
    CHECK(steps <= static_cast<float>(columns + 3));
  }
}

TEST_CASE("panes out of sight change no bit of the picture, and the last of many is drawn") {
  HeadlessVulkan vulkan;
  const auto pane = [](double x, double y, const std::string& color) {
    return "[[pane]]\nposition = [" + std::to_string(x) + ", " + std::to_string(y) +
           ", 2.5]\nwidth_m = 0.8\nheight_m = 2\ncolor = " + color + "\n";
  };
  std::string unseen;  // behind the camera, with their shafts
  for (int i = 0; i < 69; ++i) unseen += pane(i - 35, -40, "[1, 1, 1]");
  const std::string last = pane(2.5, 4, "[0.2, 0.9, 0.4]");
  const RadianceImage both = drawn(vulkan.device(), pane_scene(last + kFloor));
  CHECK(drawn(vulkan.device(), pane_scene(unseen + last + kFloor)).rgb == both.rgb);
  CHECK(drawn_by_tables(vulkan.device(), pane_scene(unseen + last + kFloor)).rgb ==
        drawn_by_tables(vulkan.device(), pane_scene(last + kFloor)).rgb);
  CHECK(drawn(vulkan.device(), pane_scene(kFloor)).rgb != both.rgb);
}

TEST_CASE("a camera that moves gets the shafts of where it is, to the bit, and so does one that comes back") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene(kThings);
  scene.rig.panes[0].image = picture(36, 48);
  scene.compile();
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.tile_error = FrameSettings{}.tile_error;
  const View here = view_of(scene.rig.cameras[0]);
  View there = here;
  there.position_m.x += 1e-3;
  const auto shown = [&](Frame& frame, const View& view) {
    must(frame.draw(view, 0));
    return must(frame.read_radiance()).rgb;
  };
  auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 0);
  const auto first = shown(*frame, here);
  CHECK(shown(*frame, here) == first);
  auto other = make_frame(vulkan.device(), scene, settings);
  other->step(scene.levels, 0);
  const auto moved = shown(*other, there);
  CHECK(moved != first);
  CHECK(shown(*frame, there) == moved);
  CHECK(shown(*frame, here) == first);
}

TEST_CASE("a pane draws the same picture to the bit each time") {
  HeadlessVulkan vulkan;
  Scene scene = pane_scene(kFloor + kThings);
  scene.rig.panes[0].image = picture(36, 48);
  scene.compile();
  CHECK(drawn(vulkan.device(), scene, false).rgb == drawn(vulkan.device(), scene, false).rgb);
  CHECK(drawn_by_tables(vulkan.device(), scene).rgb == drawn_by_tables(vulkan.device(), scene).rgb);
}

TEST_CASE("the moments of light that is lost are those of their integrals") {
  for (const double loss : {0.0, 1e-6, 0.01, 0.3, 0.69, 0.71, 2.0, 30.0, 1e4}) {
    double sum[3] = {0, 0, 0};
    const int steps = 400'000;
    for (int i = 0; i < steps; ++i) {
      const double y = (i + 0.5) / steps, light = std::exp(-loss * y) / steps;
      sum[0] += light;
      sum[1] += light * y;
      sum[2] += light * y * y;
    }
    CAPTURE(loss);
    const glm::dvec3 exact = f64::shaft_moments(loss);
    const glm::vec3 single = f32::shaft_moments(static_cast<float>(loss));
    for (int i = 0; i < 3; ++i) {
      CHECK(exact[i] == doctest::Approx(sum[i]).epsilon(1e-3 / (i + 1) * (loss > 100 ? 1 : 1e-4)));
      CHECK(static_cast<double>(single[i]) == doctest::Approx(exact[i]).epsilon(4e-6));
    }
  }
}

TEST_CASE("a rig without a pane has no pass for shafts, and says so") {
  const fixtures::Needs needs = fixtures::compile(fixtures::demo_rig())->needs;
  CHECK(!needs.panes);
  const auto out = left_out_passes(needs, {});
  CHECK(std::any_of(out.begin(), out.end(), [](const LeftOutPass& pass) { return pass.name == "shafts"; }));
}

}  // namespace
}  // namespace footlight::render
