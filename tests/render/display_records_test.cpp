// Light of displays by records (displaynodes.comp), which interpolate it between pixels: against the light of each
// pixel by itself. That against the judge: displays_test.cpp.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "render/frame.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 320, kHeight = 180;

const std::string kRisers =
    "[[box]]\nname = \"A\"\nmin = [-1.5, 1, 0]\nmax = [-0.5, 2, 1.4]\nalbedo = [0.5, 0.5, 0.5]\n"
    "[[box]]\nname = \"B\"\nmin = [0.8, 2.2, 0]\nmax = [1.6, 3, 2.2]\nalbedo = [0.2, 0.5, 0.5]\n"
    "[[box]]\nname = \"C\"\nmin = [2.2, 1.2, 0]\nmax = [2.3, 3, 1.2]\nalbedo = [0.5, 0.5, 0.2]\n";
// A plane of black and white fields; what a record is checked for is what the white ones reflect.
const std::string kFields = [] {
  std::string fields;
  for (int i = 0; i < 12; ++i) {
    const std::string low = std::to_string(i - 6), high = std::to_string(i - 5);
    const std::string albedo = i % 2 == 0 ? "[0.001, 0.001, 0.001]" : "[0.95, 0.95, 0.95]";
    fields += "[[box]]\nname = \"F" + low + "\"\nmin = [" + low + ", -20, -1]\nmax = [" + high +
              ", 20, 0]\nalbedo = " + albedo + "\n";
  }
  return fields;
}();
const std::string kPeople =
    "[[scenery]]\nkind = \"person\"\nposition = [-1.4, 0.6, 0]\n"
    "[[scenery]]\nkind = \"person\"\nposition = [0.3, -1.5, 0]\nrotation = [0, 0, 40]\n";
const std::string kHaze = "scattering_per_m = 0.03\nabsorption_per_m = 0.005\nanisotropy = 0.5";

std::string display_at(const std::string& position, const std::string& more) {
  return "[[display]]\nposition = " + position + "\nwidth_m = 3.2\nheight_m = 1.8\nnits = 800\n" + more + "\n";
}

Scene scene_of(const std::string& haze, const std::string& things) {
  Scene scene;
  scene.rig = must(fixtures::parse_rig("[rig]\nname = \"Displays\"\nambient_lx = 0\n[haze]\n" + haze + "\n" + things +
                                           "[[camera]]\nname = \"main\"\nposition = [-3, -4, 2]\n"
                                           "target = [0, 2.5, 1.2]\nfov_deg = 55\n",
                                       "records.toml"));
  scene.compile();
  return scene;
}

// Smooth in red, fields in green, fine in blue.
void give_picture(fixtures::Display& display) {
  const int columns = 32, rows = 18;
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{columns, rows, {}});
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const bool field = (x / 8 + y / 6) % 2 != 0, fine = (x + y) % 2 != 0;
      image->texels.emplace_back(static_cast<float>(x) / columns, field ? 1.0f : 0.1f, fine ? 0.8f : 0.0f);
    }
  }
  display.columns = columns;
  display.rows = rows;
  display.image = image;
}

struct Drawn {
  RadianceImage image;
  DisplayWork work;
};
Drawn draw_at(vk::Device& device, const Scene& scene, double tile_error, const FrameSettings& base) {
  FrameSettings settings = base;
  settings.tile_error = tile_error;
  auto frame = make_frame(device, scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  return {must(frame->read_radiance()), must(frame->read_display_work())};
}
FrameSettings with_bodies() {
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.bodies = true;
  return settings;
}

struct Case {
  const char* what;
  std::string haze;
  std::string things;
  double most_pixels;  // share of the picture that is computed by pixels
  std::function<void(Scene&)> change = [](Scene&) {};
  FrameView view = FrameView::kPicture;
};

void check_near_pixels(vk::Device& device, const Case& c) {
  CAPTURE(std::string(c.what));
  Scene scene = scene_of(c.haze, c.things);
  c.change(scene);
  scene.compile();
  FrameSettings settings = with_bodies();
  settings.view = c.view;
  const Drawn fast = draw_at(device, scene, FrameSettings{}.tile_error, settings);
  const Drawn exact = draw_at(device, scene, 0, settings);
  double error = 0, light = 0, worst = 0;
  // Where light begins, hardly any of it may be missing.
  const double hardly = 0.01 * sum_of(exact.image) / static_cast<double>(exact.image.rgb.size());
  for (std::size_t i = 0; i < exact.image.rgb.size(); i += 3) {
    double off = 0, own = hardly;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<double>(fast.image.rgb[i + k]), b = static_cast<double>(exact.image.rgb[i + k]);
      REQUIRE(std::isfinite(a));
      error += (a - b) * (a - b);
      light += b * b;
      off = std::max(off, std::abs(a - b));
      own = std::max(own, b);
    }
    worst = std::max(worst, off / own);
  }
  REQUIRE(light > 0);
  error = std::sqrt(error / light);
  const double pixels = static_cast<double>(fast.work.pixels) / (kWidth * kHeight);
  print_error(c.what, error);
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) {
    std::printf("  worst pixel %.2e, pixels %.3f, on surfaces %.3f\n", worst, pixels,
                static_cast<double>(fast.work.surface_pixels) / (kWidth * kHeight));
  }
  CHECK(error < 1e-3);
  CHECK(worst < 0.03);
  CHECK(pixels < c.most_pixels);
  CHECK(exact.work.pixels == kWidth * kHeight);
  CHECK(exact.work.records[0] == 0);
}

