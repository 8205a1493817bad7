// Rivals of the report: where they converge they converge to the judge, and where they lose light they lose it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

#include "render/passes/surfaces.h"
#include "render/reference/norms.h"
#include "render/rivals/clusters.h"
#include "render/rivals/rivals.h"
#include "render/vk/demands.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 48;
constexpr int kHeight = 27;

const Rival& rival_named(std::string_view method) {
  for (const Rival& rival : rivals()) {
    if (rival.method == method) return rival;
  }
  FAIL("no rival " << method);
  return rivals().front();
}

RadianceImage draw_passes(vk::Device& device, const Scene& scene, const FrameSettings& settings,
                          const PassList& passes) {
  const auto frame = must(Frame::create(device, scene.rig, scene.compiled, settings, passes));
  RadianceImage image = draw(*frame, scene);
  CHECK(draw(*frame, scene).rgb == image.rgb);
  return image;
}

RadianceImage draw_rival(vk::Device& device, const Scene& scene, std::string_view method, double knob,
                         int width = kWidth, int height = kHeight) {
  const Rival& rival = rival_named(method);
  return draw_passes(device, scene, rival.settings(judged_settings(width, height), knob), rival.passes());
}

// Lamps over a floor and before a wall. narrow: of every width, lasers among them; else of 15 to 60 degrees.
Scene stage_scene(int count, bool narrow) {
  Scene scene = lamps_scene(31, count);
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  scene.rig.boxes.push_back({"wall", {-20, 12, 0}, {20, 12.2, 12}, glm::dvec3(0.3)});
  scene.compile();
  scene.levels = levels;
  Random random(32);
  for (std::size_t i = 0; i < scene.rig.fixtures.size() && !narrow; ++i) scene.set(i, "Zoom", random.between(15, 60));
  return scene;
}

// One lamp 5 m up that shines along +Y, seen from the side.
Scene one_beam_scene(double full_angle_deg, int type = 1) {
  Scene scene = lamps_scene(1, 1);
  fixtures::PatchedFixture& lamp = scene.rig.fixtures.front();
  lamp.type = type;
  lamp.position_m = {0, 0, 5};
  lamp.rotation_deg = {90, 0, 0};
  scene.rig.cameras = {{"side", {12, 6, 6}, {0, 6, 5}, 60, 8}};
  scene.compile();
  for (const char* channel : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(0, channel, 1);
  scene.set(0, "Zoom", full_angle_deg);
  return scene;
}

// shadows: only shadow maps have any.
std::vector<double> judged_values(const Scene& scene, bool shadows = false) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeScene judge = judge_scene(scene.rig, walker);
  if (!shadows) judge.solids.clear();
  return judge_image(judge, view_of(scene.camera), kWidth, kHeight, {.tolerance = 1e-5, .stated_error = false}).rgb;
}

double error_of(const RadianceImage& image, const std::vector<double>& judged, std::string_view method, double knob) {
  const PictureNorms norms = picture_norms(image.rgb, judged);
  std::fprintf(stderr, "%.*s %g: relL2 %.3g\n", static_cast<int>(method.size()), method.data(), knob, norms.rel_l2);
  CHECK(norms.nonfinite == 0);
  return norms.rel_l2;
}

double difference(const RadianceImage& a, const RadianceImage& b) {
  return picture_norms(a.rgb, std::vector<double>(b.rgb.begin(), b.rgb.end())).rel_l2;
}

double sum_of(const RadianceImage& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum;
}

TEST_CASE("the passes of rivals stay within the descriptors that a device must have") {
  for (const Rival& rival : rivals()) {
    INFO(rival.method);
    CHECK(!rival.knobs.empty());
    CHECK(!rival.quick_knobs.empty());
    for (const PassEntry* pass : rival.passes()) {
      for (const auto& stages : pass->shaders()) {
        const vk::ShaderInterface shader = must(vk::read_interfaces(stages));
        CHECK(vk::count_of(shader, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) <= vk::kStorageBuffersMax);
        CHECK(vk::count_of(shader, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE) <= vk::kStorageImagesMax);
        CHECK(vk::count_of(shader, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) <= vk::kSamplersMax);
      }
    }
  }
}

