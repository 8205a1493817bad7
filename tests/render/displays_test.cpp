// Displays: pictures against the judge, which integrates every pixel, and what must hold of them anywhere.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fixtures/simulate/walker.h"
#include "render/beam.h"
#include "render/display_tables.h"
#include "render/frame.h"
#include "render/reference/display_judge.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 32, kHeight = 18;

const std::string kHaze = "scattering_per_m = 0.03\nabsorption_per_m = 0.005\nanisotropy = 0.5";
const std::string kClear = "scattering_per_m = 0";
const std::string kRisers =
    "[[box]]\nname = \"A\"\nmin = [-1.5, 1, 0]\nmax = [-0.5, 2, 1.4]\nalbedo = [0.5, 0.5, 0.5]\n"
    "[[box]]\nname = \"B\"\nmin = [0.8, 2.2, 0]\nmax = [1.6, 3, 2.2]\nalbedo = [0.5, 0.5, 0.5]\n";

// A display of 3.2 x 1.8 m in the plane y = 4, seen from ahead and the left; no fixtures. more: of the display.
Scene display_scene(const std::string& haze, const std::string& boxes, const std::string& more = "") {
  Scene scene;
  scene.rig = must(fixtures::parse_rig("[rig]\nname = \"Displays\"\nambient_lx = 0\n[haze]\n" + haze +
                                           "\n[[display]]\nname = \"Wall\"\nposition = [0, 4, 1.9]\nwidth_m = 3.2\n"
                                           "height_m = 1.8\nnits = 800\n" +
                                           more + "\n" + boxes +
                                           "\n[[camera]]\nname = \"main\"\nposition = [-3, -4, 2]\n"
                                           "target = [0, 2.5, 1.2]\nfov_deg = 55\n",
                                       "displays.toml"));
  scene.compile();
  return scene;
}

// Coloured fields, dark lines and single bright pixels.
void give_picture(fixtures::Display& display, int columns, int rows) {
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{columns, rows, {}});
  Random random(5);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      Random field(static_cast<std::uint64_t>(x / 5 + 100 * (y / 4)) + 3);
      const glm::vec3 color(field.between(0, 1), field.between(0, 1), field.between(0, 1));
      const bool line = x % 5 == 0, bright = random.below(11) == 0;
      image->texels.push_back(bright ? glm::vec3(1) : line ? glm::vec3(0) : color);
    }
  }
  display.columns = columns;
  display.rows = rows;
  display.image = image;
}

RadianceImage drawn(
    vk::Device& device, const Scene& scene, bool judged = true,
    const std::function<void(FrameSettings&)>& change = [](FrameSettings&) {}) {
  return drawn_light(device, scene, kWidth, kHeight, judged, [&](FrameSettings& settings) {
    if (!judged) settings.tile_error = FrameSettings{}.tile_error;
    change(settings);
  });
}
std::vector<double> judged(const Scene& scene) { return judged_light(scene, kWidth, kHeight); }

// A case against the judge. Cameras that see no display judge its light alone, without its bright pixels.
struct Case {
  const char* what;
  double most;
  std::string haze;
  std::string boxes;
  std::function<void(Scene&)> change = [](Scene&) {};
};
void check_near_judge(vk::Device& device, const Case& c) {
  CAPTURE(std::string(c.what));
  Scene scene = display_scene(c.haze, c.boxes);
  c.change(scene);
  scene.compile();
  const std::vector<double> judge = judged(scene);
  for (const double tile_error : {0.0, FrameSettings{}.tile_error}) {
    const RadianceImage image = drawn(device, scene, true, [&](FrameSettings& s) { s.tile_error = tile_error; });
    const double error = rel_l2(image, judge);
    print_error(tile_error > 0 ? "  by records" : c.what, error);
    CHECK(error < c.most);
  }
}

const auto picture = [](Scene& scene) { give_picture(scene.rig.displays[0], 16, 9); };
// Away from the display: of what it lights nothing else is in the picture.
const auto away = [](Scene& scene) { view_from(scene, {1, 3.9, 2.5}, {-1, -2, 0}); };

