// What the camera makes of the light: white balance, tone curves, automatic exposure.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "fixtures/model/color.h"
#include "render/beam.h"
#include "render/display.h"
#include "render/passes/tonemap.h"
#include "tests/render/given_pass.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 70;
constexpr int kHeight = 37;
constexpr double kEv = 4;

// A camera before a given picture.
class Camera {
 public:
  explicit Camera(vk::Device& device) {
    rig_.boxes.push_back({"box", {-1, -1, -1}, {1, 1, 0}, {0.5, 0.5, 0.5}});
    compiled_ = must(fixtures::compile(rig_));
    settings.width = kWidth;
    settings.height = kHeight;
    settings.edge_samples = 0;
    settings.glare = 0;
    frame = must(Frame::create(device, rig_, compiled_, settings, {&kGivenPass, &kTonemapPass}));
  }
  ScreenImage see(const RadianceImage& light) {
    give(light);
    must(frame->change(settings));
    must(frame->draw(view_of({"c", {0, -5, 2}, {0, 0, 2}, 40, 4}), kEv));
    return must(frame->read_screen());
  }
  FrameSettings settings;
  std::unique_ptr<Frame> frame;

 private:
  fixtures::Rig rig_;
  fixtures::CompiledRig compiled_;
};

RadianceImage filled(const glm::dvec3& rgb) {
  RadianceImage image{kWidth, kHeight, {}};
  for (int i = 0; i < kWidth * kHeight; ++i) {
    for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<float>(rgb[c]));
  }
  return image;
}
// Colours of every kind, from 1e-4 to 1e6 cd/m^2, and black.
RadianceImage colours(std::uint32_t seed, double scale = 1) {
  Random random(seed);
  RadianceImage image{kWidth, kHeight, {}};
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const double light = i % 5 == 0 ? 0.0 : std::pow(10.0, random.between(-4, 6)) * scale;
    for (int c = 0; c < 3; ++c)
      image.rgb.push_back(static_cast<float>(light) * static_cast<float>(random.between(0, 1)));
  }
  return image;
}
int worst_of(const ScreenImage& a, const ScreenImage& b) {
  REQUIRE(a.rgba.size() == b.rgba.size());
  int worst = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) worst = std::max(worst, std::abs(a.rgba[i] - b.rgba[i]));
  return worst;
}

