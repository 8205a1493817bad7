// What a frame keeps when its settings change, and the memory that it uses.
#include <cstdint>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "render/quality.h"
#include "render/vk/pipeline.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

FrameSettings sized(int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  return settings;
}

// Objects that are slow to make: models, gobo images and a table.
std::vector<std::uint64_t> slow_parts(Frame& frame) {
  const RigTables& rig = frame.resources().rig;
  return {reinterpret_cast<std::uint64_t>(rig.vertices.handle), reinterpret_cast<std::uint64_t>(rig.gobos.handle),
          reinterpret_cast<std::uint64_t>(rig.heads.handle), reinterpret_cast<std::uint64_t>(rig.states.handle)};
}

TEST_CASE("a frame of another size draws the same as a new frame of that size, and its heads keep their positions") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const Scene scene = demo_scene(70, true);
  const auto old = make_frame(vulkan.device(), scene, sized(96, 54));
  const auto fresh = make_frame(vulkan.device(), scene, sized(64, 36));
  for (Frame* frame : {old.get(), fresh.get()}) {
    frame->step(scene.levels, 300 * kMs);  // motors are moving
    must(frame->draw(view_of(scene.camera), scene.camera.exposure_ev));
  }
  must(old->change(sized(64, 36)));
  must(old->draw(view_of(scene.camera), scene.camera.exposure_ev));
  CHECK(must(old->read_radiance()).rgb == must(fresh->read_radiance()).rgb);
  CHECK(must(old->read_screen()).rgba == must(fresh->read_screen()).rgba);
}

TEST_CASE("a change of size reads no model and no image and compiles nothing") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const Scene scene = demo_scene(71, true);
  const auto frame = make_frame(vulkan.device(), scene, sized(96, 54));
  (void)draw(*frame, scene);
  const auto parts = slow_parts(*frame);
  const std::size_t compiled = vulkan.device().pipelines().compiled();
  for (const auto& [width, height] : {std::pair(64, 36), std::pair(200, 100), std::pair(96, 54)}) {
    must(frame->change(sized(width, height)));
    (void)draw(*frame, scene);
  }
  CHECK(slow_parts(*frame) == parts);
  CHECK(vulkan.device().pipelines().compiled() == compiled);
}

TEST_CASE("two sizes of a picture are never in memory at the same time") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  vk::Device& device = vulkan.device();
  const Scene scene = demo_scene(72, false);
  const auto frame = make_frame(device, scene, sized(640, 360));
  const std::uint64_t small = device.memory_bytes();
  must(frame->change(sized(800, 600)));
  const std::uint64_t large = device.memory_bytes();
  CHECK(large > small + 800 * 600 * 8);
  for (const auto& settings : {sized(640, 360), sized(800, 600), sized(801, 600)}) {
    device.reset_memory_peak();
    must(frame->change(settings));
    CHECK(device.memory_peak_bytes() <= large + 1024 * 1024);  // an image of 800 x 600 has 7.7 MB
  }
}

TEST_CASE("a changed knob compiles its passes once, and nothing when it is restored") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  const Scene scene = demo_scene(73, true);
  FrameSettings settings = sized(64, 36);
  settings.tile_beams = 1;  // the demo has fewer than the passes of tiles are for
  const FrameSettings first = settings;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage before = draw(*frame, scene);
  const auto parts = slow_parts(*frame);
  const vk::Pipelines& pipelines = vulkan.device().pipelines();
  const std::size_t compiled = pipelines.compiled();
  settings.gobo_taps = 23;
  must(frame->change(settings));
  CHECK(pipelines.compiled() == compiled + 1);  // beams
  settings.nodes = 7;
  must(frame->change(settings));
  CHECK(pipelines.compiled() == compiled + 5);  // coarse, fine, shade, beams
  const RadianceImage finer = draw(*frame, scene);
  CHECK(finer.rgb != before.rgb);
  CHECK(finer.rgb == draw_new(vulkan.device(), scene, settings).rgb);
  must(frame->change(first));
  CHECK(pipelines.compiled() == compiled + 5);
  CHECK(draw(*frame, scene).rgb == before.rgb);
  CHECK(slow_parts(*frame) == parts);
}