TEST_CASE("light of displays on surfaces is near the judge") {
  HeadlessVulkan vulkan;
  for (const Case& c :
       {Case{"even, floor", 1e-3, kClear, kFloor, away}, Case{"even, floor and the display", 1e-3, kClear, kFloor},
        Case{"even, risers", 1e-3, kClear, kFloor + kRisers, away},
        Case{"even, horizon through it", 1e-3, kClear, kFloor + kRisers,
             [](Scene& s) {
               away(s);
               s.rig.displays[0].rotation_deg = {10, 20, 30};
             }},
        Case{"even, at its foot", 1e-3, kClear, kFloor,
             [](Scene& s) {
               s.rig.displays[0].position_m.z = 0.9;
               view_from(s, {-0.6, 2.6, 0.5}, {0, 3.95, 0});
             }},
        Case{"image, floor", 5e-3, kClear, kFloor, [](Scene& s) { picture(s), away(s); }},
        Case{"image, risers", 5e-3, kClear, kFloor + kRisers, [](Scene& s) { picture(s), away(s); }},
        Case{"image, at its foot", 5e-3, kClear, kFloor,
             [](Scene& s) {
               picture(s);
               s.rig.displays[0].position_m.z = 0.9;
               view_from(s, {-0.6, 3.99, 0.5}, {0.3, 3.7, 0});
             }},
        Case{"image, in what absorbs", 5e-3, "scattering_per_m = 0\nabsorption_per_m = 0.5", kFloor,
             [](Scene& s) { picture(s), away(s); }},
        Case{"strip of 50 pixels", 5e-3, kClear, kFloor,
             [](Scene& s) {
               away(s);
               s.rig.displays[0].height_m = 0.012;
               s.rig.displays[0].position_m.z = 0.3;
               give_picture(s.rig.displays[0], 50, 1);
             }},
        Case{"odd sizes: 17 x 5, two displays", 5e-3, kClear, kFloor, [](Scene& s) {
               away(s);
               give_picture(s.rig.displays[0], 17, 5);
               s.rig.displays.push_back(s.rig.displays[0]);
               s.rig.displays[1].position_m = {-4, 0, 1};
               s.rig.displays[1].rotation_deg = {0, 0, 90};
             }}}) {
    check_near_judge(vulkan.device(), c);
  }
}

TEST_CASE("light of displays in the air is near the judge") {
  HeadlessVulkan vulkan;
  const auto from_behind = [](Scene& s) { view_from(s, {3, 9, 3}, {0, 2, 1}); };
  const auto from_side = [](Scene& s) { view_from(s, {-6, 2.5, 2}, {0, 2.5, 1.5}); };
  const auto near = [](Scene& s) { view_from(s, {-1.8, 3.8, 1.6}, {1.5, 3.2, 2}); };
  int number = 0;
  for (const Case& c :
       {Case{"even, with the display", 1e-3, kHaze, ""}, Case{"even, from behind", 1e-3, kHaze, "", from_behind},
        Case{"even, from the side", 1e-3, kHaze, "", from_side}, Case{"even, along its face", 1e-3, kHaze, "", near},
        Case{"even, with a floor", 1e-3, kHaze, kFloor, from_side},
        Case{"image, with the display", 5e-3, kHaze, "", picture},
        Case{"image, from behind", 5e-3, kHaze, "", [&](Scene& s) { picture(s), from_behind(s); }},
        Case{"image, from the side", 5e-3, kHaze, kFloor, [&](Scene& s) { picture(s), from_side(s); }},
        Case{"image, along its face", 5e-3, kHaze, "", [&](Scene& s) { picture(s), near(s); }},
        Case{"image, strongly forward (g = 0.85)", 5e-3, "scattering_per_m = 0.03\nanisotropy = 0.85", kFloor,
             [&](Scene& s) { picture(s), from_behind(s); }},
        Case{"image, dense haze", 5e-3, "scattering_per_m = 0.8\nabsorption_per_m = 0.4", kFloor,
             [&](Scene& s) { picture(s), from_side(s); }},
        Case{"strip of 40 pixels", 5e-3, kHaze, "", [&](Scene& s) {
               from_side(s);
               s.rig.displays[0].height_m = 0.012;
               give_picture(s.rig.displays[0], 40, 1);
             }}}) {
    if (number++ % 5 != 0 && !footlight::testing::runs_long_tests()) continue;  // a case takes the judge half a minute
    check_near_judge(vulkan.device(), c);
  }
}

