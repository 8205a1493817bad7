// Extreme cameras, beams and sizes: every case with beams taken together for tiles, pixel by pixel, and by the judge in
// double. docs/numerics.md lists the cases ("Extremes"). They take minutes, so none runs without FOOTLIGHT_LONG_TESTS,
// which tools/test --long sets.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/beam.h"
#include "render/reference/judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// Fixed beams: more than FrameSettings::tile_beams, so that the passes of tiles run as they do in a show.
constexpr int kLamps = 144;

constexpr int kWidth = 160;
constexpr int kHeight = 90;
const double kTileError = FrameSettings{}.tile_error;

struct Lamps {
  double radius_m = 0.05;
  double full_angle_deg = 16;
  int profile = 1;
  double flux_lm = 10'000;
  double apart_m = 0.3;   // how far the lamps are from the first one, along each axis
  double apart_deg = 4;   // and how far they are turned
  bool mirrored = false;  // their poses mirror and stretch
};

fixtures::FixtureType fixed_lamp(const Lamps& lamps) {
  fixtures::FixtureType type;
  type.id = "test/fixed";
  fixtures::Beam beam;
  beam.lamp = fixtures::LampType::kIdeal;
  beam.profile_power = lamps.profile;
  beam.beam_angle_deg = beam.field_angle_deg = lamps.full_angle_deg;
  beam.radius_m = lamps.radius_m;
  beam.flux_lm = lamps.flux_lm;
  type.beams.push_back(beam);
  fixtures::Mode mode;
  mode.name = "one";
  mode.slot_count = 1;
  mode.geometries = fixtures::simple_geometries(0, 0);
  fixtures::Channel channel;
  channel.name = "Dimmer";
  channel.geometry = fixtures::kSimpleHead;
  channel.slot_offsets = {0};
  fixtures::ChannelFunction function;
  function.name = function.attribute = "Dimmer";
  function.dmx_to = 255;
  function.physical_to = 1;
  channel.functions.push_back(function);
  mode.channels.push_back(channel);
  type.modes.push_back(mode);
  return type;
}

// The first lamp is at (0, 0, 5) and shines along +Y; the others are near it. All are at full.
Scene lamp_cluster(const Lamps& lamps, int count = kLamps) {
  Scene scene;
  scene.rig.name = "extreme";
  scene.rig.haze = {0.02, 0.001, 0.4, 30};
  scene.rig.ambient_lx = 0;
  scene.rig.types = {fixed_lamp(lamps)};
  Random random(77);
  for (int i = 0; i < count; ++i) {
    fixtures::PatchedFixture lamp;
    lamp.name = "Lamp " + std::to_string(i + 1);
    lamp.universe = 1 + i / kSlotCountMax;
    lamp.address = 1 + i % kSlotCountMax;
    const double apart = i == 0 ? 0 : 1;
    const auto near = [&](double reach) { return apart * random.between(-reach, reach); };
    lamp.position_m = {near(lamps.apart_m), near(lamps.apart_m), 5 + near(lamps.apart_m)};
    lamp.rotation_deg = {90 + near(lamps.apart_deg), near(lamps.apart_deg), near(lamps.apart_deg)};
    if (lamps.mirrored) {
      // The beam leaves along -Z of the fixture.
      glm::dmat4 pose(1);
      const double turn = near(lamps.apart_deg) * kDegree;
      pose[0] = {-std::cos(turn), 0, std::sin(turn), 0};
      pose[1] = {1.7 * std::sin(turn), 0, 1.7 * std::cos(turn), 0};
      pose[2] = {0, -0.5, 0, 0};
      pose[3] = glm::dvec4(lamp.position_m, 1);
      lamp.pose = pose;
    }
    scene.rig.fixtures.push_back(lamp);
  }
  // A dark flood of another profile: all scenes need the same shaders, whose compiling takes most of the time.
  scene.rig.types.push_back(fixed_lamp({.full_angle_deg = 175, .profile = 4}));
  fixtures::PatchedFixture dark;
  dark.name = "Dark";
  dark.type = 1;
  dark.universe = 100;
  scene.rig.fixtures.push_back(dark);
  scene.compile();
  std::fill(scene.levels.begin(), scene.levels.end(), std::uint8_t{255});
  scene.slots(scene.rig.fixtures.size() - 1)[0] = 0;
  return scene;
}