TEST_CASE("unused pipelines are destroyed when there are many") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  Scene scene;
  scene.rig.boxes.push_back({"floor", {-1, -1, -1}, {1, 1, 0}, glm::dvec3(0.3)});
  scene.rig.cameras.emplace_back();
  scene.compile();
  FrameSettings settings = sized(8, 8);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage before = draw(*frame, scene);
  const vk::Pipelines& pipelines = vulkan.device().pipelines();
  const Scene lit = lamps_scene(74, 1);
  FrameSettings march = judged_settings(8, 8);
  march.method = BeamMethod::kMarch;
  march.nodes = 1999;
  const auto other = make_frame(vulkan.device(), lit, march);
  const std::size_t compiled = pipelines.compiled();
  for (march.nodes = 2000; march.nodes < 2000 + vk::Pipelines::kKeptMax + 2; ++march.nodes) {
    must(other->change(march));
  }
  CHECK(pipelines.compiled() > compiled + vk::Pipelines::kKeptMax);
  CHECK(pipelines.kept() <= vk::Pipelines::kKeptMax);
  CHECK(draw(*frame, scene).rgb == before.rgb);  // the pipeline in use was kept
}

TEST_CASE("turning haze off draws the same rig in clear air, and turning it on restores the picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(75, true);
  Scene clear = scene;
  clear.rig.haze.scattering_per_m = 0;
  clear.compiled = must(fixtures::compile(clear.rig));
  FrameSettings settings = sized(64, 36);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage hazed = draw(*frame, scene);
  settings.haze = false;
  must(frame->change(settings));
  const RadianceImage seen = draw(*frame, scene);
  CHECK(seen.rgb != hazed.rgb);
  CHECK(seen.rgb == draw_new(vulkan.device(), clear, sized(64, 36)).rgb);
  settings.haze = true;
  must(frame->change(settings));
  CHECK(draw(*frame, scene).rgb == hazed.rgb);
}

TEST_CASE("haze that is set between two pictures is drawn as the same haze of a rig, and compiles nothing") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(75, true);
  Scene thick = scene;
  thick.rig.haze.scattering_per_m *= 3;
  const auto frame = make_frame(vulkan.device(), scene, sized(64, 36));
  const RadianceImage before = draw(*frame, scene);
  const auto compiled = vulkan.device().pipelines().compiled();
  frame->set_haze_per_m(thick.rig.haze.scattering_per_m);
  const RadianceImage seen = draw(*frame, scene);
  CHECK(vulkan.device().pipelines().compiled() == compiled);
  CHECK(seen.rgb != before.rgb);
  CHECK(seen.rgb == draw_new(vulkan.device(), thick, sized(64, 36)).rgb);
}

TEST_CASE("a frame that begins rough draws whole pictures as a new one does, and compiles them beside rough ones") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(75, true);
  FrameSettings whole = sized(64, 36);
  whole.edge_samples = 8;
  whole.bounce = true;
  const FrameSettings rough = rough_settings(whole, kRoughBeamsMax + 1);
  CHECK(!rough.shadows);
  CHECK(rough.nodes < whole.nodes);
  CHECK(rough.edge_samples == 0);
  CHECK(!rough.bounce);
  vk::Device& device = vulkan.device();
  const auto frame = must(Frame::create(device, scene.rig, scene.compiled, whole, product_passes(), &rough));
  CHECK(draw(*frame, scene).width == 32);
  frame->compile_ahead(whole);
  must(device.pipelines().finish());
  CHECK(device.pipelines().finished());
  const std::size_t compiled = device.pipelines().compiled();
  must(frame->change(whole));
  CHECK(device.pipelines().compiled() == compiled);
  CHECK(draw(*frame, scene).rgb == draw_new(device, scene, whole).rgb);
}