TEST_CASE("light of displays in clouds of haze is near the judge") {
  HeadlessVulkan vulkan;
  Scene scene = display_scene("scattering_per_m = 0.03\nnoise = 0.8\nsize_m = 3\nseed = 4", "");
  view_from(scene, {-6, 2.5, 2}, {0, 2.5, 1.5});
  scene.compile();
  const double error = rel_l2(drawn(vulkan.device(), scene), judged(scene));
  print_error("even, clouds", error);
  CHECK(error < 2e-2);
}

TEST_CASE(
    "light of displays in haze that thins with height is near the judge along rays that rise and leave its table") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = display_scene("scattering_per_m = 0.001\nheight_m = 2\nanisotropy = 0.5", "");
  fixtures::Display& display = scene.rig.displays[0];
  display.width_m = display.height_m = 1;
  display.position_m = {0, 4, 2};
  // Away from the wall, up to and beyond 45 degrees.
  view_from(scene, {0, -1, 2}, {0, -2, 3});
  scene.rig.cameras[0].fov_deg = 60;
  scene.compile();
  const double error = rel_l2(drawn_light(vulkan.device(), scene, 4, 4, true), judged_light(scene, 4, 4));
  print_error("even, haze that thins with height", error);
  CHECK(error < 2e-2);
}

TEST_CASE("light of displays in the air ends where the ray does, also just beyond where it counts as a point") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  // The eye is 2 m ahead of 1 x 1 m and looks away: it counts as a point beyond 81 m.
  const auto sum_to = [&](const std::string& box) {
    Scene scene = display_scene("scattering_per_m = 1e-6", box);
    fixtures::Display& display = scene.rig.displays[0];
    display.width_m = display.height_m = 1;
    display.color = {1, 1, 1};
    display.nits = 1e6;
    display.position_m = {0, 4, 2};
    view_from(scene, {0, 2, 2}, {0, -2, 2});
    scene.rig.cameras[0].fov_deg = 1;
    scene.compile();
    return sum_of(drawn_light(vulkan.device(), scene, 2, 2, true));
  };
  const auto wall_at = [](double y) {
    return "[[box]]\nname = \"Far\"\nmin = [-50, " + std::to_string(y - 1) + ", -50]\nmax = [50, " + std::to_string(y) +
           ", 50]\nalbedo = [0, 0, 0]\n";
  };
  const double near = sum_to(wall_at(2 - 80)), far = sum_to(wall_at(2 - 85)), none = sum_to("");
  // From t on, the square gives area / (4 pi t) on the axis; over 80 to 85 m that is 5 / 80 of what is beyond 80 m.
  CHECK((far - near) / (none - near) == doctest::Approx(1 - (80 + 2) / (85.0 + 2)).epsilon(0.1));
}

TEST_CASE("the judge of displays has the light of a point far away, and half of a plane nearby") {
  JudgeScene scene;
  scene.haze.scattering_per_m = 0;
  scene.displays.push_back({{0, 0, 0}, {0.1, 0, 0}, {0, 0, 0.1}, 2, 2, std::vector<glm::dvec3>(4, glm::dvec3(1000))});
  // 0.04 m^2 of 1000 cd/m^2 are 40 cd ahead, which is towards -y.
  CHECK(judge_display_lux(scene, {0, -20, 0}, {0, 1, 0}).r == doctest::Approx(40.0 / 400).epsilon(1e-4));
  CHECK(judge_display_lux(scene, {0, 20, 0}, {0, -1, 0}) == glm::dvec3(0));
  scene.displays[0].right_m = {1000, 0, 0};
  scene.displays[0].up_m = {0, 0, 1000};
  CHECK(judge_display_lux(scene, {3, -0.1, 0}, {0, 1, 0}).r == doctest::Approx(1000 * std::numbers::pi).epsilon(1e-6));
  // It ends 1 km away, which takes about 0.1 m of 1 km.
  CHECK(judge_display_lux(scene, {3, -0.1, 0}, {1, 0, 0}).r == doctest::Approx(500 * std::numbers::pi).epsilon(3e-4));
}