TEST_CASE("no rival is among the passes of the product, and each replaces passes of its own kind only") {
  const PassList& product = product_passes();
  for (const Rival& rival : rivals()) {
    INFO(rival.method);
    int strange = 0;
    for (const PassEntry* pass : rival.passes()) {
      if (std::find(product.begin(), product.end(), pass) != product.end()) continue;
      ++strange;
      CHECK(std::string_view(pass->loss) == (rival.on_surfaces ? "light on surfaces" : "light in the haze"));
    }
    CHECK(strange == 1);
    CHECK(rival.passes().size() == product.size() - (rival.on_surfaces || rival.of_panes ? 0 : 7));
  }
}

TEST_CASE("rivals that sample light converge to the judge in wide beams") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene stage = stage_scene(12, false);
  const std::vector<double> judged_stage = judged_values(stage);
  // Without the lens, whose light no slice is thin enough for.
  Scene beam = one_beam_scene(50);
  beam.camera = {"away", {12, 14, 6}, {0, 14, 5}, 30, 8};
  const std::vector<double> judged_beam = judged_values(beam);
  struct Case {
    const char* method;
    std::vector<double> knobs;
    double last_max;  // of relL2 at the last knob: three times what lavapipe gave
    bool one_beam = false;
  };
  for (const Case& c :
       {Case{"march whole ray", {16, 64, 256}, 2.1e-2}, Case{"equi-angular", {4, 32, 128}, 4.5e-4},
        Case{"equi-angular middles", {4, 32, 128}, 3.1e-5}, Case{"equi-angular whole ray", {16, 256}, 3.2e-3},
        Case{"froxels", {20, 60, 180}, 5.2e-3, true}, Case{"froxels, 8 samples", {20, 60}, 3.5e-2, true}}) {
    const Scene& scene = c.one_beam ? beam : stage;
    const std::vector<double>& judged = c.one_beam ? judged_beam : judged_stage;
    double before = 1e9;
    for (const double knob : c.knobs) {
      const double error = error_of(draw_rival(vulkan.device(), scene, c.method, knob), judged, c.method, knob);
      CHECK(error < before);
      before = error;
    }
    CHECK(before < c.last_max);
  }
}

TEST_CASE("shadow maps come nearer to the judge with more texels, and stay behind exact shadows") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_beam_scene(40);
  for (int i = 0; i < 4; ++i) {
    const double x = -0.9 + 0.5 * i;
    scene.rig.boxes.push_back({"bar", {x, 2 + 0.4 * i, 3}, {x + 0.12, 2.1 + 0.4 * i, 7}, glm::dvec3(0.3)});
  }
  scene.camera = {"away", {9, 9, 6}, {0, 8, 5}, 40, 8};  // without the lens, which is far brighter
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.compile();
  scene.levels = levels;
  const std::vector<double> judged = judged_values(scene, true);
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.nodes = 4;
  const double exact = error_of(draw_passes(vulkan.device(), scene, settings, product_passes()), judged, "exact", 4);
  settings.shadows = false;
  const double none = error_of(draw_passes(vulkan.device(), scene, settings, product_passes()), judged, "none", 4);
  const auto error = [&](const char* method) {
    return error_of(draw_rival(vulkan.device(), scene, method, 256), judged, method, 256);
  };
  const double small = error("shadow maps 256");
  const double large = error("shadow maps 1024");
  CHECK(none > 0.03);
  CHECK(small < 0.3 * none);
  CHECK(large < small);
  CHECK(exact < 0.1 * large);
}

TEST_CASE("samples outside of beams miss narrow ones, and samples inside do not") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = stage_scene(24, true);
  const std::vector<double> judged = judged_values(scene);
  const auto error = [&](const char* method, double knob) {
    return error_of(draw_rival(vulkan.device(), scene, method, knob), judged, method, knob);
  };
  CHECK(error("equi-angular middles", 32) < 1e-3);
  CHECK(error("march whole ray", 64) > 0.1);
  CHECK(error("equi-angular whole ray", 32) > 0.1);
  CHECK(error("froxels", 80) > 0.1);
}