const std::string kWall = display_at("[0, 4, 1.9]", "");
const auto picture = [](Scene& scene) { give_picture(scene.rig.displays[0]); };

TEST_CASE("light of displays by records is near that of each pixel by itself") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  std::string many;
  for (int i = 0; i < 12; ++i) {
    many += display_at("[" + std::to_string(2 * (i % 6) - 5) + ", " + std::to_string(5 + i / 6) + ", 2]",
                       "color = [1, 0." + std::to_string(i % 10) + ", 0.5]");
  }
  for (const Case& c :
       {Case{"haze alone", kHaze, kWall, 0.05}, Case{"planes", kHaze, kFloor + kRisers + kWall, 0.08},
        Case{"planes, an image", kHaze, kFloor + kRisers + kWall, 0.12, picture},
        Case{"people", kHaze, kFloor + kPeople + kWall, 0.1},
        Case{"black and white fields, an image", kHaze, kFields + kWall, 0.15, picture},
        Case{"in its haze, 0.4 m before it", kHaze, kFloor + kRisers + kWall, 0.05,
             [](Scene& s) {
               view_from(s, {0.5, 3.6, 1.9}, {-2, 2, 1.5});
             }},
        Case{"towards its face from 0.4 m", kHaze, kFloor + kWall, 0.1,
             [](Scene& s) {
               picture(s), view_from(s, {0.5, 3.6, 1.9}, {-0.5, 4, 1.6});
             }},
        Case{"from behind", kHaze, kFloor + kWall, 0.1,
             [](Scene& s) {
               view_from(s, {3, 9, 3}, {0, 2, 1});
             }},
        Case{"dense haze", "scattering_per_m = 0.8\nabsorption_per_m = 0.4", kFloor + kRisers + kWall, 0.1},
        Case{"clouds", "scattering_per_m = 0.03\nnoise = 0.8\nsize_m = 3\nseed = 4", kFloor + kRisers + kWall, 0.15},
        Case{"twelve", kHaze, kFloor + kRisers + many, 0.15},
        Case{"lux", kHaze, kFloor + kRisers + kWall, 0.1, picture, FrameView::kLux}}) {
    check_near_pixels(vulkan.device(), c);
  }
}

TEST_CASE("light of displays by records repeats to the bit, in another frame too") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = scene_of(kHaze, kFloor + kRisers + kPeople + kWall);
  picture(scene);
  scene.compile();
  const auto frame = make_frame(vulkan.device(), scene, [] {
    FrameSettings settings = with_bodies();
    settings.tile_error = FrameSettings{}.tile_error;
    return settings;
  }());
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  const RadianceImage first = must(frame->read_radiance());
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  CHECK(first.rgb == must(frame->read_radiance()).rgb);
  CHECK(first.rgb == draw_at(vulkan.device(), scene, FrameSettings{}.tile_error, with_bodies()).image.rgb);
}

TEST_CASE("a body before a display has its light in the air from records, and that on its surface by pixels") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = scene_of(kHaze, kFloor + kPeople + kWall);
  const DisplayWork work = draw_at(vulkan.device(), scene, FrameSettings{}.tile_error, with_bodies()).work;
  CHECK(work.records[0] > 0);
  CHECK(work.surface_pixels > 500);
}

TEST_CASE("without a display there is no record of its light, and no memory for any") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = scene_of(kHaze, kFloor);
  FrameSettings settings = with_bodies();
  settings.tile_error = FrameSettings{}.tile_error;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  const DisplayWork work = must(frame->read_display_work());
  CHECK(work.pixels + work.surface_pixels + work.records[0] == 0);
  CHECK(frame->resources().picture.display_records.size_bytes < 1024);
  CHECK(frame->resources().picture.display_tiles.size_bytes < 1024);
}

}  // namespace
}  // namespace footlight::render