TEST_CASE("form factors and solid angles of rectangles are those of sums over their parts") {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double half_x = random.between(0.05, 2), half_y = random.between(0.05, 2);
    const glm::dvec3 from(random.between(-3, 3), random.between(-3, 3), -random.between(0.5, 3));
    const glm::dvec3 normal =
        glm::normalize(glm::dvec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)));
    double form = 0, angle = 0;
    const int parts = 200;
    for (int y = 0; y < parts; ++y) {
      for (int x = 0; x < parts; ++x) {
        const glm::dvec3 to =
            from + glm::dvec3(half_x * ((2.0 * x + 1) / parts - 1), half_y * ((2.0 * y + 1) / parts - 1), 0);
        const double square = glm::dot(to, to), area = 4 * half_x * half_y / (parts * parts);
        form += area * std::max(glm::dot(to, normal), 0.0) * -to.z / (square * square);
        angle += area * -to.z / (square * std::sqrt(square));
      }
    }
    CHECK(f64::display_form(from, half_x, half_y, normal) == doctest::Approx(form).epsilon(1e-3).scale(0.05));
    CHECK(f64::display_angle(from, half_x, half_y) == doctest::Approx(angle).epsilon(1e-3));
  }
}

TEST_CASE("levels of a pixel map give the same picture to the bit as an image of the same light") {
  HeadlessVulkan vulkan;
  for (const char* order : {"rgb", "grb", "rgbw"}) {
    Scene scene = display_scene(kHaze, kFloor,
                                "columns = 30\nrows = 17\nuniverse = 4\naddress = 20\nserpentine = true\n"
                                "start = \"bottom-right\"\norder = \"" +
                                    std::string(order) + "\"\n");
    Random random(9);
    for (std::uint8_t& level : scene.levels) level = static_cast<std::uint8_t>(random.below(256));
    const RadianceImage mapped = drawn(vulkan.device(), scene, false);
    fixtures::Display& display = scene.rig.displays[0];
    auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{30, 17, {}});
    for (int y = 0; y < 17; ++y) {
      for (int x = 0; x < 30; ++x) {
        const fixtures::PixelPlace place = fixtures::place_of_pixel(display, x, y);
        const std::uint8_t* slots =
            &scene.levels[static_cast<std::size_t>(place.universe * kSlotCountMax + place.slot)];
        glm::vec3 light(0);
        const auto share = [&](std::size_t emitter) {
          const int offset = display.map->offsets[emitter];
          return offset < 0 ? 0.0f : static_cast<float>(slots[offset]) / 255.0f;
        };
        for (std::size_t i = 0; i < 3; ++i) light[static_cast<int>(i)] = share(i) + share(3);
        image->texels.push_back(light);
      }
    }
    display.map.reset();
    display.image = image;
    scene.compile();
    const RadianceImage shown = drawn(vulkan.device(), scene, false);
    CHECK(sum_of(shown) > 0);
    CHECK(mapped.rgb == shown.rgb);
    CHECK(shown.rgb == drawn(vulkan.device(), scene, false).rgb);
  }
}

TEST_CASE("new levels change the picture of a frame, and old ones bring the old picture back") {
  HeadlessVulkan vulkan;
  Scene scene = display_scene(kClear, kFloor, "columns = 8\nrows = 4\nuniverse = 1\n");
  auto frame = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  const auto with = [&](std::uint8_t level) {
    std::fill(scene.levels.begin(), scene.levels.end(), level);
    frame->step(scene.levels, 0);
    must(frame->run_steps());
    must(frame->draw(view_of(scene.rig.cameras[0]), 0));
    return must(frame->read_radiance());
  };
  const RadianceImage full = with(255);
  CHECK(sum_of(with(0)) == 0);
  const double half = sum_of(with(51));
  CHECK(half == doctest::Approx(0.2 * sum_of(full)).epsilon(1e-4));
  CHECK(with(255).rgb == full.rgb);
  // Without a step the last levels stay.
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  CHECK(must(frame->read_radiance()).rgb == full.rgb);
}

