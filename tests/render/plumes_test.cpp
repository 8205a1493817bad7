// Plumes of haze machines in pictures, against the judge.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "fixtures/simulate/machines.h"
#include "render/frame_state.h"
#include "render/haze.h"
#include "render/reference/norms.h"
#include "render/reference/plume_judge.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr std::int64_t kSecondNs = 1'000'000'000;

// Three lamps over a fog machine and a hazer, before a wall. Clear air but for what machines make.
Scene foggy_scene(double scattering_per_m) {
  std::string text =
      "[rig]\nname = \"fog\"\nambient_lx = 1\n[haze]\nscattering_per_m = " + std::to_string(scattering_per_m) +
      "\nreach_m = 30\n[room]\nvolume_m3 = 2000\n"
      "[[fixture]]\nname = \"Fog\"\ntype = \"generic/fogger\"\nuniverse = 1\naddress = 1\nposition = [-3, 2, 0.5]\n"
      "aim = [2, 2, 1.5]\n"
      "[[fixture]]\nname = \"Haze\"\ntype = \"generic/hazer\"\nuniverse = 1\naddress = 11\nposition = [3, 3, 0.5]\n"
      "aim = [0, 3, 2]\n"
      "[[box]]\nname = \"wall\"\nmin = [-9, 6, 0]\nmax = [9, 7, 6]\n";
  for (int i = 0; i < 3; ++i) {
    text += "[[fixture]]\nname = \"Par " + std::to_string(i) +
            "\"\ntype = \"generic/par\"\nuniverse = 1\naddress = " + std::to_string(21 + 5 * i) + "\nposition = [" +
            std::to_string(2 * i - 2) + ", 2.5, 5]\naim = [" + std::to_string(2 * i - 2) + ", 2, 0]\n";
  }
  text += "[[camera]]\nname = \"c\"\nposition = [0, -9, 2]\ntarget = [0, 2, 1.5]\nfov_deg = 38\nexposure_ev = 4\n";
  Scene scene;
  scene.rig = must(fixtures::parse_rig(text, "fog.toml"));
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  for (std::size_t i = 2; i < 5; ++i) scene.set(i, "Dimmer", 1);
  return scene;
}

void blow(Scene& scene, double fog, double haze) {
  scene.set(0, "Fog1", fog);
  scene.set(0, "Fan1", 1);
  scene.set(1, "Haze1", haze);
  scene.set(1, "Fan1", 0.5);
}

FrameSettings small(int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.bodies = false;
  settings.widen_thin = false;
  settings.edge_samples = 0;
  settings.shadows = false;
  return settings;
}

RadianceImage picture(Frame& frame, const Scene& scene) {
  must(frame.draw(view_of(scene.camera), 0));
  return must(frame.read_radiance());
}

JudgedImage judged(const Frame& frame, Scene scene, const FrameSettings& settings, std::int64_t time_ns, bool plumes,
                   bool even_extinction = true) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  scene.rig.haze.scattering_per_m += frame.machine_air()->scattering_per_m();
  JudgeScene judge = judge_scene(scene.rig, walker, {}, time_ns);
  judge.solids.clear();
  if (plumes) add_plumes(judge, plume_field(frame.puffs(), scene.rig.haze.scattering_per_m, time_ns));
  judge.even_extinction = even_extinction;
  return judge_image(judge, view_of(scene.camera), settings.width, settings.height,
                     {.tolerance = 1e-4, .stated_error = false});
}

TEST_CASE("plumes of machines in a picture are those that the judge marches through") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const FrameSettings settings = small(32, 18);
  for (const double scattering_per_m : {0.0, 0.01}) {
    Scene scene = foggy_scene(scattering_per_m);
    blow(scene, scattering_per_m > 0 ? 0.4 : 0.04, scattering_per_m > 0 ? 1 : 0.1);
    const auto frame = make_frame(vulkan.device(), scene, settings);
    frame->step(scene.levels, 6 * kSecondNs);
    const RadianceImage drawn = picture(*frame, scene);
    const PictureNorms norms = picture_norms(drawn.rgb, judged(*frame, scene, settings, 6 * kSecondNs, true).rgb);
    const double without = picture_norms(drawn.rgb, judged(*frame, scene, settings, 6 * kSecondNs, false).rgb).rel_l2;
    std::fprintf(stderr, "plumes in %.3g /m: relL2 %.3g, p99 %.3g; without plumes %.3g\n", scattering_per_m,
                 norms.rel_l2, norms.p99, without);
    if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) {
      for (const std::uint32_t nodes : {1u, 8u, 256u}) {
        FrameSettings other = settings;
        other.nodes = nodes;
        if (nodes > 8) other.method = BeamMethod::kMarch;
        must(frame->change(other));
        const PictureNorms at =
            picture_norms(picture(*frame, scene).rgb, judged(*frame, scene, settings, 6 * kSecondNs, true).rgb);
        std::fprintf(stderr, "  with %u nodes: %.3g\n", nodes, at.rel_l2);
      }
      const JudgedImage lossy = judged(*frame, scene, settings, 6 * kSecondNs, true, false);
      std::fprintf(stderr, "  against light that is lost from the lamp, too: %.3g\n",
                   picture_norms(drawn.rgb, lossy.rgb).rel_l2);
    }
    CHECK(norms.nonfinite == 0);
    CHECK(norms.rel_l2 < 1e-2);
    CHECK(without > 0.1);
  }
}

