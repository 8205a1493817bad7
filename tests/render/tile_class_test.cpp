// Beams that are taken together for tiles against the same beams computed pixel by pixel.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "render/beam.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// Every beam pixel by pixel.
RadianceImage general_picture(Frame& frame, const Scene& scene, FrameSettings settings) {
  settings.tile_beams = 0;
  settings.tile_error = 0;
  must(frame.change(settings));
  return draw(frame, scene);
}

// The picture with tiles against the general one.
PictureNorms against_general(Frame& frame, const Scene& scene, FrameSettings settings, const RadianceImage& general,
                             const std::string& what) {
  const double error = settings.tile_error;
  settings.tile_beams = 0;
  must(frame.change(settings));
  const RadianceImage tiles = draw(frame, scene);
  const std::vector<double> reference(general.rgb.begin(), general.rgb.end());
  const PictureNorms norms = picture_norms(tiles.rgb, reference);
  std::fprintf(stderr, "%s, tile error %.1g: relL2 %.3g, p99 %.3g, p99.9 %.3g, max %.3g\n", what.c_str(), error,
               norms.rel_l2, norms.p99, norms.p999, norms.max);
  CHECK(norms.nonfinite == 0);
  const RadianceImage again = draw(frame, scene);
  CHECK(again.rgb == tiles.rgb);
  return norms;
}
PictureNorms against_general(Frame& frame, const Scene& scene, const FrameSettings& settings, const std::string& what) {
  return against_general(frame, scene, settings, general_picture(frame, scene, settings), what);
}

void add_room(Scene& scene) {
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  scene.rig.boxes.push_back({"wall", {-20, 12, 0}, {20, 12.2, 12}, glm::dvec3(0.3)});
}

// Lamps among a floor, a wall, and boxes, some of them nearer than most of the light.
Scene furnished_scene(int count) {
  Scene scene = lamps_scene(21, count);
  const std::vector<std::uint8_t> levels = scene.levels;
  add_room(scene);
  for (int i = 0; i < 5; ++i) {
    scene.rig.boxes.push_back({"box", {-7 + 3 * i, -4 + i, 0}, {-6 + 3 * i, -3 + i, 1 + i}, glm::dvec3(0.3)});
  }
  scene.compile();
  scene.levels = levels;
  return scene;
}

TEST_CASE("beams that are taken together for tiles give the picture of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Case {
    double tile_error;
    double rel_l2_max;  // three times what lavapipe gave, or the bound of strict pictures
  };
  FrameSettings settings = judged_settings(160, 90);
  const std::pair<std::string, Scene> scenes[] = {{"65 lamps", lamps_scene(20, 65)},
                                                  {"300 lamps", lamps_scene(20, 300)},
                                                  {"300 lamps on a stage", furnished_scene(300)}};
  for (const auto& [what, scene] : scenes) {
    const auto frame = make_frame(vulkan.device(), scene, settings);
    const RadianceImage general = general_picture(*frame, scene, settings);
    for (const Case& c : {Case{1e-5, 1e-5}, Case{4e-3, 5e-4}}) {
      settings.tile_error = c.tile_error;
      const PictureNorms norms = against_general(*frame, scene, settings, general, what);
      CHECK(norms.rel_l2 < c.rel_l2_max);
      if (c.tile_error > 1e-4) CHECK(norms.rel_l2 > 0);  // some are taken together
    }
  }
}

TEST_CASE("pictures whose sizes are not whole tiles have every pixel of their tiles") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  struct Size {
    int width;
    int height;
  };
  const Scene scene = lamps_scene(22, 100);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(1, 1));
  for (const Size size : {Size{1, 1}, Size{63, 37}, Size{33, 130}}) {
    FrameSettings settings = judged_settings(size.width, size.height);
    settings.tile_error = FrameSettings{}.tile_error;
    const auto what = fmt::format("{} x {}", size.width, size.height);
    CHECK(against_general(*frame, scene, settings, what).rel_l2 < 1e-3);
  }
}