TEST_CASE("no display gives a picture that is not finite") {
  HeadlessVulkan vulkan;
  struct Extreme {
    const char* what;
    std::function<void(Scene&)> change;
    bool dark = false;
  };
  for (const Extreme& c :
       {Extreme{"as it is", [](Scene&) {}},
        Extreme{"seen edge on",
                [](Scene& s) {
                  view_from(s, {-6, 4, 1.9}, {0, 4, 1.9});
                }},
        Extreme{"the eye nearly in its plane",
                [](Scene& s) {
                  view_from(s, {-6, 3.9999, 1.9}, {0, 4, 1.9});
                }},
        Extreme{"the eye on its face",
                [](Scene& s) {
                  view_from(s, {0.1, 4, 1.9}, {0, 2, 1.9});
                }},
        Extreme{"the eye a micrometre ahead of its face",
                [](Scene& s) {
                  view_from(s, {0.1, 3.999999, 1.9}, {1, 4, 1.9});
                }},
        Extreme{"the eye at its corner",
                [](Scene& s) {
                  view_from(s, {1.6, 4, 2.8}, {0, 0, 0});
                }},
        Extreme{"an image of one pixel",
                [](Scene& s) {
                  give_picture(s.rig.displays[0], 1, 1);
                  s.rig.displays[0].image = nullptr;
                }},
        Extreme{"a column of pixels", [](Scene& s) { give_picture(s.rig.displays[0], 1, 500); }},
        Extreme{"1 x 1 mm", [](Scene& s) { s.rig.displays[0].width_m = s.rig.displays[0].height_m = 0.001; }},
        Extreme{"1 km wide", [](Scene& s) { s.rig.displays[0].width_m = 1000; }},
        Extreme{"1 km long and 1 mm high",
                [](Scene& s) {
                  s.rig.displays[0].width_m = 1000;
                  s.rig.displays[0].height_m = 0.001;
                }},
        Extreme{"in the plane of the floor",
                [](Scene& s) {
                  s.rig.displays[0].position_m.z = 0;
                  s.rig.displays[0].rotation_deg = {-90, 0, 0};
                }},
        Extreme{"through the floor", [](Scene& s) { s.rig.displays[0].position_m.z = 0; }},
        Extreme{"9 km away",
                [](Scene& s) {
                  s.rig.haze.scattering_per_m = 0;
                  s.rig.displays[0].width_m = s.rig.displays[0].height_m = 30;
                  view_from(s, {0, -9000, 40}, {0, 0, 2});
                  s.rig.cameras[0].fov_deg = 1;
                }},
        Extreme{"haze that lets nothing through",
                [](Scene& s) {
                  s.rig.haze.scattering_per_m = 10;
                  s.rig.haze.absorption_per_m = 10;
                  s.rig.haze.anisotropy = 0.95;
                  view_from(s, {0, 3.8, 2}, {0, 2, 1});
                }},
        Extreme{"scattered back", [](Scene& s) { s.rig.haze.anisotropy = -0.95; }},
        Extreme{"no haze", [](Scene& s) { s.rig.haze.scattering_per_m = 0; }},
        Extreme{"a million nits", [](Scene& s) { s.rig.displays[0].nits = 1e6; }},
        Extreme{"black", [](Scene& s) { s.rig.displays[0].nits = 0; }, true}}) {
    CAPTURE(std::string(c.what));
    Scene scene = display_scene("scattering_per_m = 0.03", kFloor);
    c.change(scene);
    scene.compile();
    for (const bool judged_picture : {true, false}) {
      const RadianceImage image = drawn(vulkan.device(), scene, judged_picture);
      CHECK(std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
      CHECK((sum_of(image) > 0) == !c.dark);
    }
  }
}

TEST_CASE("a million pixels from 5,883 universes light the floor as one pixel of their mean, at about the same cost") {
  HeadlessVulkan vulkan;
  Scene many = display_scene(kClear, kFloor, "columns = 1000\nrows = 1000\nuniverse = 1\n");
  CHECK(many.compiled.universes.size() == 5883);
  Scene one = display_scene(kClear, kFloor, "columns = 1\nrows = 1\nuniverse = 1\n");
  for (Scene* scene : {&many, &one}) {
    away(*scene);
    std::fill(scene->levels.begin(), scene->levels.end(), std::uint8_t{128});
  }
  const RadianceImage fine = drawn(vulkan.device(), many), coarse = drawn(vulkan.device(), one);
  for (std::size_t i = 0; i < fine.rgb.size(); ++i) {
    CHECK(fine.rgb[i] == doctest::Approx(coarse.rgb[i]).epsilon(2e-3));
  }
}

TEST_CASE("pixels of a display that are finer than those of the picture keep their light") {
  HeadlessVulkan vulkan;
  // The light of all pixels of the picture, against the mean of the image times the area in which the display is seen.
  const auto light = [&](int finer, const std::function<void(Scene&)>& change, double most) {
    Scene scene = display_scene(kClear, "");
    give_picture(scene.rig.displays[0], 300, 200);
    change(scene);
    scene.compile();
    const double sum = sum_of(drawn(vulkan.device(), scene, false, [finer](FrameSettings& settings) {
      settings.width *= finer;
      settings.height *= finer;
    }));
    const fixtures::Display& display = scene.rig.displays[0];
    const View view = view_of(scene.rig.cameras[0]);
    std::array<glm::dvec2, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = i == 0 || i == 3 ? -0.5 : 0.5, z = i < 2 ? -0.5 : 0.5;
      const glm::dvec3 to =
          display.position_m + glm::dvec3(x * display.width_m, 0, z * display.height_m) - view.position_m;
      corners[i] = glm::dvec2(glm::dot(to, view.right), glm::dot(to, view.up)) *
                   (kHeight * finer / 2.0 / view.tan_half_fov / glm::dot(to, view.forward));
    }
    double area = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const glm::dvec2 from = corners[i], to = corners[(i + 1) % 4];
      area += 0.5 * (from.x * to.y - to.x * from.y);
    }
    double mean = 0;
    for (const glm::vec3& texel : display.image->texels) mean += static_cast<double>(texel.r + texel.g + texel.b);
    mean *= display.nits / static_cast<double>(display.image->texels.size());
    CHECK(sum == doctest::Approx(mean * std::abs(area)).epsilon(most));
  };
  // At its border a pixel is of the display or not, until the edges are smoothed: less of that in a larger picture.
  light(
      4, [](Scene&) {}, 0.03);
  // A display that is thinner than two pixels is drawn by the share of each that it covers.
  // Nearly edge on its pixels are twice as large at one end as at the other, within one pixel of the picture.
  light(
      1,
      [](Scene& s) {
        view_from(s, {-9, 3, 2}, {0, 4, 2});
      },
      0.15);
  const auto thin = [](Scene& s) {
    s.rig.displays[0].height_m = 0.02;
    give_picture(s.rig.displays[0], 100, 1);
  };
  light(1, thin, 0.05);
  light(4, thin, 0.05);
}