TEST_CASE("a balanced white has equal channels and its own luminance, and without balance nothing changes") {
  for (const double white_k : {1500.0, 2000.0, 3200.0, 4300.0, 5600.0, 6504.0, 20'000.0}) {
    CAPTURE(white_k);
    const glm::dvec3 white = fixtures::black_body_rgb(white_k);
    const glm::dvec3 shown = white_balance(white_k) * white;
    CHECK(std::abs(shown.x - shown.y) < 1e-12);
    CHECK(std::abs(shown.z - shown.y) < 1e-12);
    CHECK(shown.y == doctest::Approx(fixtures::luminance(white)).epsilon(1e-12));
  }
  CHECK(white_balance(0) == glm::dmat3(1));
  // Daylight is bluer than a lamp's light, so white for a lamp makes it blue.
  const glm::dvec3 daylight = white_balance(3200) * glm::dvec3(1);
  CHECK(daylight.z > 1.5 * daylight.x);
}

TEST_CASE("every tone curve rises from black to white, and hot cores are white whatever their colour") {
  for (const ToneCurve tone : kToneCurves) {
    CAPTURE(word_of(tone));
    const auto shown = [&](const glm::dvec3& color) {
      return f64::tone_shown(static_cast<std::uint32_t>(tone), color);
    };
    CHECK(tone_of(word_of(tone)) == tone);
    CHECK(glm::length(shown(glm::dvec3(0))) < 1e-6);
    double before = -1;
    for (double light = 1e-4; light < 1e5; light *= 1.1) {
      const glm::dvec3 grey = shown(glm::dvec3(light));
      CHECK(grey.x == doctest::Approx(grey.z).epsilon(1e-3));
      CHECK(grey.y >= before);
      before = grey.y;
      const glm::vec3 single = f32::tone_shown(static_cast<std::uint32_t>(tone), glm::vec3(glm::dvec3(light)));
      CHECK(std::abs(static_cast<double>(single.y) - grey.y) < 1e-5);
    }
    CHECK(before > 0.99);
    CHECK(shown(glm::dvec3(0.18)).y > 0.3);
    CHECK(shown(glm::dvec3(0.18)).y < 0.5);
    for (const glm::dvec3 color : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
      const glm::dvec3 core = shown(1e4 * color);
      CHECK(std::min({core.x, core.y, core.z}) > 0.98);
      // A beam of that colour: little of the others.
      const glm::dvec3 beam = shown(0.5 * color);
      CHECK(glm::dot(beam, color) > 3 * (beam.x + beam.y + beam.z - glm::dot(beam, color)));
    }
  }
  const glm::dvec3 amber = f64::tone_shown(FL_TONE_LINEAR, glm::dvec3(0.8, 0.2, 0.001));
  CHECK(amber.x == doctest::Approx(f64::srgb_encoded(0.8)));
  CHECK(amber.y == doctest::Approx(f64::srgb_encoded(0.2)));
  CHECK(amber.z == doctest::Approx(12.92 * 0.001));
  const double bad = std::numeric_limits<double>::quiet_NaN();
  for (const std::uint32_t tone : {1u * FL_TONE_FILMIC, 1u * FL_TONE_REINHARD, 1u * FL_TONE_LINEAR}) {
    const glm::dvec3 shown = f64::tone_shown(tone, glm::dvec3(bad, -1, std::numeric_limits<double>::infinity()));
    CHECK(shown.z <= 1);
    CHECK(shown.y >= 0);
  }
}

TEST_CASE("the screen has the tone curve and the white balance of the settings, and returns to what it was without") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Camera camera(vulkan.device());
  const RadianceImage light = colours(7);
  const ScreenImage plain = camera.see(light);
  CHECK(worst_of(plain, screen_of(light, kEv)) <= 1);
  for (const ToneCurve tone : kToneCurves) {
    for (const double white_k : {0.0, 3200.0}) {
      CAPTURE(word_of(tone));
      CAPTURE(white_k);
      camera.settings.tone = tone;
      camera.settings.white_k = white_k;
      const ScreenImage shown = camera.see(light);
      CHECK(worst_of(shown, screen_of(light, kEv, {tone, white_k})) <= 1);
      CHECK((shown.rgba == plain.rgba) == (tone == ToneCurve::kAgx && white_k == 0));
    }
  }
  const ScreenImage grey = camera.see(filled(20.0 * fixtures::black_body_rgb(3200)));
  for (std::size_t i = 0; i < grey.rgba.size(); i += 4) {
    REQUIRE(std::abs(grey.rgba[i] - grey.rgba[i + 1]) <= 1);
    REQUIRE(std::abs(grey.rgba[i + 2] - grey.rgba[i + 1]) <= 1);
  }
  camera.settings.tone = ToneCurve::kAgx;
  camera.settings.white_k = 0;
  CHECK(camera.see(light).rgba == plain.rgba);
  CHECK(must(camera.frame->read_radiance()).rgb == light.rgb);
  for (const double white_k : {-1.0, 1000.0, 30'000.0, std::numeric_limits<double>::quiet_NaN()}) {
    camera.settings.white_k = white_k;
    const Status refused = camera.frame->change(camera.settings);
    REQUIRE(!refused);
    CHECK(refused.error().message.find("expected 0 for none, or 1500 to 20000") != std::string::npos);
  }
}

TEST_CASE("with automatic exposure light that is 2^k times as bright gives the same picture, bit for bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  ScreenImage first;
  double first_ev = 0;
  for (const int k : {0, -7, 5, 7, 0}) {
    CAPTURE(k);
    Camera camera(vulkan.device());  // one that has seen nothing
    camera.settings.auto_exposure = true;
    const RadianceImage light = colours(3, std::exp2(k));
    const ScreenImage shown = camera.see(light);
    const double ev = must(camera.frame->read_exposure_ev());
    CHECK(must(camera.frame->read_radiance()).rgb == light.rgb);
    if (first.rgba.empty()) {
      first = shown;
      first_ev = ev;
      // 1 % of the pixels are brighter than 1.2 x 2^EV.
      int brighter = 0;
      for (std::size_t i = 0; i < light.rgb.size(); i += 3) {
        brighter += fixtures::luminance({light.rgb[i], light.rgb[i + 1], light.rgb[i + 2]}) > 1.2 * std::exp2(ev);
      }
      CHECK(std::abs(brighter - kWidth * kHeight / 100) <= 1);
    }
    CHECK(shown.rgba == first.rgba);
    CHECK(ev - first_ev == doctest::Approx(k).epsilon(1e-9));
  }
}

TEST_CASE("the automatic exposure comes as near to new light in a second, however many pictures it has") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  Camera camera(vulkan.device());
  camera.settings.auto_exposure = true;
  const auto ev_of = [&](double light) {
    (void)camera.see(filled(glm::dvec3(light)));
    return must(camera.frame->read_exposure_ev());
  };
  // Without light it is the one that was given. The first light has its own.
  CHECK(ev_of(0) == kEv);
  const double dark_ev = ev_of(1);
  CHECK(std::abs(dark_ev - std::log2(1 / 1.2)) < std::log2(1 + 1.0 / 32));  // a bin of the meter
  CHECK(ev_of(16) == dark_ev);                                              // no time has passed
  camera.frame->adapt_for(kSecondNs);
  const double bright_ev = ev_of(16);
  CHECK(bright_ev - dark_ev == doctest::Approx(4 * (1 - std::exp(-1.0))).epsilon(1e-5));
  camera.frame->adapt_for(100 * kSecondNs);
  CHECK(ev_of(1) == doctest::Approx(dark_ev).epsilon(1e-5));
  for (int i = 0; i < 25; ++i) {
    camera.frame->adapt_for(kSecondNs / 25);
    (void)ev_of(16);
  }
  const double in_25 = must(camera.frame->read_exposure_ev());
  std::fprintf(stderr, "EV after a second: %.7f by one picture, %.7f by 25\n", bright_ev, in_25);
  CHECK(std::abs(in_25 - bright_ev) < 1e-5);
  camera.frame->adapt_for(kSecondNs);
  CHECK(ev_of(0) == in_25);  // the dark has no exposure of its own
  camera.settings.auto_exposure = false;
  CHECK(ev_of(16) == kEv);
}

}  // namespace
}  // namespace footlight::render