void recompile(Scene& scene) {
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
}

void furnish(Scene& scene) {
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  scene.rig.boxes.push_back({"wall", {-20, 12, 0}, {20, 12.2, 12}, glm::dvec3(0.3)});
  scene.rig.boxes.push_back({"box", {-1, 7, 3}, {0.5, 8, 5.2}, glm::dvec3(0.3)});
  recompile(scene);
}

struct Row {
  const char* name;
  Lamps lamps;
  fixtures::Camera camera;
  bool furnished = true;
  double reach_m = 30;
  double anisotropy = 0.4;
  double judged_max = 2e-5;  // relL2 of beams pixel by pixel, 8 nodes, against the judge
  double tiles_max = 6e-4;   // of the tiles against that
};

// Measured on lavapipe, 160 x 90 pixels: at most 8.5e-6 of the judge, and 2.0e-4 between tiles and pixels.
std::vector<Row> rows() {
  const glm::dvec3 lens(0, 0, 5);
  const double k = std::tan(8 * kDegree);
  std::vector<Row> all;
  const auto add = [&](const char* name, const Lamps& lamps, glm::dvec3 from, glm::dvec3 to, double fov_deg) -> Row& {
    all.push_back({.name = name, .lamps = lamps, .camera = {"c", from, to, fov_deg, 4}});
    return all.back();
  };
  add("front of house", {}, {0, -14, 3}, {0, 5, 4}, 55);
  add("in the beam, along it", {}, {0.05, 4, 5.02}, {0, 10, 5}, 60);
  add("in the beam, across it", {}, {0.05, 4, 5.02}, {3, 4.5, 5}, 60);
  add("in the beam, into the lens", {}, {0.05, 4, 5.02}, lens, 60);
  add("on the axis, into the lens", {}, {0, 6, 5}, lens, 40);
  add("on the axis, from behind", {}, {0, -3, 5}, {0, 5, 5}, 40);
  add("at the lens, along the beam", {}, lens, {0, 5, 5}, 60);
  add("at the lens, across the beam", {}, lens, {5, 0, 5}, 60);
  add("at the virtual apex", {}, {0, -0.05 / k, 5}, {0, 5, 5}, 40);
  add("along a generator", {}, {0.05 + k * 2, 2, 5}, {0.05 + k * 9, 9, 5}, 50);
  add("2 cm in front of the lens, away from it", {}, {0, 0.02, 5}, {0, 6, 5}, 60);
  add("lens at the near plane, behind the camera", {}, {0, 0.05, 5}, {0, 6, 5}, 100);
  add("1 km away", {}, {0, -1000, 5}, {0, 5, 5}, 1.5);
  add("1 mm in front of the wall", {}, {0, 11.999, 5}, {2, 11.99, 5.5}, 90);
  add("cylinder, from outside", {.full_angle_deg = 0}, {2, -3, 5}, {0, 5, 5}, 50);
  add("cylinder, along the axis", {.full_angle_deg = 0}, {0.02, -2, 5}, {0.02, 5, 5}, 50);
  add("cylinder, in it", {.full_angle_deg = 0, .apart_m = 0.02}, {0.01, 3, 5.01}, {0, 12, 5}, 50);
  const Lamps laser{
      .radius_m = 0.001, .full_angle_deg = 1e-6 / kDegree, .flux_lm = 1, .apart_m = 0.004, .apart_deg = 0};
  add("laser of 1e-6 rad", laser, {10, 5, 5}, {0, 5, 5}, 0.05);
  add("laser of 1e-6 rad, along it", laser, {0.0003, 0.5, 5}, {0.0003, 12, 5}, 0.05);
  add("laser of 1e-6 rad, into it", laser, {0.0003, 11, 5}, {0.0003, 0, 5}, 0.05);
  const Lamps flood{.full_angle_deg = 150};
  add("flood of 75 degrees of half angle, from outside", flood, {0, -6, 5}, {0, 5, 5}, 60);
  add("flood of 75 degrees, in it", flood, {3, 3, 5}, {-3, 4, 4}, 60);
  add("flood of 75 degrees, at the lens", flood, lens, {0, 5, 5}, 60);
  const Lamps widest{.full_angle_deg = 175, .profile = 4};
  add("flood of 87.5 degrees, from outside", widest, {0, -6, 5}, {0, 5, 5}, 60);
  add("flood of 87.5 degrees, in it", widest, {3, 3, 5}, {-3, 4, 4}, 60);
  // Measured: 2.6e-4 of the judge. Equal floods have equal polynomials on surfaces, so their errors add up: 1.8e-3.
  for (Row& row : all) {
    if (row.lamps.full_angle_deg < 90) continue;
    row.judged_max = 8e-4;
    row.tiles_max = kTileError;
  }
  add("no far end, from outside", {}, {0, -14, 3}, {0, 5, 4}, 55);
  all.back().furnished = false;
  all.back().reach_m = 1e6;
  all.back().judged_max = 8e-4;  // measured: 2.8e-4, the extinction over the whole chord
  add("no far end, along the beam", {}, {0.05, 4, 5.02}, {0, 10, 5}, 60);
  all.back().furnished = false;
  all.back().reach_m = 1e6;
  all.back().judged_max = 4e-3;  // measured: 1.5e-3
  add("mirrored and stretched heads", {.mirrored = true}, {2, -3, 5}, {0, 5, 5}, 50);
  add("mirrored and stretched heads, in their beams", {.mirrored = true}, {0.05, 4, 5.02}, {3, 6, 5}, 60);
  add("forward scattering, g = 0.95", {}, {0, 11, 5}, lens, 60);
  all.back().anisotropy = 0.95;
  all.back().judged_max = 3e-4;  // measured: 1.0e-4
  add("backward scattering, g = -0.95", {}, {0.3, -4, 5}, {0, 5, 5}, 60);
  all.back().anisotropy = -0.95;
  all.back().judged_max = 3e-4;  // measured: 9.4e-5
  add("lamps of 1e12 lm", {.flux_lm = 1e12}, {0, 6, 5}, lens, 40);
  add("lamps of 1e-9 lm", {.flux_lm = 1e-9}, {0, -14, 3}, {0, 5, 4}, 55);
  return all;
}