// Tiles of small pictures turn by many degrees: corners then say little about what is between them.
TEST_CASE("no camera among the beams loses a beam to the corners of tiles") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Random random(24);
  Scene scenes[] = {lamps_scene(25, 300), furnished_scene(300)};
  std::unique_ptr<Frame> frames[2];
  for (int i = 0; i < (footlight::testing::runs_long_tests() ? 32 : 8); ++i) {
    Scene& scene = scenes[i % 2];
    const glm::dvec3 from(random.between(-8, 8), random.between(-8, 8), random.between(0.3, 7));
    const glm::dvec3 to(random.between(-5, 5), random.between(-5, 5), random.between(0, 5));
    scene.camera = {"among", from, to, random.between(20, 110), 4};
    const double reach_m = scene.rig.haze.reach_m;
    if (i % 4 == 1) scene.rig.haze.reach_m = random.between(4, 12);  // lines end there or at a box
    FrameSettings settings = judged_settings(i % 3 == 0 ? 1 : 70, i % 3 == 0 ? 1 : 45);
    settings.tile_error = 1e-5;
    // The haze is that of the rig when a frame was made.
    std::unique_ptr<Frame> other;
    std::unique_ptr<Frame>& frame = i % 4 == 1 ? other : frames[i % 2];
    if (frame == nullptr) frame = make_frame(vulkan.device(), scene, settings);
    const PictureNorms norms = against_general(*frame, scene, settings, fmt::format("camera {}", i));
    CHECK(norms.rel_l2 < 1e-5);
    CHECK(norms.max < 1e-3);
    scene.rig.haze.reach_m = reach_m;
  }
}

// Parallel beams that stand on the middle column of a picture of 5 supertiles across, and nearly fill it.
TEST_CASE("beams that are even about the middle of a tile have the light of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const double fov_deg : {2.2, 2.4, 2.6, 3.0}) {
    Scene scene = lamps_scene(23, 24);
    scene.rig.cameras.front() = {"middle", {0, -14, 3}, {0, 0, 3}, fov_deg, 4};
    scene.camera = scene.rig.cameras.front();
    for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
      fixtures::PatchedFixture& lamp = scene.rig.fixtures[i];
      lamp.type = 1;
      lamp.position_m = {0, -0.6 + 0.05 * static_cast<double>(i), 7};
      lamp.rotation_deg = {0, 0, 0};
    }
    scene.compile();
    for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
      for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, 1);
      scene.set(i, "Zoom", 0);
    }
    FrameSettings settings = judged_settings(320, 180);
    const auto frame = make_frame(vulkan.device(), scene, settings);
    settings.tile_error = FrameSettings{}.tile_error;
    const PictureNorms norms = against_general(*frame, scene, settings, fmt::format("{} degrees", fov_deg));
    CHECK(norms.rel_l2 < 1e-3);
    CHECK(norms.max < 3e-2);
  }
}

// Parallel beams that the camera sees from the side at a small angle: they are smooth over many pixels. Floor: they end
// on it, and the camera looks down on it.
Scene parallel_scene(int count, bool floor) {
  Scene scene = lamps_scene(26, count);
  scene.camera = {"beside", {0, -14, floor ? 6 : 3}, {0, 0, 3}, floor ? 0.6 : 4, 4};
  scene.rig.cameras.front() = scene.camera;
  if (floor) scene.rig.boxes.push_back({"floor", {-20, -20, 2.8}, {20, 20, 3}, glm::dvec3(0.3)});
  Random random(27);
  for (fixtures::PatchedFixture& lamp : scene.rig.fixtures) {
    lamp.type = 1;
    const double side_m = floor ? 0.2 : 0.5;
    lamp.position_m = {random.between(-side_m, side_m), random.between(-side_m, side_m), 7};
    lamp.rotation_deg = {0, 0, 0};
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, 1);
    scene.set(i, "Zoom", 0);
  }
  return scene;
}

// Rows in use of the tables of all supertiles of the last picture.
struct RecordCounts {
  std::uint32_t rims = 0;
  std::uint32_t cuts = 0;
};
RecordCounts record_counts(Frame& frame) {
  RecordCounts counts;
  for (const CoarseRow& supertile : must(frame.read_supertiles())) {
    CHECK(supertile.rims <= frame.resources().picture.rims_max);
    CHECK(supertile.cuts <= frame.resources().picture.cuts_max);
    counts.rims += supertile.rims;
    counts.cuts += supertile.cuts;
  }
  std::fprintf(stderr, "%u rims, %u cuts\n", counts.rims, counts.cuts);
  return counts;
}

