// The error that is measured while a picture is shown: against the whole picture by the general path, and the judge.
#include <cmath>
#include <cstdio>
#include <set>

#include "fixtures/simulate/walker.h"
#include "render/live_error.h"
#include "render/quality.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/long_tests.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

RecheckRow row_of(float weight, float shown, float general) {
  RecheckRow row{};
  row.weight = weight;
  row.shown = vec4(shown);
  row.general = vec4(general);
  return row;
}

TEST_CASE("an error of one in a hundred in every sample is one per cent without an interval") {
  ErrorWindow window;
  CHECK(window.estimate().samples == 0);
  window.add(0, std::vector<RecheckRow>{row_of(1, 1.01f, 1), row_of(7, 20.2f, 20), row_of(0, 9, 1)});
  const auto estimate = window.estimate();
  CHECK(estimate.samples == 2);  // a weight of 0 is no sample
  CHECK(estimate.rel_l2 == doctest::Approx(0.01).epsilon(1e-4));
  CHECK(estimate.low == doctest::Approx(estimate.rel_l2).epsilon(1e-3));
  CHECK(estimate.high == doctest::Approx(estimate.rel_l2).epsilon(1e-3));
}

TEST_CASE("a weight counts as so many samples, and samples of more than a second ago do not count") {
  ErrorWindow window;
  window.add(0, std::vector<RecheckRow>{row_of(3, 2, 1)});
  window.add(500 * kNsPerMs, std::vector<RecheckRow>{row_of(1, 1, 1)});
  CHECK(window.estimate().rel_l2 == doctest::Approx(std::sqrt(3.0 / 4)));
  CHECK(window.estimate().low < window.estimate().rel_l2);
  CHECK(window.estimate().high > window.estimate().rel_l2);
  window.add(1200 * kNsPerMs, std::vector<RecheckRow>{row_of(1, 1, 1)});
  CHECK(window.estimate().rel_l2 == 0);
  CHECK(window.estimate().samples == 2);
}

TEST_CASE("where a second has too few samples, those before it count as well") {
  ErrorWindow window(2);
  window.add(0, std::vector<RecheckRow>{row_of(1, 2, 1)});
  window.add(5 * kNsPerS, std::vector<RecheckRow>{row_of(1, 1, 1)});
  CHECK(window.estimate().samples == 2);
  window.add(10 * kNsPerS, std::vector<RecheckRow>{row_of(1, 1, 1)});
  CHECK(window.estimate().samples == 2);
  CHECK(window.estimate().rel_l2 == 0);
}

TEST_CASE("values that are not finite count as black in the picture, and dark pictures have no error") {
  ErrorWindow window;
  window.add(0, std::vector<RecheckRow>{row_of(1, std::nanf(""), 1)});
  CHECK(window.estimate().rel_l2 == doctest::Approx(1));
  ErrorWindow dark;
  dark.add(0, std::vector<RecheckRow>{row_of(1, 0, 0)});
  CHECK(dark.estimate().rel_l2 == 0);
}

// Lamps over a floor: without anything solid a frame has no tables of what pixels show.
Scene lamps_and_floor(int count) {
  Scene scene = lamps_scene(21, count);
  const std::vector<std::uint8_t> levels = scene.levels;
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  scene.compile();
  scene.levels = levels;
  return scene;
}

// The samples of `times` measurements of the frame's picture as it is.
ErrorWindow::Estimate live_error(vk::Device& device, Frame& frame, const Scene& scene, int times) {
  const auto live = must(LiveError::create(device, frame, scene.compiled.needs));
  REQUIRE(live);
  (void)draw(frame, scene);
  std::set<std::pair<std::uint32_t, std::uint32_t>> places;
  for (int i = 0; i < times; ++i) {
    must(device.run_once([&](VkCommandBuffer commands) { live->record(commands); }));
    must(live->take(i));
    for (const RecheckRow& row : live->rows()) places.insert({row.x, row.y});
  }
  if (times > 1) CHECK(places.size() > live->rows().size());  // other pixels each time
  CHECK(live->gpu_ms() > 0);
  const auto estimate = live->estimate();
  // Pixels with edges do not count.
  const std::size_t all = static_cast<std::size_t>(times) * live->rows().size();
  CHECK(estimate.samples <= all);
  CHECK(estimate.samples > all / 4);  // bright pixels are chosen, and half of these have edges in a small picture
  return estimate;
}