TEST_CASE("a rig of a strip alone is on the screen, not only in the radiance") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = display_scene(kClear, "");
  scene.rig.displays[0].height_m = 0.05;
  scene.compile();
  CHECK_FALSE(scene.compiled.needs.objects);
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.widen_thin = true;
  auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), 4));
  const ScreenImage screen = must(frame->read_screen());
  int lit = 0;
  for (std::size_t i = 0; i < screen.rgba.size(); i += 4) lit += screen.rgba[i] > 0;
  CHECK(lit > 0);
  CHECK(lit < kWidth * kHeight / 2);
}

TEST_CASE("a thin display with a case is as bright wherever it lies between pixels, also where edges are smooth") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  // 0.1 m high: it has a case. Some 0.5 pixels thick, and moved down by parts of a pixel.
  Scene scene = display_scene(kClear, "");
  scene.rig.displays[0].height_m = 0.1;
  view_from(scene, {0, -4, 1.9}, {0, 4, 1.9});
  scene.rig.cameras[0].fov_deg = 25;
  scene.compile();
  const double pixel_m = 2 * 8 * std::tan(glm::radians(12.5)) / kHeight;  // at its distance
  double least = 1e30, most = 0;
  for (const double shift : {0.0, 0.25, 0.5, 0.75}) {
    view_from(scene, {0, -4, 1.9 + shift * pixel_m}, {0, 4, 1.9 + shift * pixel_m});
    const double sum = sum_of(drawn(vulkan.device(), scene, false, [](FrameSettings& settings) {
      settings.bodies = true;
      settings.edge_samples = 16;
    }));
    least = std::min(least, sum);
    most = std::max(most, sum);
  }
  CHECK(0.1 / pixel_m == doctest::Approx(0.5).epsilon(0.02));
  CHECK(most / least < 1.02);
  // Three colours of 800 cd/m^2 from its area in the picture.
  CHECK(most == doctest::Approx(3 * 800 * 3.2 * 0.1 / (pixel_m * pixel_m)).epsilon(0.02));
}