TEST_CASE("beams with rims and beams that are cut become records of supertiles") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  for (const bool floor : {false, true}) {
    const Scene scene = parallel_scene(200, floor);
    FrameSettings settings = judged_settings(128, 64);
    const auto frame = make_frame(vulkan.device(), scene, settings);
    settings.tile_error = FrameSettings{}.tile_error;
    const PictureNorms norms = against_general(*frame, scene, settings, floor ? "200 beams on a floor" : "200 beams");
    CHECK(norms.rel_l2 < 1e-3);
    CHECK(norms.max < 3e-2);
    const RecordCounts counts = record_counts(*frame);
    CHECK((floor ? counts.cuts : counts.rims) > 0);
  }
}

TEST_CASE("beams for whose records a supertile has no room have the light of beams computed pixel by pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr int kCount = 1500;  // beams / FL_RIMS_SHARE rows for rims, beams / FL_CUTS_SHARE for cuts
  for (const bool floor : {false, true}) {
    const Scene scene = parallel_scene(kCount, floor);
    FrameSettings settings = judged_settings(64, 64);
    // With shadows 1,500 beams in one place are more rounds of loops than Mesa allows (render/resources.cpp).
    settings.shadows = false;
    const auto frame = make_frame(vulkan.device(), scene, settings);
    settings.tile_error = 2e-2;
    const PictureNorms norms = against_general(*frame, scene, settings, floor ? "cuts" : "rims");
    CHECK(norms.rel_l2 > 0);
    CHECK(norms.rel_l2 < 1e-3);
    CHECK(norms.max < 3e-2);
    const RecordCounts counts = record_counts(*frame);
    CHECK((floor ? counts.cuts >= kCount / FL_CUTS_SHARE : counts.rims >= kCount / FL_RIMS_SHARE));
  }
}

// Share of the beams of all pixels that are computed for the pixel alone.
double general_share(vk::Device& device, const Scene& scene, FrameSettings settings) {
  settings.view = FrameView::kClasses;
  settings.tile_beams = 0;
  const RadianceImage classes = draw_new(device, scene, settings);
  double general = 0, all = 0;
  for (std::size_t i = 0; i < classes.rgb.size(); ++i) {
    all += classes.rgb[i];
    if (i % 3 == 0) general += classes.rgb[i];
  }
  REQUIRE(all > 0);
  return general / all;
}

// The picture with tiles against that without, with a strict tolerance and with the usual one.
void check_both_errors(vk::Device& device, const Scene& scene, FrameSettings settings, const std::string& what,
                       double rel_l2_max = 5e-4, double max_error = 3e-2) {
  const auto frame = make_frame(device, scene, settings);
  const RadianceImage general = general_picture(*frame, scene, settings);
  for (const double error : {1e-5, 4e-3}) {
    settings.tile_error = error;
    const PictureNorms norms = against_general(*frame, scene, settings, general, what);
    CHECK(norms.rel_l2 < (error > 1e-4 ? rel_l2_max : 1e-5));
    CHECK(norms.max < max_error);
  }
}

// Lamps above a floor with posts, before which and behind which beams pass.
Scene posts_scene(int count) {
  Scene scene = lamps_scene(41, count);
  const std::vector<std::uint8_t> levels = scene.levels;
  add_room(scene);
  Random random(42);
  for (int i = 0; i < 80; ++i) {
    const glm::dvec3 foot(random.between(-8, 8), random.between(-4, 10), 0);
    scene.rig.boxes.push_back({"post", foot, foot + glm::dvec3(0.1, 0.1, 7), glm::dvec3(0.3)});
  }
  scene.rig.cameras.front() = {"near", {0, -14, 3}, {0, 0, 3}, 16, 4};
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  scene.levels = levels;
  return scene;
}

TEST_CASE("beams that several surfaces of a tile cut are taken together") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = posts_scene(200);
  FrameSettings settings = judged_settings(320, 180);
  settings.shadows = false;
  check_both_errors(vulkan.device(), scene, settings, "posts");
  settings.tile_error = FrameSettings{}.tile_error;
  const double share = general_share(vulkan.device(), scene, settings);
  std::fprintf(stderr, "posts: %.1f %% pixel by pixel\n", 100 * share);
  CHECK(share < 0.45);
}

