// Displays and projectors whose pixels come from outside, and displays that move with heads.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "fixtures/displays/screens.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/model/srgb.h"
#include "fixtures/projectors/projector.h"
#include "fixtures/simulate/walker.h"
#include "render/display_tables.h"
#include "render/frame.h"
#include "render/gobo_films.h"
#include "render/gobo_tables.h"
#include "render/memory_groups.h"
#include "render/reference/display_judge.h"
#include "tests/fixtures/files/gdtf_xml.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/temp_folder.h"
#include "tests/support/zip_bytes.h"

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
          kFloor +
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

TEST_CASE("the bytes of a frame have what the pixels of a film are copied to, in the group of displays") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene film = film_scene();
  Scene still = film;
  still.rig.displays[1].image = pixels_of(1);
  still.compile();
  const auto with = make_frame(vulkan.device(), film, judged_settings(kWidth, kHeight));
  const auto without = make_frame(vulkan.device(), still, judged_settings(kWidth, kHeight));
  const auto displays_of = [](Frame& frame) {
    std::uint64_t sum = 0, found = 0;
    for (const MemoryGroup& group : memory_groups(frame)) {
      sum += group.bytes;
      if (group.name == "displays") found = group.bytes;
    }
    CHECK(sum == frame.bytes());
    return found;
  };
  CHECK(with->bytes() - without->bytes() == 17 * 9 * kPixelBytes);
  CHECK(displays_of(*with) - displays_of(*without) == 17 * 9 * kPixelBytes);
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

// As Scene::compile(), for a rig whose fixtures have no addresses.
void compile_unpatched(Scene& scene) {
  scene.compiled = must(fixtures::compile(scene.rig));
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
}

// A projector with a pixel map of 8 x 4 pixels on a wall, in haze.
Scene projector_scene(const std::string& keys) {
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"P\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0.02\n"
      "[[projector]]\nposition = [0, -4, 3]\naim = [0, 4, 2]\nthrow_ratio = 1.5\n"
      "content = { universe = 1, columns = 8, rows = 4, color = [1, 0.8, 0.6] }\n" +
          keys +
          "[[box]]\nname = \"Wall\"\nmin = [-6, 4, 0]\nmax = [6, 4.2, 6]\nalbedo = [0.6, 0.6, 0.6]\n"
      "[[camera]]\nname = \"main\"\nposition = [-3, -6, 2]\ntarget = [0, 4, 2]\nfov_deg = 45\n",
      "projector.toml"));
  compile_unpatched(scene);
  return scene;
}

std::shared_ptr<const fixtures::PaneImage> blocks_of(std::uint64_t seed) {
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{8, 4, {}});
  Random random(seed);
  for (int i = 0; i < 8 * 4; ++i) {
    const auto level = [&] { return static_cast<float>(std::floor(random.between(0, 256))) / 255; };
    image->texels.emplace_back(level(), level(), level());
  }
  return image;
}

// The share by which pictures differ in all.
double difference(const std::vector<float>& a, const std::vector<float>& b) {
  double apart = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    apart += std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    all += static_cast<double>(b[i]);
  }
  return all > 0 ? apart / all : apart;
}

TEST_CASE("a projector whose picture changes throws what one with an image of the same pixels throws") {
  std::string keys;
  SUBCASE("that fills its panel") {}
  SUBCASE("that has a keystone and a blend") {
    keys = "keystone = { top_left = [0.2, 0], bottom_right = [-0.1, 0.3] }\nblend = { left = 0.3, gamma = 2 }\n";
  }
  HeadlessVulkan vulkan;
  Scene scene = projector_scene(keys);
  const auto still = [&](const std::shared_ptr<const fixtures::PaneImage>& image) {
    Scene other = projector_scene(keys);
    fixtures::Projector projector = *other.rig.types.at(0).said_by_rig.projector;
    fixtures::Display content = *projector.content;
    content.map.reset();
    content.image = image;
    projector.content = std::make_shared<const fixtures::Display>(content);
    other.rig.types[0] = fixtures::make_projector(projector);
    fixtures::place_screens(other.rig);
    compile_unpatched(other);
    return drawn(*make_frame(vulkan.device(), other, judged_settings(kWidth, kHeight)), other);
  };
  CHECK(plan_gobo_tables(scene.compiled, {3}, 0).rows.at(0).lines == 0);  // light in haze is sampled
  const std::vector<float> first = still(blocks_of(1)), second = still(blocks_of(2));
  REQUIRE(difference(first, second) > 0.1);
  // Pixels from DMX.
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  const std::vector<float> dark = drawn(*frame, scene);
  CHECK(std::all_of(dark.begin(), dark.end(), [](float light) { return light == 0; }));
  for (const unsigned seed : {1u, 2u, 1u}) {
    std::size_t slot = 0;
    const auto blocks = blocks_of(seed);
    for (const glm::vec3& texel : blocks->texels) {
      for (int c = 0; c < 3; ++c) scene.levels.at(slot++) = static_cast<std::uint8_t>(std::lround(255 * texel[c]));
    }
    CHECK(difference(drawn(*frame, scene), seed == 1 ? first : second) < 0.01);
  }
  // They are those of a state that is loaded, whatever levels came in between.
  const FrameState kept = must(frame->save_state());
  frame->step(std::vector<std::uint8_t>(scene.levels.size(), 255), kNsPerMs, true);
  must(frame->load_state(kept));
  must(frame->draw(view_of(scene.rig.cameras[0]), 5));
  CHECK(difference(must(frame->read_radiance()).rgb, first) < 0.01);
  // Pixels from a video.
  scene = projector_scene(keys);
  scene.rig.projections.at(0).map.reset();
  scene.rig.projections[0].video.emplace();
  compile_unpatched(scene);
  const auto film = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  CHECK(drawn(*film, scene) == dark);
  film->show_pixels(0, blocks_of(2));
  CHECK(difference(drawn(*film, scene), second) < 0.01);
  CHECK(difference(drawn(*film, scene), second) < 0.01);  // it stays
}