TEST_CASE("a picture with plumes is that of playing in any steps, of a moment gone back to, and of a frame beside") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const FrameSettings settings = small(32, 18);
  Scene scene = foggy_scene(0.005);
  blow(scene, 1, 0.5);
  const auto whole = make_frame(vulkan.device(), scene, settings);
  const auto pieces = make_frame(vulkan.device(), scene, settings);
  whole->step(scene.levels, 2 * kSecondNs);
  for (int i = 0; i < 40; ++i) pieces->step(scene.levels, 50 * kMs);
  const FrameState moment = must(whole->save_state());
  blow(scene, 0, 1);
  whole->step(scene.levels, 3 * kSecondNs);
  for (int i = 0; i < 60; ++i) pieces->step(scene.levels, 50 * kMs);
  const RadianceImage played = picture(*whole, scene);
  CHECK(picture(*pieces, scene).rgb == played.rgb);
  const auto beside = must(Frame::create_beside(*whole, settings));
  beside->follow(*whole);
  CHECK(picture(*beside, scene).rgb == played.rgb);
  whole->step(scene.levels, 9 * kSecondNs);
  CHECK(picture(*whole, scene).rgb != played.rgb);
  must(whole->load_state(moment));
  whole->step(scene.levels, 3 * kSecondNs);
  CHECK(picture(*whole, scene).rgb == played.rgb);
}

TEST_CASE("a moment's bytes count the plumes that it holds") {
  FrameState clear;
  FrameState foggy;
  foggy.air.plumes.resize(16);
  CHECK(foggy.bytes() - clear.bytes() == 16 * sizeof(fixtures::Plume));
}

TEST_CASE("a plume below a floor that mirrors takes no light from what the floor shows") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = foggy_scene(0.01);
  scene.rig.boxes.push_back({"floor", {-14, -14, -0.3}, {14, 14, 0}, glm::dvec3(0.02), {1, 0}});
  scene.compile();
  for (std::size_t i = 2; i < 5; ++i) scene.set(i, "Dimmer", 1);
  const auto frame = make_frame(vulkan.device(), scene, small(32, 18));
  const auto with_puff = [&](const glm::dvec3& center_m) {
    frame->set_puffs({{.center_m = center_m, .axis = {1, 0, 0}, .across_m = 0.3, .along_m = 1, .area_m2 = 4}});
    return picture(*frame, scene);
  };
  // Behind both cameras, and 5 m before the mirrored one, which stands 2 m below the floor.
  const RadianceImage away = with_puff({0, -60, -1.4});
  const RadianceImage below = with_puff({0, -4, -1.4});
  const RadianceImage above = with_puff({0, -4, 1.4});
  const std::vector<double> expected(away.rgb.begin(), away.rgb.end());
  const double hidden = picture_norms(below.rgb, expected).rel_l2;
  const double seen = picture_norms(above.rgb, expected).rel_l2;
  std::fprintf(stderr, "a puff below the floor: relL2 %.3g; above it %.3g\n", hidden, seen);
  CHECK(hidden < 1e-4);
  CHECK(seen > 0.01);
}

TEST_CASE(
    "without a machine that is open, a picture with plumes is that of even haze, and a rig without has no table") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const FrameSettings settings = small(32, 18);
  Scene scene = foggy_scene(0.01);
  const auto frame = make_frame(vulkan.device(), scene, settings);
  frame->step(scene.levels, 2 * kSecondNs);
  const RadianceImage closed = picture(*frame, scene);
  Scene plain = scene;
  plain.rig.room.plumes = false;
  plain.compile();
  plain.levels = scene.levels;
  const auto even = make_frame(vulkan.device(), plain, settings);
  even->step(plain.levels, 2 * kSecondNs);
  const RadianceImage reference = picture(*even, plain);
  const std::vector<double> expected(reference.rgb.begin(), reference.rgb.end());
  CHECK(picture_norms(closed.rgb, expected).rel_l2 < 1e-3);  // two rules of quadrature
  for (const PassPlan& pass : even->plan()) CHECK(pass.name != "haze");
  CHECK(frame->bytes() - even->bytes() > 36'000'000);
}

}  // namespace
}  // namespace footlight::render