Scene scene_of(const Row& row) {
  Scene scene = lamp_cluster(row.lamps);
  scene.rig.haze.anisotropy = row.anisotropy;
  scene.rig.haze.reach_m = row.reach_m;
  recompile(scene);
  if (row.furnished) furnish(scene);
  scene.camera = row.camera;
  return scene;
}

PictureNorms norms_of(const RadianceImage& picture, const RadianceImage& reference) {
  return picture_norms(picture.rgb, std::vector<double>(reference.rgb.begin(), reference.rgb.end()));
}

FrameSettings extreme_settings(int width, int height, double tile_error) {
  FrameSettings settings = judged_settings(width, height);
  settings.nodes = 8;
  settings.tile_error = tile_error;
  return settings;
}

TEST_CASE("1,000 equal beams in one tile have 1,000 times the light of one: no list overflows") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const auto cluster = [](int count) {
    Scene scene = lamp_cluster({.apart_m = 0, .apart_deg = 0}, count);
    furnish(scene);
    scene.camera = {"beside", {4, 4, 5}, {0, 5, 5}, 60, 4};
    return scene;
  };
  constexpr int kCount = 1000;  // lavapipe adds up no more than some 1,600 (docs/numerics.md)
  FrameSettings settings = extreme_settings(64, 36, 0);
  const RadianceImage one = draw_new(vulkan.device(), cluster(1), settings);
  const Scene many = cluster(kCount);
  for (const double tile_error : {0.0, FrameSettings{}.tile_error}) {
    settings.tile_error = tile_error;
    const auto frame = make_frame(vulkan.device(), many, settings);
    RadianceImage sum = draw(*frame, many);
    CHECK(must(frame->read_counts()).live_count == kCount);
    for (float& value : sum.rgb) value /= static_cast<float>(kCount);
    const PictureNorms norms = norms_of(sum, one);
    std::fprintf(stderr, "1,000 equal beams, tile error %g: relL2 %.3g\n", tile_error, norms.rel_l2);
    CHECK(norms.rel_l2 < (tile_error > 0 ? 1e-3 : 3e-5));
  }
}