TEST_CASE("texels of a film are means over the picture, with levels that are means of four, black around it") {
  const fixtures::PaneImage picture{3, 1, {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}};
  const FilmTexels film = film_texels(picture, glm::vec3(1), {128, 384, 256, 256}, 8);
  REQUIRE(film.levels.size() == 4);
  const auto texel = [&](std::size_t level, int column, int row) {
    const FilmLevel& own = film.levels[level];
    const auto at = own.first + 4 * static_cast<std::size_t>((row - own.top) * own.columns + column - own.left);
    return glm::vec3(film.texels[at], film.texels[at + 1], film.texels[at + 2]);
  };
  const auto code = [](double light) { return std::round(255 * fixtures::srgb_of_linear(light)); };
  CHECK(texel(0, 1, 3) == glm::vec3(code(2.0 / 3), code(1.0 / 3), 0));
  CHECK(texel(0, 2, 4) == glm::vec3(0, code(1.0 / 3), code(2.0 / 3)));
  CHECK(film.levels[1].columns == 2);  // texels 0 and 1, and rows 1 and 2, of four a side
  CHECK(texel(1, 0, 1) == glm::vec3(code(2.0 / 12), code(1.0 / 12), 0));
  CHECK(texel(3, 0, 0) == glm::vec3(code(4.0 / 3 / 64), code(4.0 / 3 / 64), code(4.0 / 3 / 64)));
}

TEST_CASE("texels of a film are where those of an image that stands are, to a part of a texel") {
  fixtures::Projector projector;
  projector.lens_shift = {0.13, -0.31};
  bool is_changed = false;
  SUBCASE("of the picture") {}
  SUBCASE("of a picture with a keystone and a blend") {
    is_changed = true;
    projector.keystone = {{0.1, -0.05}, {-0.2, 0}, {0, 0.01}, {-0.1, 0.15}};
    projector.blend = {0.2, 0, 0, 0.1, 1.5};
  }
  const auto picture = blocks_of(5);
  const fixtures::ImageSource source{fixtures::projector_files(projector, picture),
                                     std::string(fixtures::kProjectorImage), false, true};
  const fixtures::GoboPart part =
      fixtures::picture_part(fixtures::projected_frame(projector), fixtures::kProjectorGoboPx);
  for (const int size_px : {1024, 512, 128}) {
    CAPTURE(size_px);
    const std::vector<float> still = must(fixtures::gobo_texels(source, size_px, 0.1));
    CHECK(changes_on_panel(projector) == is_changed);
    const FilmTexels film =
        is_changed ? film_texels(fixtures::PanelFilm(projector, part.columns, part.rows).shown(*picture), glm::vec3(1),
                                 part, size_px)
                   : film_texels(*picture, glm::vec3(1), part, size_px);
    const FilmLevel& level = film.levels.at(0);
    double worst = 0;
    for (int y = 0; y < size_px; ++y) {
      for (int x = 0; x < size_px; ++x) {
        const bool within = y >= level.top && y < level.top + level.rows && x >= level.left &&
                            x < level.left + level.columns;
        const auto at = static_cast<std::size_t>(4 * ((y - level.top) * level.columns + x - level.left));
        for (std::size_t c = 0; c < 3; ++c) {
          const float code = within ? static_cast<float>(film.texels.at(at + c)) : 0.0f;
          const float light = still[3 * static_cast<std::size_t>(y * size_px + x) + c];
          worst = std::max<double>(worst, std::abs(fixtures::linear_of_srgb(code / 255) - light));
        }
      }
    }
    // 0.008 is a code where the curve is steepest.
    CHECK(worst < 0.01);
  }
}

