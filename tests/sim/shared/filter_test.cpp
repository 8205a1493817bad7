// Smoothing of levels, movement at a constant rate, and dimmer laws.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <type_traits>

#include "tests/sim/shared/cut.h"
#include "tests/sim/shared/steps.h"

namespace footlight {
namespace {

template <class T>
struct Filtered {
  using Smooth = std::conditional_t<std::is_same_v<T, Float>, f32::Smooth, f64::Smooth>;
  using Slew = std::conditional_t<std::is_same_v<T, Float>, f32::Slew, f64::Slew>;
  using Real = typename T::Real;
  Smooth smoothed{};
  Slew slew{};
  Real tau_s = Real(0.05);
  Real travel_s = Real(0.4);
  double mean = 0;
  double passed = 0;  // s of level
  void go(double target, glm::uvec2 dt_ns) {
    smoothed = smooth_step(smoothed, tau_s, static_cast<Real>(target), dt_ns);
    mean = static_cast<double>(slew_step(slew, travel_s, static_cast<Real>(target), dt_ns));
    passed += mean * static_cast<double>(number(dt_ns)) * 1e-9;
  }
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    const std::uint32_t part = change / 66 % 3;
    go(part == 0 ? change / 22 % 2 : part == 1 ? chance(1, change) : chance(1, change / 33), dt_ns);
  }
  [[nodiscard]] double value() const { return static_cast<double>(smoothed.now.position) + passed / 10; }
};

TEST_CASE_TEMPLATE("a smoothed level is the same at 15 to 1000 frames a second over 60 s of a demanding log", T, Float,
                   Double) {
  CHECK(rate_spread(Filtered<T>{}) <= 1e-6);
  Filtered<T> slow;
  slow.tau_s = 20;
  slow.travel_s = 8;
  CHECK(rate_spread(slow) <= 1e-6);
}

TEST_CASE_TEMPLATE("a filter's step of a + b equals its steps of a and b, from any state and up to 60 s each", T, Float,
                   Double) {
  std::mt19937_64 random(5);
  double worst = 0;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Filtered<T> whole;
    whole.tau_s = static_cast<typename T::Real>(chance(1, i));
    whole.travel_s = static_cast<typename T::Real>(i % 5 == 0 ? 0 : 5 * chance(2, i));
    whole.step(static_cast<std::uint32_t>(random()), words(random() % kSecondNs));
    Filtered<T> pieces = whole;
    const auto a = static_cast<std::uint64_t>(random_ns(random));
    const auto b = static_cast<std::uint64_t>(random_ns(random));
    const double target = chance(3, i);
    whole.go(target, words(a + b));
    pieces.go(target, words(a));
    pieces.go(target, words(b));
    worst = std::max(worst, std::abs(static_cast<double>(whole.smoothed.now.position - pieces.smoothed.now.position)));
    worst = std::max(worst, std::abs(static_cast<double>(whole.slew.level - pieces.slew.level)));
    worst = std::max(worst, std::abs(whole.passed - pieces.passed) / (1 + static_cast<double>(a + b) * 1e-9));
  }
  CHECK(worst <= (std::is_same_v<T, Float> ? 1e-6 : 1e-12));
}

TEST_CASE("smoothing follows the critically damped equation, in seconds and not in frames") {
  for (const int frames : {1, 7, 100}) {
    f64::Smooth smoothed = f64::smooth_start(0);
    for (int i = 0; i < frames; ++i)
      smoothed = f64::smooth_step(smoothed, 0.1, 1, words(static_cast<std::uint64_t>(700'000'000 / frames)));
    CHECK(smoothed.now.position == doctest::Approx(1 - 8 * std::exp(-7.0)).epsilon(1e-7));  // 1 - (1 + t) e^-t
  }
}