TEST_CASE("extreme cameras and beams: tiles give the picture of beams pixel by pixel, and that is the judge's") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  for (const Row& row : rows()) {
    CAPTURE(row.name);
    const Scene scene = scene_of(row);
    const auto frame = make_frame(vulkan.device(), scene, extreme_settings(kWidth, kHeight, 0));
    const RadianceImage pixels = draw(*frame, scene);
    CHECK(must(frame->read_counts()).live_count == kLamps);
    must(frame->change(extreme_settings(kWidth, kHeight, kTileError)));
    const RadianceImage tiles = draw(*frame, scene);
    CHECK(must(frame->read_counts()).fine_groups[0] > 0);
    const PictureNorms against_pixels = norms_of(tiles, pixels);
    CHECK(against_pixels.nonfinite == 0);
    CHECK(against_pixels.rel_l2 < row.tiles_max);

    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    const JudgeScene judge = judge_scene(scene.rig, walker);
    // Few pixels, in many columns and rows.
    std::vector<std::uint32_t> some;
    for (std::uint32_t p = 0; p < kWidth * kHeight; p += 149) some.push_back(p);
    const JudgedPixels judged =
        judge_pixels(judge, view_of(scene.camera), kWidth, kHeight, some, {.tolerance = 1e-3, .stated_error = false});
    std::vector<float> values;
    for (const std::size_t p : some) {
      for (std::size_t c = 0; c < 3; ++c) values.push_back(pixels.rgb[3 * p + c]);
    }
    const PictureNorms against_judge = picture_norms(values, judged.rgb);
    CHECK(against_judge.nonfinite == 0);
    CHECK(*std::max_element(judged.rgb.begin(), judged.rgb.end()) > 0);
    CHECK(against_judge.rel_l2 < row.judged_max);

    // As drawn, thin beams widened, where a tile is cut by the picture's corner.
    for (const auto& [width, height] : {std::pair{1, 1}, std::pair{63, 37}}) {
      std::vector<RadianceImage> pictures;
      for (const double tile_error : {0.0, kTileError}) {
        FrameSettings settings = extreme_settings(width, height, tile_error);
        settings.widen_thin = true;
        must(frame->change(settings));
        pictures.push_back(draw(*frame, scene));
        CHECK(std::all_of(pictures.back().rgb.begin(), pictures.back().rgb.end(),
                          [](float v) { return std::isfinite(v) && v >= 0; }));
      }
      CHECK(norms_of(pictures[1], pictures[0]).rel_l2 <= row.tiles_max);
    }
    std::fprintf(stderr, "%s: judge %.2g, tiles %.2g\n", row.name, against_judge.rel_l2, against_pixels.rel_l2);
  }
}