// Of all pixels, against the general path.
double whole_error(Frame& frame, const Scene& scene) {
  const FrameSettings own = frame.settings();
  const RadianceImage picture = draw(frame, scene);
  FrameSettings general_path = general_settings(own);
  general_path.body_error_px = own.body_error_px;  // what a pixel shows is the same
  must(frame.change(general_path));
  const RadianceImage general = draw(frame, scene);
  must(frame.change(own));
  (void)draw(frame, scene);
  return picture_norms(picture.rgb, std::vector<double>(general.rgb.begin(), general.rgb.end())).rel_l2;
}

TEST_CASE("samples by the general path equal the frame that is drawn by it, bodies, lenses and gobos included") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const bool gobos : {false, true}) {
    const Scene scene = demo_scene(3, gobos);
    FrameSettings settings;
    settings.width = 96;
    settings.height = 54;
    const auto frame = make_frame(vulkan.device(), scene, general_settings(settings));
    (void)draw(*frame, scene);
    const auto estimate = live_error(vulkan.device(), *frame, scene, 8);
    std::fprintf(stderr, "live error of the general path%s: %.2g\n", gobos ? ", gobos" : "", estimate.rel_l2);
    CHECK(estimate.rel_l2 < 2e-5);  // float: sums in another order
  }
}

TEST_CASE("the live error is that of the whole picture, within its interval") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !footlight::testing::runs_long_tests()) return;
  struct Case {
    const char* what;
    Scene scene;
    FrameSettings settings;
  };
  std::vector<Case> cases;
  FrameSettings settings;
  settings.width = 96;
  settings.height = 54;
  settings.nodes = 2;
  settings.gobo_method = GoboMethod::kTaps;
  settings.gobo_taps = 32;
  cases.push_back({"gobos of 32 samples", demo_scene(3, true), settings});
  settings.bodies = false;
  settings.tile_beams = 0;
  settings.tile_error = 0.1;
  settings.nodes = 4;
  cases.push_back({"tiles", lamps_and_floor(70), settings});
  for (const Case& c : cases) {
    const auto frame = make_frame(vulkan.device(), c.scene, c.settings);
    const double whole = whole_error(*frame, c.scene);
    const auto estimate = live_error(vulkan.device(), *frame, c.scene, 48);
    std::fprintf(stderr, "live error, %s: %.3g (%.3g to %.3g), all pixels %.3g\n", c.what, estimate.rel_l2,
                 estimate.low, estimate.high, whole);
    CHECK(estimate.rel_l2 > 0.75 * whole);
    CHECK(estimate.rel_l2 < 1.33 * whole);
    CHECK(estimate.low < 1.1 * whole);
    CHECK(estimate.high > 0.9 * whole);
    CHECK(estimate.high < 3 * estimate.low);
  }
}

TEST_CASE("the live error grows with the error that tiles may have") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_and_floor(150);
  FrameSettings settings = judged_settings(128, 72);
  settings.tile_beams = 0;
  settings.nodes = 6;
  settings.tile_error = 1e-5;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const double small = live_error(vulkan.device(), *frame, scene, 48).rel_l2;
  settings.tile_error = 0.5;
  must(frame->change(settings));
  const double large = live_error(vulkan.device(), *frame, scene, 48).rel_l2;
  std::fprintf(stderr, "live error, tile error 1e-5: %.3g, 0.5: %.3g\n", small, large);
  CHECK(large > 2 * small);
}

TEST_CASE("the live error is about that against the judge, as in the report") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_and_floor(70);
  FrameSettings settings = judged_settings(64, 36);
  settings.nodes = 2;
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const auto judged = judge_image(judge_scene(scene.rig, walker), view_of(scene.camera), settings.width,
                                  settings.height, {.stated_error = false});
  const auto frame = make_frame(vulkan.device(), scene, settings);
  const double against_judge = picture_norms(draw(*frame, scene).rgb, judged.rgb).rel_l2;
  const auto estimate = live_error(vulkan.device(), *frame, scene, 48);
  std::fprintf(stderr, "live error: %.3g (%.3g to %.3g), judge %.3g\n", estimate.rel_l2, estimate.low, estimate.high,
               against_judge);
  CHECK(estimate.low < 1.1 * against_judge);
  CHECK(estimate.high > 0.9 * against_judge);
  CHECK(estimate.rel_l2 == doctest::Approx(against_judge).epsilon(0.4));
}

}  // namespace
}  // namespace footlight::render