TEST_CASE("smoothing never overshoots and a change of target keeps the speed") {
  f64::Smooth smoothed = f64::smooth_start(0);
  double before = 0, speed = 0;
  for (int i = 0; i < 1000; ++i) {
    smoothed = f64::smooth_step(smoothed, 0.05, i < 30 ? 0.5 : 1, words(1'000'000));
    CHECK(smoothed.now.position >= before);
    CHECK(smoothed.now.position <= 1);
    CHECK(std::abs(smoothed.now.speed - speed) < 0.3);  // 0.001 s x 0.5 / 0.05^2
    before = smoothed.now.position;
    speed = smoothed.now.speed;
  }
}

TEST_CASE_TEMPLATE("filters: off by default, no time is no change, 1e9 s is the target, bad targets are ignored", T,
                   Float, Double) {
  Filtered<T> filter;
  filter.tau_s = 0;
  filter.go(0.7, words(1));
  CHECK(static_cast<double>(filter.smoothed.now.position) == doctest::Approx(0.7));
  filter.tau_s = static_cast<typename T::Real>(0.2);
  filter.go(0.1, words(100'000'000));
  const auto before = filter;
  filter.go(0.1, words(0));
  filter.go(0.9, words(0));
  CHECK(filter.smoothed.now.position == before.smoothed.now.position);
  CHECK(filter.slew.level == before.slew.level);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) filter.go(bad, words(kSecondNs));
  CHECK(filter.smoothed.now.position == before.smoothed.now.position);
  CHECK(filter.slew.level == before.slew.level);
  filter.go(0.9, words(1'000'000'000'000'000'000));
  CHECK(filter.smoothed.now.position == static_cast<typename T::Real>(0.9));
  CHECK(filter.slew.level == static_cast<typename T::Real>(0.9));
  CHECK(filter.mean == doctest::Approx(0.9));
}

TEST_CASE("two old filters depend on the frame rate, and the exact one does not") {
  // "70 % of the gap each frame", and the jump of a tenth of the speed per frame: the result at 15 and 240 fps.
  const auto gap_after = [](double per_frame, int frames) { return std::pow(1 - per_frame, frames); };
  CHECK(gap_after(0.7, 1) / gap_after(0.7, 16) > 1e5);  // after 1/15 s
  CHECK(gap_after(0.1, 1) - gap_after(0.1, 16) > 0.7);
  f64::Smooth slow = f64::smooth_start(0), fast = f64::smooth_start(0);
  slow = f64::smooth_step(slow, 0.05, 1, words(64'000'000));
  for (int i = 0; i < 16; ++i) fast = f64::smooth_step(fast, 0.05, 1, words(4'000'000));
  CHECK(slow.now.position == doctest::Approx(fast.now.position).epsilon(1e-15));
}

TEST_CASE("1 - exp(-x) is accurate for small x, on both sides of the end of its series") {
  double worst = 0, worst_f = 0;
  for (double x = 1e-12; x < 39; x *= 1.001) {
    const auto single = static_cast<float>(x);
    worst = std::max(worst, std::abs(f64::relax_share(x) / -std::expm1(-x) - 1));
    const double judge = -std::expm1(-static_cast<double>(single));
    worst_f = std::max(worst_f, std::abs(static_cast<double>(f32::relax_share(single)) / judge - 1));
  }
  MESSAGE("largest relative difference: ", worst, " in double, ", worst_f, " in float");
  CHECK(worst < 5e-15);
  CHECK(worst_f < 2.3e-7);  // 1.5e-5 when the series ended at 2e-3
  CHECK(f64::relax_share(std::nan("")) == 0);
  CHECK(f64::relax_share(-1) == 0);
}

