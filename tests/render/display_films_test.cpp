// Displays whose pixels come from outside: of videos.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "render/display_tables.h"
#include "render/frame.h"
#include "render/reference/display_judge.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 32, kHeight = 18;

// A display of 17 x 9 pixels beside one of DMX and one with an image, before a floor in haze.
Scene film_scene() {
  const std::string sizes = "width_m = 3.2\nheight_m = 1.8\nnits = 800\ncolumns = 17\nrows = 9\n";
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"Films\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0.03\n"
      "[[display]]\nposition = [-4, 4, 1.9]\nuniverse = 1\n" +
          sizes + "[[display]]\nposition = [0, 4, 1.9]\n" + sizes + "[[display]]\nposition = [4, 4, 1.9]\n" + sizes +
          "[[box]]\nname = \"Floor\"\nmin = [-20, -20, -1]\nmax = [20, 20, 0]\nalbedo = [0.5, 0.4, 0.3]\n"
          "[[camera]]\nname = \"main\"\nposition = [-3, -4, 2]\ntarget = [0, 2.5, 1.2]\nfov_deg = 75\n",
      "films.toml"));
  scene.rig.displays[1].video.emplace();
  scene.compile();
  std::fill(scene.levels.begin(), scene.levels.end(), std::uint8_t{90});
  return scene;
}

std::shared_ptr<const fixtures::PaneImage> pixels_of(std::uint64_t seed) {
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{17, 9, {}});
  Random random(seed);
  for (int i = 0; i < 17 * 9; ++i) {
    image->texels.emplace_back(random.between(0, 1), random.between(0, 1), random.between(0, 1));
  }
  return image;
}

std::vector<float> drawn(Frame& frame, const Scene& scene) {
  frame.step(scene.levels, 0);
  must(frame.draw(view_of(scene.rig.cameras[0]), 5));
  return must(frame.read_radiance()).rgb;
}

TEST_CASE(
    "a film has jobs of its own, which begin above its pixels, and a picture of it that stands has those of images") {
  Scene scene = film_scene();
  DisplayTables tables = display_tables(scene.rig, scene.compiled);
  const auto displays_of = [&](const DisplayJobs& jobs) {
    std::vector<std::uint32_t> all;
    for (const DisplayJobRange& range : jobs) {
      for (std::uint32_t i = 0; i < range.count; ++i) {
        const DisplayJobRow& job = tables.jobs[range.first + i];
        if (job.level == 0) CHECK(job.display == 0);
        if (all.empty() || all.back() != job.display) all.push_back(job.display);
      }
    }
    return all;
  };
  CHECK(displays_of(tables.live) == std::vector<std::uint32_t>{0});
  CHECK(displays_of(tables.film) == std::vector<std::uint32_t>{1});
  CHECK(displays_of(tables.still) == std::vector<std::uint32_t>{2});
  scene.rig.displays[1].image = pixels_of(1);
  tables = display_tables(scene.rig, scene.compiled);
  CHECK(tables.film.empty());
}

TEST_CASE("a film shows to the bit what an image of its pixels shows, and is dark before the first ones") {
  HeadlessVulkan vulkan;
  const Scene scene = film_scene();
  const auto still = [&](const std::shared_ptr<const fixtures::PaneImage>& image) {
    Scene other = scene;
    other.rig.displays[1].image = image;
    other.compile();
    other.levels = scene.levels;
    return drawn(*make_frame(vulkan.device(), other, judged_settings(kWidth, kHeight)), other);
  };
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  const auto black = std::make_shared<const fixtures::PaneImage>(
      fixtures::PaneImage{17, 9, std::vector<glm::vec3>(17 * 9, glm::vec3(0))});
  const std::vector<float> dark = drawn(*frame, scene);
  CHECK(dark == still(black));
  frame->show_pixels(0, pixels_of(3));  // of DMX: ignored
  CHECK(drawn(*frame, scene) == dark);
  frame->show_pixels(1, pixels_of(1));
  const std::vector<float> first = drawn(*frame, scene);
  CHECK(first != dark);
  CHECK(first == still(pixels_of(1)));
  CHECK(drawn(*frame, scene) == first);  // it stays
  frame->show_pixels(1, pixels_of(2));
  must(frame->run_steps());
  FrameSettings other = frame->settings();
  other.haze = false;
  must(frame->change(other));  // its pixels are not lost by other settings
  (void)drawn(*frame, scene);
  must(frame->change(judged_settings(kWidth, kHeight)));
  CHECK(drawn(*frame, scene) == still(pixels_of(2)));
}

TEST_CASE("a screen that its fixture dims shows to the bit what a display of that luminance shows") {
  HeadlessVulkan vulkan;
  const auto scene_of = [](double nits, bool is_screen) {
    Scene scene = film_scene();
    scene.rig.displays.pop_back();
    scene.rig.displays.erase(scene.rig.displays.begin());
    fixtures::Display& display = scene.rig.displays[0];
    display.image = pixels_of(4);  // a picture of the video, which stands
    display.nits = nits;
    fixtures::Rig lamp = must(fixtures::parse_rig(
        "[rig]\nname = \"L\"\n[[fixture]]\nname = \"L\"\ntype = \"dimmers/1\"\nuniverse = 1\naddress = 1\n"
        "position = [0, 4, 9]\n",
        "lamp.toml"));
    scene.rig.types = lamp.types;
    scene.rig.fixtures = lamp.fixtures;
    std::vector<fixtures::Geometry>& geometries = scene.rig.types[0].modes[0].geometries;
    for (std::size_t i = 0; i < geometries.size(); ++i) {
      if (geometries[i].beam == fixtures::kNoIndex) continue;
      geometries[i].beam = fixtures::kNoIndex;
      geometries[i].kind = fixtures::GeometryKind::kDisplay;
      if (!is_screen) continue;
      display.fixture = 0;
      display.geometry = static_cast<int>(i);
    }
    scene.compile();
    return scene;
  };
  Scene screen = scene_of(800, true);
  const auto frame = make_frame(vulkan.device(), screen, judged_settings(kWidth, kHeight));
  const auto plain = [&](double nits) {
    const Scene scene = scene_of(nits, false);
    return drawn(*make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight)), scene);
  };
  for (const int level : {51, 255, 51}) {
    CAPTURE(level);
    screen.levels.at(0) = static_cast<std::uint8_t>(level);
    CHECK(drawn(*frame, screen) == plain(800.0 * level / 255));
  }
  screen.levels.at(0) = 0;
  const std::vector<float> dark = drawn(*frame, screen);
  CHECK(std::all_of(dark.begin(), dark.end(), [](float light) { return light == 0; }));
  // The judge has the same shares.
  const auto sum_of = [](const Scene& scene) {
    JudgeScene judge;
    add_displays(judge, scene.rig, scene.compiled, scene.levels);
    glm::dvec3 sum(0);
    for (const glm::dvec3& pixel : judge.displays.at(0).pixels_cd_m2) sum += pixel;
    return sum.r;
  };
  screen.levels.at(0) = 51;
  CHECK(sum_of(screen) == doctest::Approx(sum_of(scene_of(160, false))));
}

}  // namespace
}  // namespace footlight::render