// Lamps that shine down beside each other in front of the camera, with a star in each.
Scene gobos_scene(bool turned) {
  Scene scene = gates_scene(1);
  const int slots = scene.rig.types[0].modes[0].slot_count;
  const int per_universe = kSlotCountMax / slots;
  for (int i = 1; i < 40; ++i) {
    fixtures::PatchedFixture lamp = scene.rig.fixtures[0];
    lamp.name = "Lamp " + std::to_string(i + 1);
    lamp.universe = 1 + i / per_universe;
    lamp.address = 1 + i % per_universe * slots;
    scene.rig.fixtures.push_back(lamp);
  }
  Random random(43);
  scene.rig.boxes.clear();
  scene.rig.cameras.front() = {"beside", {0, -14, 3}, {0, 0, 3}, 6, 4};
  scene.camera = scene.rig.cameras.front();
  for (fixtures::PatchedFixture& lamp : scene.rig.fixtures) {
    lamp.position_m = {random.between(-1, 1), random.between(-1, 1), 7};
    lamp.rotation_deg = {turned ? random.between(-20, 20) : 0.0, 0, turned ? random.between(-180, 180) : 0.0};
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    scene.set(i, "Zoom", random.between(6, 24));
    scene.set(i, "Gobo1WheelIndex", 270);
    scene.set(i, "Gobo1Pos", random.between(0, 360));
  }
  return scene;
}

TEST_CASE("beams with gobos whose chords cross the whole disc are taken together") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const bool turned : {false, true}) {
    const Scene scene = gobos_scene(turned);
    FrameSettings settings = judged_settings(128, 72);
    settings.gobo_method = GoboMethod::kTables;
    const std::string what = turned ? "turned gobos" : "gobos";
    check_both_errors(vulkan.device(), scene, settings, what);
    settings.tile_error = FrameSettings{}.tile_error;
    const double share = general_share(vulkan.device(), scene, settings);
    std::fprintf(stderr, "%s: %.1f %% pixel by pixel\n", what.c_str(), 100 * share);
    CHECK(share < 0.8);  // without the others, which a lens cuts, 1
  }
}

TEST_CASE("beams with gobos that are taken together have their shadows, and their light with any number of nodes") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = gobos_scene(false);
  FrameSettings settings = judged_settings(128, 72);
  settings.gobo_method = GoboMethod::kTables;
  settings.nodes = 5;
  check_both_errors(vulkan.device(), scene, settings, "gobos, 5 nodes");
  settings.nodes = 3;
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", 50);  // smooth over tiles
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"roof", {-2, -2, 6}, {-0.2, 2, 6.1}, glm::dvec3(0.3)});  // above the picture
  scene.compile();
  scene.levels = levels;
  // Whole chords by their table, and less of them by sums along lines: 8.2e-4 on lavapipe.
  check_both_errors(vulkan.device(), scene, settings, "gobos with shadows", 2e-3);
}

TEST_CASE("beams nearly across the view go on to the sky beside posts") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = lamps_scene(44, 120);
  const std::vector<std::uint8_t> levels = scene.levels;
  for (fixtures::PatchedFixture& lamp : scene.rig.fixtures) lamp.rotation_deg = {0, 0, 0};
  Random random(45);
  for (int i = 0; i < 30; ++i) {
    const glm::dvec3 foot(random.between(-4, 4), random.between(-4, 10), 0);
    scene.rig.boxes.push_back({"post", foot, foot + glm::dvec3(0.1, 0.1, 7), glm::dvec3(0.3)});
  }
  scene.rig.cameras.front() = {"level", {0, -14, 3}, {0, 0, 3}, 20, 4};
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  scene.levels = levels;
  FrameSettings settings = judged_settings(321, 181);
  settings.shadows = false;
  // A dim pixel in a bright tile: 3.6e-2 on lavapipe.
  check_both_errors(vulkan.device(), scene, settings, "level camera", 5e-4, 5e-2);
}