TEST_CASE("every dimmer law is 0 at 0, 1 at 1 and never decreases over all 65536 levels, in float and in double") {
  for (std::uint32_t law = 0; law <= f64::kLawCount; ++law) {
    CAPTURE(law);
    CHECK(f32::law_light(law, 0) == 0);
    CHECK(f32::law_light(law, 1) == 1);
    CHECK(f64::law_light(law, 0) == 0);
    CHECK(f64::law_light(law, 1) == 1);
    for (const double bad : {std::nan(""), -1.0, -HUGE_VAL}) CHECK(f64::law_light(law, bad) == 0);
    CHECK(f64::law_light(law, HUGE_VAL) == 1);
    float before_f = 0;
    double before = 0;
    int falls = 0;
    for (int code = 0; code < 65536; ++code) {
      const double light = f64::law_light(law, code / 65535.0);
      const float light_f = f32::law_light(law, static_cast<float>(code) / 65535.0f);
      falls += light < before || light_f < before_f || light > 1 || light_f > 1;
      before = light;
      before_f = light_f;
    }
    CHECK(falls == 0);
  }
}

TEST_CASE("the laws have the values of their names") {
  CHECK(f64::law_light(f64::kLawLinear, 0.3) == 0.3);
  CHECK(f64::law_light(f64::kLawSquare, 0.3) == doctest::Approx(0.09));
  CHECK(f64::law_light(f64::kLawS, 0.25) == doctest::Approx(0.15625));
  CHECK(f64::law_light(f64::kLawS, 0.75) == doctest::Approx(0.84375));
  CHECK(f64::law_light(f64::kLawInverseSquare, f64::law_light(f64::kLawSquare, 0.37)) == doctest::Approx(0.37));
}

TEST_CASE(
    "a law applied after coarse and fine are combined has steps 256 times finer than one applied to the coarse byte") {
  const double coarse = f64::law_light(f64::kLawSquare, 1 / 255.0) - f64::law_light(f64::kLawSquare, 0);
  const double merged = f64::law_light(f64::kLawSquare, 257 / 65535.0) - f64::law_light(f64::kLawSquare, 256 / 65535.0);
  CHECK(coarse == doctest::Approx(f64::law_light(f64::kLawSquare, 257 / 65535.0)));
  CHECK(merged < coarse / 100);
}

TEST_CASE("a table law passes through its values, exactly at the ends, and never decreases between rising values") {
  f32::LawTable table{};
  for (int i = 0; i < 17; ++i) table.light[i] = static_cast<float>(i * i * i) / 4096.0f;
  for (int i = 0; i < 17; ++i) CHECK(f32::law_table(table, static_cast<float>(i) / 16) == table.light[i]);
  float before = 0;
  int falls = 0;
  for (int code = 0; code < 65536; ++code) {
    const float light = f32::law_table(table, static_cast<float>(code) / 65535.0f);
    falls += light < before;
    before = light;
  }
  CHECK(falls == 0);
  CHECK(before == 1);
  CHECK(f32::law_table(table, std::nanf("")) == 0);
  CHECK(f32::law_table(table, 1e30f) == 1);
}

TEST_CASE_TEMPLATE("filters, slews and spins are always finite over random inputs and times", T, Float, Double) {
  using Real = typename T::Real;
  std::mt19937_64 random(9);
  const double odd[] = {0, 1, -1, 0.5, 1e-30, 1e30, 1e-7, 1e6, -1e9, 1e9, std::nan(""), HUGE_VAL, -HUGE_VAL};
  const auto any = [&] { return static_cast<Real>(odd[random() % std::size(odd)]); };
  Filtered<T> filter;
  typename T::Spin spin{};
  int bad = 0;
  for (int i = 0, trials = hunt_trials(); i < trials; ++i) {
    const glm::uvec2 dt = words(random() >> (random() % 64));
    filter.tau_s = any();
    filter.travel_s = any();
    filter.go(static_cast<double>(any()), dt);
    spin = spin_step(spin, any(), any(), dt);
    bad += !std::isfinite(filter.smoothed.now.position) || !std::isfinite(filter.slew.level) ||
           !std::isfinite(filter.mean) || !std::isfinite(spin.rate_hz);
  }
  CHECK(bad == 0);
}

}  // namespace
}  // namespace footlight