TEST_CASE("the texels of a picture of a projector are at most 1.6 MB with all levels of detail") {
  fixtures::PaneImage picture{714, 402, std::vector<glm::vec3>(714 * 402, glm::vec3(0.3f, 0.6f, 0.1f))};
  (void)film_texels(picture, glm::vec3(1), {0, 0, 1, 1}, 1024);  // makes the table of codes
  for (const int size_px : {1024, 512}) {
    const std::clock_t from = std::clock();
    const FilmTexels film = film_texels(picture, glm::vec3(1), {155, 311, 714, 402}, size_px);
    const double taken_ms = 1e3 * static_cast<double>(std::clock() - from) / CLOCKS_PER_SEC;
    CHECK(film.texels.size() < std::size_t{1'600'000});
    if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) {
      MESSAGE("714 x 402 for gobos of " << size_px << ": " << taken_ms << " ms of processor time, "
                                        << film.texels.size() << " bytes");
    }
  }
}

// A screen on a yoke over a floor; levels 0 and 255 are 90 degrees to either side.
Scene yoke_scene(const footlight::testing::TempFolder& folder) {
  fixtures::GdtfParts parts;
  parts.before = "<Models><Model Name='Face' Length='1.6' Width='0.04' Height='0.9' PrimitiveType='Cube'/></Models>";
  parts.geometries =
      "<Geometry Name='Base'><Axis Name='Yoke'>"
      "<Display Name='Screen' Model='Face' Texture='t' Position='{1,0,0,0}{0,1,0,-0.4}{0,0,1,-0.7}{0,0,0,1}'/>"
      "</Axis></Geometry>";
  parts.channels = fixtures::gdtf_channel("Yoke", "1", "Pan", "<ChannelFunction PhysicalFrom='-90' PhysicalTo='90'/>");
  std::ofstream(folder.file("yoke.gdtf"), std::ios::binary)
      << footlight::testing::make_zip({{"description.xml", fixtures::gdtf_xml(parts)}});
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"Y\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0.02\n"
      "[[fixture]]\nname = \"Y\"\ntype = \"yoke.gdtf\"\nuniverse = 1\naddress = 1\nposition = [0, 4, 3]\n"
      "content = { nits = 700, columns = 2, rows = 2, universe = 2 }\n"
      "[[box]]\nname = \"Floor\"\nmin = [-9, -9, -1]\nmax = [9, 9, 0]\nalbedo = [0.5, 0.4, 0.3]\n"
      "[[camera]]\nname = \"main\"\nposition = [3, -4, 2]\ntarget = [0, 4, 1.5]\nfov_deg = 60\n",
      folder.file("rig.toml")));
  scene.compile();
  for (std::size_t i = 0; i < 12; ++i) scene.levels.at(kSlotCountMax + i) = static_cast<std::uint8_t>(20 * (i + 1));
  return scene;
}

TEST_CASE("a screen on a yoke is where a display in its place is, before and after it has turned") {
  const footlight::testing::TempFolder folder;
  HeadlessVulkan vulkan;
  Scene scene = yoke_scene(folder);
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.bodies = false;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  for (const int level : {0, 255}) {
    CAPTURE(level);
    scene.levels.at(0) = static_cast<std::uint8_t>(level);
    frame->step(scene.levels, 60'000'000'000);
    const std::vector<float> turned = drawn(*frame, scene);
    Scene other = scene;
    fixtures::Display& display = other.rig.displays.at(0);
    const double side = level == 0 ? -1 : 1;  // positive pan is counterclockwise as seen from above
    display.position_m = glm::dvec3(side * (0.42 + fixtures::kScreenAwayM), 4, 2.3);
    display.rotation_deg = glm::dvec3(0, 0, side * 90);
    display.fixture = -1;
    other.compile();
    other.levels = scene.levels;
    CHECK(difference(drawn(*make_frame(vulkan.device(), other, settings), other), turned) < 1e-4);
    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    CHECK(glm::distance(judge_scene(scene.rig, walker).displays.at(0).center_m, display.position_m) < 1e-6);
    CHECK(glm::distance(judge_scene(scene.rig, walker).displays.at(0).right_m, glm::dvec3(0, side * 0.8, 0)) < 1e-6);
  }
}

}  // namespace
}  // namespace footlight::render