TEST_CASE("levels of a wall are held once however many steps wait, and the newest are shown beside a fixture's") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = display_scene(kClear, "", "columns = 100\nrows = 100\nuniverse = 2\n");  // 59 universes
  const auto noted = [&](Frame& frame, int steps) {
    for (int i = 0; i < steps; ++i) {
      std::fill(scene.levels.begin(), scene.levels.end(), static_cast<std::uint8_t>(i));
      std::fill_n(scene.levels.begin(), kSlotCountMax, std::uint8_t{0});  // of the fixture, if there is one
      frame.step(scene.levels, 0);
    }
    return frame.pending_bytes();
  };
  const FrameSettings settings = judged_settings(kWidth, kHeight);
  auto alone = make_frame(vulkan.device(), scene, settings);
  CHECK(noted(*alone, 100) == scene.levels.size());
  CHECK(alone->pending_steps() == 100);
  const std::string fixture =
      "[[fixture]]\nname = \"A\"\ntype = \"generic/par\"\nuniverse = 1\naddress = 1\nposition = [0, 0, 5]\n";
  scene = display_scene(kClear, fixture, "columns = 100\nrows = 100\nuniverse = 2\n");
  REQUIRE(scene.compiled.universes.size() == 60);
  auto both = make_frame(vulkan.device(), scene, settings);
  CHECK(noted(*both, 100) == scene.levels.size() + 99 * kSlotCountMax);
  must(both->draw(view_of(scene.rig.cameras[0]), 0));
  CHECK(both->pending_bytes() == scene.levels.size());
  auto once = make_frame(vulkan.device(), scene, settings);
  once->step(scene.levels, 0);
  must(once->draw(view_of(scene.rig.cameras[0]), 0));
  const RadianceImage shown = must(both->read_radiance());
  CHECK(sum_of(shown) > 0);
  CHECK(shown.rgb == must(once->read_radiance()).rgb);
}

