// The light of a picture is the mean over its exposure, however the exposure is divided into steps.
#include <cmath>
#include <cstdio>

#include "fixtures/simulate/encode.h"
#include "fixtures/simulate/walker.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

// The share of from_ns to from_ns + dt_ns during which a shutter that opens at 0 s is open, by sampling.
double open_share(double rate_hz, double duty, std::int64_t from_ns, std::int64_t dt_ns) {
  constexpr int kLooks = 20'000;
  int open = 0;
  for (int i = 0; i < kLooks; ++i) {
    const double at_ns = static_cast<double>(from_ns) + (i + 0.5) / kLooks * static_cast<double>(dt_ns);
    const double turns = rate_hz * 1e-9 * at_ns;
    open += turns - std::floor(turns) < duty;
  }
  return static_cast<double>(open) / kLooks;
}

TEST_CASE("a picture over 20 ms of two snapshots is the mean of both pictures, weighted by time") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene first = lamps_scene(30, 20);
  Scene second = first;
  for (std::size_t i = 0; i < second.rig.fixtures.size(); ++i) {
    second.set(i, "Dimmer", i % 3 == 0 ? 0.0 : 0.4);
  }
  const View view = view_of(first.camera);
  const auto frame = make_frame(vulkan.device(), first, judged_settings(40, 24));
  const RadianceImage a = draw(*frame, first);
  const RadianceImage b = draw(*frame, second);
  frame->step(first.levels, 5 * kMs, true);
  frame->step(second.levels, 9 * kMs, false);
  frame->step(second.levels, 6 * kMs, false);
  must(frame->draw(view, 0));
  const RadianceImage mean = must(frame->read_radiance());
  std::vector<double> expected;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    expected.push_back(0.25 * static_cast<double>(a.rgb[i]) + 0.75 * static_cast<double>(b.rgb[i]));
  }
  const PictureNorms norms = picture_norms(mean.rgb, expected);
  std::fprintf(stderr, "mean over two looks: max %.3g\n", norms.max);
  CHECK(norms.max < 5e-6);
  // A picture without a new step shows the same light. A new exposure clears it.
  must(frame->draw(view, 0));
  CHECK(must(frame->read_radiance()).rgb == mean.rgb);
  frame->step(second.levels, 3 * kMs, true);
  must(frame->draw(view, 0));
  CHECK(must(frame->read_radiance()).rgb == b.rgb);
}

TEST_CASE("pictures of another view leave the automatic exposure, whose time goes on with the next own one") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_scene(30, 20);
  Scene dim = scene;
  for (std::size_t i = 0; i < dim.rig.fixtures.size(); ++i) dim.set(i, "Dimmer", 0.1);
  FrameSettings settings = judged_settings(40, 24);
  settings.auto_exposure = true;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const View view = view_of(scene.camera);
  const auto draw_as = [&](bool adapts) {
    must(vulkan.device().run_once([&](VkCommandBuffer commands) { frame->record(commands, view, 0, adapts); }));
    return must(frame->read_exposure_ev());
  };
  frame->step(scene.levels, 20 * kMs);
  const double bright_ev = draw_as(true);
  frame->step(dim.levels, 20 * kMs);
  frame->adapt_for(500 * kMs);
  CHECK(draw_as(false) == bright_ev);
  CHECK(draw_as(false) == bright_ev);
  const double half_ev = draw_as(true);
  CHECK(half_ev < bright_ev);
  CHECK(draw_as(true) == doctest::Approx(half_ev));  // no time has passed
}

TEST_CASE("pictures over 20 ms of a strobe at 12 Hz have the share of light that fine sampling gives, for any steps") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = all_modes_scene();
  std::size_t par = 0;
  while (scene.rig.types[static_cast<std::size_t>(scene.rig.fixtures[par].type)].id != "generic/par") ++par;
  scene.set(par, "Dimmer", 1);
  scene.set(par, "Shutter1Strobe", 12);
  fixtures::f64::Walker walker(scene.compiled);
  const fixtures::HeadRow& row = scene.compiled.heads[par];
  const fixtures::LightRow& light = scene.compiled.lights[scene.compiled.types[row.type].light];
  const double rate_hz = walker.decoded(scene.levels, par).value[fixtures::kParamStrobeHz];
  REQUIRE(std::abs(rate_hz - 12) < 0.1);  // as exactly as 8 bits allow

  const auto whole = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  const auto pieces = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  constexpr std::int64_t kExposureNs = 20 * kMs;
  double worst = 0;
  double worst_cut = 0;
  double darkest = 1;
  double brightest = 0;
  for (std::int64_t picture = 0; picture < 50; ++picture) {
    whole->step(scene.levels, kExposureNs, true);
    pieces->step(scene.levels, 7 * kMs, true);
    pieces->step(scene.levels, 1, false);
    pieces->step(scene.levels, 0, false);
    pieces->step(scene.levels, 13 * kMs - 1, false);
    must(whole->run_steps());
    must(pieces->run_steps());
    const auto a = must(whole->read_states())[par];
    const auto b = must(pieces->read_states())[par];
    const double expected =
        open_share(rate_hz, static_cast<double>(light.strobe_duty), picture * kExposureNs, kExposureNs);
    worst = std::max(worst, std::abs(static_cast<double>(a.red) - expected));
    worst_cut = std::max(worst_cut, std::abs(static_cast<double>(a.red) - static_cast<double>(b.red)));
    darkest = std::min(darkest, expected);
    brightest = std::max(brightest, expected);
    // Phases are rounded to 2^-64 turn at each step.
    CHECK(std::abs(footlight::f64::turns_way(must(whole->read_shutters())[row.strobe].phase,
                                             must(pieces->read_shutters())[row.strobe].phase)) < 1e-15);
  }
  std::fprintf(stderr, "strobe: %.3g from looking, %.3g between cuts\n", worst, worst_cut);
  CHECK(darkest < 0.1);  // open, closed and half open pictures all occur
  CHECK(brightest > 0.9);
  CHECK(worst < 2e-4);  // 20,000 samples place an edge to 5e-5, and there are up to two
  CHECK(worst_cut < 5e-6);
}

}  // namespace
}  // namespace footlight::render