TEST_CASE("light in the haze is zero in a frame whose passes have none, and rivals add to it only") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = stage_scene(24, true);
  const RadianceImage without =
      draw_passes(vulkan.device(), scene, judged_settings(kWidth, kHeight), passes_with_air({}));
  CHECK(sum_of(without) > 0);
  for (const Rival& rival : rivals()) {
    if (rival.on_surfaces || rival.of_panes) continue;
    INFO(rival.method);
    const RadianceImage with = draw_rival(vulkan.device(), scene, rival.method, rival.knobs.front());
    std::size_t less = 0;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < with.rgb.size(); ++i) {
      if (!std::isfinite(with.rgb[i])) ++wrong;
      if (!(with.rgb[i] >= without.rgb[i])) ++less;
    }
    CHECK(wrong == 0);
    CHECK(less == 0);
    CHECK(sum_of(with) > sum_of(without));
  }
}

TEST_CASE("cone meshes and cards shine where the beam is and nowhere else") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr int kWide = 96;
  constexpr int kHigh = 54;
  for (const double angle_deg : {4.0, 20.0, 50.0}) {
    const Scene scene = one_beam_scene(angle_deg);
    const RadianceImage beam = draw_new(vulkan.device(), scene, judged_settings(kWide, kHigh));
    const auto lit = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < kWide && y < kHigh && beam.rgb[3 * static_cast<std::size_t>(y * kWide + x)] > 0;
    };
    for (const char* method : {"cone mesh", "beam card"}) {
      INFO(method << ", " << angle_deg << " degrees");
      const RadianceImage drawn = draw_rival(vulkan.device(), scene, method, 1, kWide, kHigh);
      int inside = 0, both = 0, outside = 0;
      for (int y = 0; y < kHigh; ++y) {
        for (int x = 0; x < kWide; ++x) {
          const bool shines = drawn.rgb[3 * static_cast<std::size_t>(y * kWide + x)] > 0;
          bool near = false;
          for (int i = -1; i <= 1; ++i) {
            for (int j = -1; j <= 1; ++j) near = near || lit(x + i, y + j);
          }
          inside += lit(x, y) ? 1 : 0;
          both += lit(x, y) && shines ? 1 : 0;
          outside += !near && shines ? 1 : 0;
        }
      }
      CHECK(inside > 20);
      CHECK(outside == 0);
      CHECK(both * 2 > inside);  // walls and cards are dark before their ends
    }
  }
}

TEST_CASE("a camera on the axis of a beam sees finite cone meshes and cards") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = one_beam_scene(20);
  scene.camera = {"axis", {0, 9, 5}, {0, 0, 5}, 60, 8};
  for (const char* method : {"cone mesh", "beam card"}) {
    INFO(method);
    const RadianceImage drawn = draw_rival(vulkan.device(), scene, method, 1);
    CHECK(std::all_of(drawn.rgb.begin(), drawn.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
  }
}

TEST_CASE("clusters that lose nothing have the light of a loop over all beams") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const int count : {24, 300}) {
    const Scene scene = stage_scene(count, true);
    const RadianceImage direct = draw_new(vulkan.device(), scene, judged_settings(kWidth, kHeight));
    CHECK(difference(draw_rival(vulkan.device(), scene, "clusters", 1024), direct) < 1e-6);
  }
}

TEST_CASE("clusters as published lose lights beyond their 127th, and beams that fit between the faces of a slab") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto light_of = [&](const Scene& scene, const PassEntry& surfaces) {
    PassList passes = passes_with_air({});
    std::replace(passes.begin(), passes.end(), &kSurfacesPass, &surfaces);
    return sum_of(draw_passes(vulkan.device(), scene, judged_settings(kWidth, kHeight), passes));
  };
  const Scene few = stage_scene(24, true);
  CHECK(light_of(few, kClustersLossyPass) <= light_of(few, kClustersPass));
  const Scene many = stage_scene(300, true);
  CHECK(light_of(many, kClustersLossyPass) < 0.8 * light_of(many, kClustersPass));
  // A thin beam straight along Y inside a slab of X: slabs are 0.195 m wide and begin at the camera.
  Scene thin = one_beam_scene(0.02, 0);
  thin.rig.boxes.push_back({"wall", {-20, 12, 0}, {20, 12.2, 12}, glm::dvec3(0.3)});
  thin.rig.cameras = {{"front", {0.1, 4, 5}, {0.1, 12, 5}, 3, 4}};
  thin.compile();
  for (const char* channel : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) thin.set(0, channel, 1);
  thin.set(0, "Zoom", 0.02);
  CHECK(light_of(thin, kClustersPass) > 0);
  CHECK(light_of(thin, kClustersLossyPass) == 0);
}

}  // namespace
}  // namespace footlight::render