// Medium and rays of a stage, in double.
TEST_CASE("light at a node is that of eight Gauss nodes, for every profile") {
  Random random(4);
  const f64::Medium medium{0.5, 0.02};
  for (const double power : {0.25, 1.0 / 3, 0.5, 1.0, 2.0, 3.0, 4.0}) {
    double sum = 0;
    double error_3 = 0;
    double error_5 = 0;
    int whole = 0;
    for (int i = 0; i < 20'000; ++i) {
      const f64::BeamShape beam{random.between(0.03, 0.1), std::tan(random.between(1, 20) * kDegree), 30, power};
      const glm::dvec3 eye(random.between(-20, 20), random.between(-20, 20), random.between(-10, 30));
      const double z = random.between(0.5, 29);
      const double radius = beam.lens_radius_m + beam.spread * z;
      const glm::dvec3 to(random.between(-1, 1) * radius, random.between(-1, 1) * radius, z);
      const glm::dvec3 d = glm::normalize(to - eye);
      f64::Chord chord;
      f64::ChordLine line;
      if (!f64::beam_line(beam, eye, d, 0, 1e30, chord, line)) continue;
      const f64::TileNode three = f64::tile_node(beam, medium, chord, line, d, false, true);
      const f64::TileNode five = f64::tile_node(beam, medium, chord, line, d, true, true);
      if (!f64::beam_chord(beam, eye, d, 0, 1e30, chord)) {
        CHECK(five.light == 0);
        continue;
      }
      if (three.is_whole) ++whole;
      const double light = f64::chord_inscatter_gauss(beam, medium, chord, d, 8, true);
      sum += light * light;
      error_3 += (three.light - light) * (three.light - light);
      error_5 += (five.light - light) * (five.light - light);
    }
    std::fprintf(stderr, "m = %.3g, %d whole chords: relL2 %.3g with three nodes, %.3g with five\n", power, whole,
                 std::sqrt(error_3 / sum), std::sqrt(error_5 / sum));
    CHECK(whole > 1000);
    if (power == 1.0) CHECK(std::sqrt(error_3 / sum) < 1e-3);
    CHECK(std::sqrt(error_5 / sum) < 1e-3);
  }
}

// Chords that the lens, the eye or a plane at a random distance cuts, in double.
TEST_CASE("light of a cut chord by moments is that of eight Gauss nodes") {
  Random random(5);
  const f64::Medium medium{0.5, 0.02};
  for (const double power : {1.0, 2.0}) {
    double sum = 0;
    double error = 0;
    int cut = 0;
    for (int i = 0; i < 20'000; ++i) {
      const f64::BeamShape beam{random.between(0.03, 0.1), std::tan(random.between(1, 20) * kDegree), 30, power};
      const glm::dvec3 eye(random.between(-20, 20), random.between(-20, 20), random.between(-10, 30));
      const double z = random.between(0.5, 29);
      const double radius = beam.lens_radius_m + beam.spread * z;
      const glm::dvec3 to(random.between(-1, 1) * radius, random.between(-1, 1) * radius, z);
      const glm::dvec3 d = glm::normalize(to - eye);
      const double end_m = glm::length(to - eye) * random.between(0.9, 1.1);
      f64::Chord chord;
      if (!f64::beam_chord(beam, eye, d, 0, end_m, chord)) continue;
      const double light = f64::chord_inscatter_gauss(beam, medium, chord, d, 8, true);
      f64::ChordLine line;
      if (!f64::beam_line(beam, eye, d, 0, end_m, chord, line)) continue;
      const double c_square = 1 - chord.offset * chord.offset;
      const double c = std::sqrt(c_square);
      if (line.s_a <= -c && line.s_b >= c) continue;
      ++cut;
      const double low = std::max(line.s_a, -c);
      const double high = std::min(line.s_b, c);
      const double middle = 0.5 * (low + high);
      const double half = std::max(0.5 * (high - low), f64::kFitHalfMin);
      double g[3];
      for (int k = 0; k < 3; ++k) {
        const double s = middle + (k - 1) * f64::kFitNode * half;
        g[k] = f64::tile_integrand(beam, medium, chord, line, d, s, 0, true, true) / chord.v_length;
      }
      const double by_moments =
          glm::dot(f64::cut_fit(g[0], g[1], g[2], middle, half), f64::cut_moments(c_square, line.s_a, line.s_b));
      sum += light * light;
      error += (by_moments - light) * (by_moments - light);
    }
    std::fprintf(stderr, "m = %.3g, %d cut chords: relL2 %.3g by moments\n", power, cut, std::sqrt(error / sum));
    CHECK(cut > 1000);
    CHECK(std::sqrt(error / sum) < 1e-3);
  }
}

}  // namespace
}  // namespace footlight::render