TEST_CASE("a frame that changes its size without haze draws shadows in haze as a new frame does") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(75, false);
  const auto frame = make_frame(vulkan.device(), scene, sized(64, 36));
  FrameSettings settings = sized(160, 90);
  settings.haze = false;
  must(frame->change(settings));
  (void)draw(*frame, scene);
  settings.haze = true;
  must(frame->change(settings));
  CHECK(draw(*frame, scene).rgb == draw_new(vulkan.device(), scene, sized(160, 90)).rgb);
}

TEST_CASE("refused settings do not change the frame") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(76, false);
  FrameSettings settings = judged_settings();
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const RadianceImage before = draw(*frame, scene);
  settings.bodies = true;
  const Status refused = frame->change(settings);
  REQUIRE(!refused);
  CHECK(refused.error().code == ErrorCode::kBadInput);
  CHECK(!frame->change(judged_settings(0, 10)));
  settings = judged_settings();
  settings.nodes = 9;
  CHECK(!frame->change(settings));
  CHECK(frame->settings().nodes == judged_settings().nodes);
  CHECK(draw(*frame, scene).rgb == before.rgb);
}

TEST_CASE("the planned memory equals the allocated memory") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const Scene& scene : {demo_scene(77, true), time_scene(), optics_scene(true), lamps_scene(77, 300)}) {
    for (FrameSettings settings : {judged_settings(320, 180), judged_settings(64, 64)}) {
      settings.gobo_px = kGoboSizePx;  // as on a CPU
      const auto frame = make_frame(vulkan.device(), scene, settings);
      std::uint64_t planned = 0;
      for (const PassMemory& pass : plan_memory({scene.rig, scene.compiled, scene.compiled.needs, settings})) {
        planned += pass.bytes;
      }
      const std::uint64_t taken = frame->resources().total_bytes;
      CHECK(planned <= taken + 16);
      CHECK(taken <= planned + planned / 50 + 16 * 1024);  // rows of images and buffers are rounded up
    }
  }
}

TEST_CASE("the memory of a pass counts only buffers and images that no earlier pass uses") {
  const Scene scene = demo_scene(78, true);
  FrameSettings settings = sized(640, 360);
  settings.tile_beams = 1;
  const auto bytes_of = [&](const fixtures::Needs& needs, const std::string& name) {
    for (const PassMemory& pass : plan_memory({scene.rig, scene.compiled, needs, settings})) {
      if (pass.name == name) return pass.bytes;
    }
    return std::uint64_t{0};
  };
  const fixtures::Needs needs = scene.compiled.needs;
  constexpr std::uint64_t kPixels = 640 * 360;
  // Identity; depth; depth and triangle in 64 bits; a texel of the rasteriser's depth; parts of large triangles.
  CHECK(bytes_of(needs, "bodies") ==
        kPixels * (8 + 4 + 8) + 4 + sizeof(DrawBlocksHead) + FL_BLOCKS_MAX * sizeof(DrawBlockRow));
  CHECK(bytes_of(needs, "frame") == kPixels * (16 + 4) + sizeof(FrameParams) + sizeof(CountsRow) + 8);
  CHECK(bytes_of(needs, "tonemap") == sizeof(MeterRow));
  CHECK(bytes_of(needs, "tiles") == 4 * 10 * 6 * ((scene.compiled.beams_max + 63) / 64 * 2));
  // Gobo images belong to the first pass that reads them.
  CHECK(bytes_of(needs, "gobos") > scene.compiled.images.size() * (512 * 512 * 4 + 1024 * 256 * 8 + 512 * 64 * 65 * 4));
  CHECK(bytes_of(needs, "beams") == 0);
  fixtures::Needs bladed = needs;
  CHECK(!bladed.blades);
  bladed.blades = true;
  CHECK(bytes_of(bladed, "gather") - bytes_of(needs, "gather") == scene.compiled.beams_max * sizeof(BladesRow));
}

}  // namespace
}  // namespace footlight::render