TEST_CASE("the image of a display stands upright as it is seen from the audience, and its back is dark") {
  HeadlessVulkan vulkan;
  Scene scene = display_scene(kClear, kFloor);
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{2, 2, {}});
  image->texels = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};  // from the top left: red, green, blue, white
  scene.rig.displays[0].columns = scene.rig.displays[0].rows = 2;
  scene.rig.displays[0].image = image;
  const auto at = [&](glm::dvec3 place_m) {
    const RadianceImage shown = drawn(vulkan.device(), scene, false, [](FrameSettings& s) { s.bodies = true; });
    const View view = view_of(scene.rig.cameras[0]);
    const glm::dvec3 to = place_m - view.position_m;
    const double scale = glm::dot(to, view.forward) * view.tan_half_fov;
    const int x = static_cast<int>(kWidth / 2.0 + glm::dot(to, view.right) / scale * kHeight / 2.0);
    const int y = static_cast<int>(kHeight / 2.0 - glm::dot(to, view.up) / scale * kHeight / 2.0);
    const auto pixel = 3 * static_cast<std::size_t>(y * kWidth + x);
    return glm::vec3(shown.rgb.at(pixel), shown.rgb.at(pixel + 1), shown.rgb.at(pixel + 2));
  };
  view_from(scene, {0, -4, 2}, {0, 4, 1.9});
  scene.compile();
  const auto is_near = [](glm::vec3 color, glm::vec3 nits) {
    return glm::length(color - nits) < 0.02f * glm::length(nits);
  };
  CHECK(is_near(at({-0.8, 4, 2.4}), {800, 0, 0}));
  CHECK(is_near(at({0.8, 4, 2.4}), {0, 800, 0}));
  CHECK(is_near(at({-0.8, 4, 1.4}), {0, 0, 800}));
  CHECK(is_near(at({0.8, 4, 1.4}), {800, 800, 800}));
  // Its case hides the lit floor ahead of it, and stands in its own dark.
  view_from(scene, {0, 9, 2.5}, {0, 0, 1.2});
  scene.compile();
  CHECK(at({0, 4, 1.9}) == glm::vec3(0));
}

TEST_CASE("the cells of a display lie in levels down to one, near squares wherever there are pixels for it") {
  for (const auto& [columns, rows, width_m, height_m] :
       {std::tuple{1, 1, 1.0, 1.0}, std::tuple{37, 5, 3.2, 1.8}, std::tuple{1000, 1, 1.0, 1.0},
        std::tuple{4096, 3, 5.0, 0.01}, std::tuple{2, 4000, 1.0, 9.0}}) {
    Scene scene = display_scene(kClear, "");
    fixtures::Display& display = scene.rig.displays[0];
    display.columns = columns;
    display.rows = rows;
    display.width_m = width_m;
    display.height_m = height_m;
    const DisplayTables tables = display_tables(scene.rig, scene.compiled);
    const DisplayRow& row = tables.rows[0];
    REQUIRE(row.levels <= 32);
    CHECK(tables.levels.back().columns == 1);
    CHECK(tables.levels.back().rows == 1);
    double cell_width_m = width_m / columns, cell_height_m = height_m / rows;
    for (std::uint32_t level = 0; level + 1 < row.levels; ++level) {
      const bool down = (row.axes >> level & 1u) != 0;
      (down ? cell_height_m : cell_width_m) *= 2;
      const DisplayLevelRow &from = tables.levels[level], &to = tables.levels[level + 1];
      CHECK(to.columns == (down ? from.columns : (from.columns + 1) / 2));
      CHECK(to.rows == (down ? (from.rows + 1) / 2 : from.rows));
      const bool both = from.columns > 1 && from.rows > 1;
      if (both) CHECK((down ? cell_height_m : cell_width_m) <= 2.01 * (down ? cell_width_m : cell_height_m));
    }
    const auto bytes = [&](std::uint32_t binding) {
      return display_bytes(binding, {scene.rig, scene.compiled, scene.compiled.needs, {}});
    };
    CHECK(bytes(FL_BINDING_DISPLAY_PIXELS) == std::uint64_t{12} * row.columns * row.rows);
    CHECK(bytes(FL_BINDING_DISPLAY_CELLS) == 24 * tables.cells);
  }
}

TEST_CASE("a rig without a display has no pass and no buffer for them, and says so") {
  const auto compiled = must(fixtures::compile(fixtures::demo_rig()));
  CHECK(!compiled.needs.displays);
  const auto out = left_out_passes(compiled.needs, {});
  CHECK(std::any_of(out.begin(), out.end(), [](const LeftOutPass& pass) { return pass.name == "displays"; }));
  for (const int binding :
       {FL_BINDING_DISPLAYS, FL_BINDING_DISPLAY_LEVELS, FL_BINDING_DISPLAY_PIXELS, FL_BINDING_DISPLAY_CELLS,
        FL_BINDING_DISPLAY_JOBS}) {
    CHECK(display_bytes(static_cast<std::uint32_t>(binding), {fixtures::demo_rig(), compiled, compiled.needs, {}}) ==
          0);
  }
}

}  // namespace
}  // namespace footlight::render