TEST_CASE("every mode with all slots at 255 gives a finite picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Scene scene = all_modes_scene();
  std::fill(scene.levels.begin(), scene.levels.end(), std::uint8_t{255});
  FrameSettings settings;
  settings.width = 63;
  settings.height = 37;
  settings.tile_beams = 0;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  for (const std::int64_t dt_ns : {std::int64_t{0}, 40 * kMs, 60'000 * kMs}) {
    frame->step(scene.levels, dt_ns);
    must(frame->draw(view_of(scene.camera), 4));
    const RadianceImage picture = must(frame->read_radiance());
    CHECK(std::all_of(picture.rgb.begin(), picture.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
  }
}

// FOOTLIGHT_RANDOM_PIXELS: how many; default: 100,000,000.
TEST_CASE("random cameras among extreme beams see only finite light") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const char* wanted = std::getenv("FOOTLIGHT_RANDOM_PIXELS");
  const double pixels = wanted != nullptr ? std::atof(wanted) : 1e8;
  const int size = pixels > 1e6 ? 1000 : 100;
  const std::vector<Row> all = rows();
  Random random(1234);
  double drawn = 0;
  for (std::size_t i = 0; drawn < pixels; ++i) {
    const Row& row = all[i % all.size()];
    CAPTURE(row.name);
    // Few beams take less time; with more than 128 live ones the passes of tiles run without further ado.
    Scene scene = lamp_cluster(row.lamps, 24);
    scene.rig.haze.anisotropy = row.anisotropy;
    scene.rig.haze.reach_m = row.reach_m;
    recompile(scene);
    if (row.furnished) furnish(scene);
    FrameSettings settings;
    settings.width = settings.height = size;
    settings.tile_beams = i % 2 == 0 ? 0 : 1000;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const auto number = static_cast<double>(size) * size;
    for (int picture = 0; picture < 4 && drawn < pixels; ++picture, drawn += number) {
      // Near the lens, on the axis, or anywhere.
      const double reach = picture == 0 ? 0.1 : picture == 1 ? 1 : 8;
      const auto near = [&](double middle) { return middle + random.between(-reach, reach); };
      scene.camera = {"c", {near(0), near(0), near(5)}, {near(0), near(3), near(5)}, random.between(0.5, 120), 4};
      if (picture == 3) scene.camera.position_m.x = scene.camera.position_m.z = 0;
      const RadianceImage image = draw(*frame, scene);
      const auto odd =
          std::count_if(image.rgb.begin(), image.rgb.end(), [](float v) { return !std::isfinite(v) || v < 0; });
      CAPTURE(i);
      CHECK(odd == 0);
    }
  }
  std::fprintf(stderr, "%.3g random pixels\n", drawn);
}

TEST_CASE("a picture of 7680 x 4320 is finite, and has the pixels of its middle in a narrow picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Scene scene = scene_of(rows().front());
  FrameSettings settings = judged_settings(7680, 4320);
  for (const double tile_error : {0.0, FrameSettings{}.tile_error}) {
    settings.tile_error = tile_error;
    settings.width = 7680;
    settings.height = 4320;
    scene.camera = rows().front().camera;
    const RadianceImage whole = draw_new(vulkan.device(), scene, settings);
    CHECK(std::all_of(whole.rgb.begin(), whole.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
    settings.width = 192;
    settings.height = 108;
    scene.camera.fov_deg = 2 * std::atan(std::tan(scene.camera.fov_deg * kDegree / 2) / 40) / kDegree;
    const RadianceImage middle = draw_new(vulkan.device(), scene, settings);
    RadianceImage cut{192, 108, {}};
    for (int y = 0; y < 108; ++y) {
      const auto* row = &whole.rgb[3 * (static_cast<std::size_t>(y + 2160 - 54) * 7680 + 3840 - 96)];
      cut.rgb.insert(cut.rgb.end(), row, row + 3 * 192);
    }
    CHECK(norms_of(cut, middle).rel_l2 < (tile_error > 0 ? 1e-3 : 1e-5));
  }
}

}  // namespace
}  // namespace footlight::render
