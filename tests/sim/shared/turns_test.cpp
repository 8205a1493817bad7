// Phases as 64-bit integers, and rotations based on them.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <type_traits>

#include "tests/sim/shared/cut.h"
#include "tests/sim/shared/steps.h"

namespace footlight {
namespace {

constexpr std::uint64_t kDayNs = 86'400'000'000'000;

// The exact phase in 2^-64 turn: the rate is exactly m x 2^-k (as every float and double), the time an integer.
std::uint64_t exact_phase(double rate_hz, std::uint64_t dt_ns) {
  // rate = whole + part x 2^-64; both products divided by 1e9 with all bits kept.
  const auto whole = static_cast<std::uint64_t>(rate_hz);
  const auto part = static_cast<std::uint64_t>(std::ldexp(rate_hz - static_cast<double>(whole), 64));
  using Wide = unsigned __int128;
  const Wide whole_turns_ns = Wide{whole} * dt_ns;  // in 1e-9 turn
  const auto rest = static_cast<std::uint64_t>(whole_turns_ns % 1'000'000'000);
  const Wide part_ns = Wide{part} * dt_ns;  // in 2^-64 x 1e-9 turn
  return static_cast<std::uint64_t>((Wide{rest} << 64) / 1'000'000'000 + part_ns / 1'000'000'000);
}

// a - b in turns, the shorter way.
double turns_apart(std::uint64_t a, std::uint64_t b) {
  return static_cast<double>(static_cast<std::int64_t>(a - b)) * 0x1p-64;
}

TEST_CASE("sums and products agree with 64-bit integers to the bit") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t a = random();
    const std::uint64_t b = random() >> (random() % 64);
    REQUIRE(number(f32::turns_add(words(a), words(b))) == a + b);
    REQUIRE(number(f32::turns_negate(words(a))) == 0 - a);
    REQUIRE(f32::turns_less(words(a), words(b)) == (a < b));
    const auto high = static_cast<std::uint64_t>((static_cast<unsigned __int128>(a) * b) >> 64);
    REQUIRE(high - number(f32::turns_mul_high(words(a), words(b))) <= 2);
  }
}

TEST_CASE("a step is rounded by at most 0.7 rate + 4 units of 2^-64 turn, for any rate and any time up to 30 days") {
  std::mt19937_64 random(4);
  for (int i = 0; i < 200'000; ++i) {
    double rate = std::exp2(std::uniform_real_distribution<double>(-10, 20)(random));
    if (i % 3 == 0) rate = std::floor(rate);
    if (i % 2 == 0) rate = static_cast<float>(rate);
    rate = std::min(rate, 1e6);
    const std::uint64_t dt = random() % (30 * kDayNs) >> (random() % 50);
    const std::uint64_t exact = exact_phase(rate, dt);
    const auto off = static_cast<std::int64_t>(exact - number(f64::turns_step(words(0), rate, words(dt))));
    REQUIRE(std::abs(off) <= static_cast<std::int64_t>(0.7 * rate) + 4);
    if (i % 2 == 0)  // a rate that is a float is the same in both
      REQUIRE(f32::turns_step(words(0), static_cast<float>(rate), words(dt)) ==
              f64::turns_step(words(0), rate, words(dt)));
  }
}

TEST_CASE("after 30 days of frames of any length the phase is less than a microsecond off") {
  std::mt19937_64 random(6);
  for (const double rate : {0.1, 1.0 / 3, 1.0, 12.5, 25.0, 29.97, 1000.0}) {
    std::uint64_t phase = 0;
    std::uint64_t now = 0;
    std::uint64_t steps = 0;
    while (now < 30 * kDayNs) {
      const std::uint64_t dt = 1 + random() % 60'000'000'000;
      phase = number(f64::turns_step(words(phase), rate, words(dt)));
      now += dt;
      ++steps;
    }
    const double off_s = std::abs(turns_apart(phase, exact_phase(rate, now))) / rate;
    CHECK(off_s < 1e-9);
    // The rounding is the same for a short step, so 1000 frames a second have a proportionally larger error.
    CHECK(off_s / static_cast<double>(steps) * 30 * 86'400 * 1000 < 1e-6);
  }
}

TEST_CASE("an advance counts whole turns") {
  std::mt19937_64 random(14);
  for (int i = 0; i < 20'000; ++i) {
    const double rate = std::uniform_real_distribution<double>(0, 1000)(random);
    const std::uint64_t dt = random() % 100'000'000'000;
    const f64::Advance advance = f64::turns_advance(rate, words(dt));
    REQUIRE(f64::advance_turns(advance) == doctest::Approx(rate * static_cast<double>(dt) * 1e-9).epsilon(1e-12));
  }
}

TEST_CASE("NaN rates stand still, and rates past the limit are clamped") {
  CHECK(number(f64::turns_step(words(7), std::nan(""), words(kDayNs))) == 7);
  CHECK(number(f64::turns_step(words(7), 0.0, words(kDayNs))) == 7);
  CHECK(f64::turns_step(words(7), 1e300, words(12345)) == f64::turns_step(words(7), 1e6, words(12345)));
  CHECK(f64::turns_step(words(7), HUGE_VAL, words(12345)) == f64::turns_step(words(7), 1e6, words(12345)));
}

TEST_CASE("a negative rate turns back by exactly what the positive one turns on") {
  std::mt19937_64 random(16);
  for (int i = 0; i < 1000; ++i) {
    const double rate = std::uniform_real_distribution<double>(-100, 100)(random);
    const glm::uvec2 start = words(random());
    const glm::uvec2 dt = words(random() % kDayNs);
    REQUIRE(f64::turns_step(f64::turns_step(start, rate, dt), -rate, dt) == start);
  }
}

TEST_CASE("phases convert to reals and back") {
  std::mt19937_64 random(12);
  for (int i = 0; i < 10'000; ++i) {
    const std::uint64_t a = random() >> (random() % 64);
    const std::uint64_t b = random() >> (random() % 64);
    const double real = static_cast<double>(a) * 0x1p-64;
    REQUIRE(f64::turns_real(words(a)) == doctest::Approx(real).epsilon(1e-15));
    REQUIRE(static_cast<double>(f32::turns_real(words(a))) == doctest::Approx(real).epsilon(1e-7));
    REQUIRE(turns_apart(number(f64::turns_from(f64::turns_real(words(a)))), a) == doctest::Approx(0).epsilon(1e-15));
    const double apart = (a < b ? -1.0 : 1.0) * static_cast<double>(a < b ? b - a : a - b) * 0x1p-64;
    REQUIRE(f64::turns_minus(words(a), words(b)) == doctest::Approx(apart).epsilon(1e-12));
  }
  CHECK(number(f64::turns_from(-0.25)) == std::uint64_t{3} << 62);
  CHECK(number(f64::turns_from(7.5)) == std::uint64_t{1} << 63);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e10}) CHECK(number(f64::turns_from(bad)) == 0);
}

// A spin with random targets of both signs.
template <class T>
struct Spinner {
  typename T::Spin spin{};
  typename T::Real ramp = 3;
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    const double target = change % 5 == 0 ? 0 : 20 * chance(9, change / 7) - 10;
    spin = spin_step(spin, ramp, static_cast<typename T::Real>(target), dt_ns);
  }
  [[nodiscard]] double value() const { return f64::turns_real(spin.phase); }
};

TEST_CASE_TEMPLATE("a spin is at the same angle at 15 to 1000 frames a second, with ramps and without", T, Float,
                   Double) {
  CHECK(rate_spread(Spinner<T>{}) <= 1e-12);
  Spinner<T> at_once;
  at_once.ramp = 0;
  CHECK(rate_spread(at_once) <= 1e-12);
}

TEST_CASE_TEMPLATE("a spin's step of a + b equals its steps of a and b, from any state and up to 60 s each", T, Float,
                   Double) {
  using Real = typename T::Real;
  std::mt19937_64 random(8);
  const auto rate = [&] { return static_cast<Real>((static_cast<double>(random() % 20'001) - 10'000) * 1e-3); };
  double worst_units = 0;  // of 2^-64 turn, over 0.7 rate + 4 of each
  for (int trial = 0; trial < 10'000; ++trial) {
    const Real ramp = random() % 3 == 0 ? Real(0) : static_cast<Real>(random() % 5000) * Real(1e-3);
    typename T::Spin spin{};
    spin = spin_step(spin, ramp, rate(), words(static_cast<std::uint64_t>(random_ns(random))));
    spin = spin_step(spin, ramp, rate(), words(static_cast<std::uint64_t>(random_ns(random))));  // often on a ramp
    const Real target = random() % 2 == 0 ? spin.target_hz : rate();
    const auto a_ns = static_cast<std::uint64_t>(random_ns(random));
    const auto b_ns = static_cast<std::uint64_t>(random_ns(random));
    const auto whole = spin_step(spin, ramp, target, words(a_ns + b_ns));
    const auto parts = spin_step(spin_step(spin, ramp, target, words(a_ns)), ramp, target, words(b_ns));
    CHECK(parts.rate_hz == whole.rate_hz);
    const double apart = std::abs(turns_apart(number(parts.phase), number(whole.phase))) * 0x1p64;
    worst_units = std::max(worst_units, apart / (0.7 * std::abs(static_cast<double>(target)) + 4));
  }
  MESSAGE("worst: ", worst_units, " of the bound of one step");
  CHECK(worst_units <= 2);  // the steps of a and of b are rounded, and that of both
}

TEST_CASE("a ramp between rates turns by its mean rate, also through zero") {
  f64::Spin spin = f64::spin_start(words(0));
  spin = f64::spin_step(spin, 2, 4, f64::time_ns(1));  // half way up: 1 turn
  CHECK(spin.rate_hz == doctest::Approx(2));
  CHECK(turns_apart(number(spin.phase), 0) == doctest::Approx(0).epsilon(1e-12));
  spin = f64::spin_step(spin, 2, 4, f64::time_ns(1.25));  // 3 turns up, then 0.25 s at 4 Hz
  CHECK(spin.rate_hz == 4);
  CHECK(turns_apart(number(spin.phase), 0) == doctest::Approx(0).epsilon(1e-9));
  spin = f64::spin_step(spin, 2, -4, f64::time_ns(4));  // to -4 Hz in 4 s: there and back
  CHECK(spin.rate_hz == doctest::Approx(-4));
  CHECK(turns_apart(number(spin.phase), 0) == doctest::Approx(0).epsilon(1e-9));
  spin = f64::spin_step(spin, 2, -4, f64::time_ns(0.0625));
  CHECK(turns_apart(number(spin.phase), 0) == doctest::Approx(-0.25).epsilon(1e-9));
}

TEST_CASE("a spin does not jump when its sign changes, from DMX 127 to 128") {
  f64::Spin spin = f64::spin_start(words(std::uint64_t{1} << 61));
  for (int i = 0; i < 1000; ++i) spin = f64::spin_step(spin, 0, 0.31, words(22'727'273));
  const std::uint64_t before = number(spin.phase);
  spin = f64::spin_step(spin, 0, -0.31, words(0));
  CHECK(number(spin.phase) == before);
  spin = f64::spin_step(spin, 0, -0.31, words(1'000'000));
  CHECK(turns_apart(number(spin.phase), before) == doctest::Approx(-0.31e-3).epsilon(1e-6));
}

TEST_CASE("at 3600 degrees a second no precision is lost after 7 days, when float radians stand still") {
  f64::Spin spin = f64::spin_start(words(0));
  spin = f64::spin_step(spin, 0, 10, words(7 * kDayNs));
  const std::uint64_t before = number(spin.phase);
  spin = f64::spin_step(spin, 0, 10, words(16'666'667));
  CHECK(turns_apart(number(spin.phase), before) == doctest::Approx(0.16666667).epsilon(1e-9));
  float phase = 604'800.0f * 0.078f;  // rad, code 10 of the old method: v / 255 * dt per frame
  CHECK(phase + 0.039f / 60 == phase);
}

TEST_CASE("fixtures start at their own phases and keep their distance") {
  f32::Spin a = f32::spin_start(words(0));
  f32::Spin b = f32::spin_start(f32::turns_from(0.25f));
  for (int i = 0; i < 5000; ++i) {
    const auto rate = static_cast<float>(i % 700) * 0.01f - 3;
    a = f32::spin_step(a, 1, rate, words(16'666'667));
    b = f32::spin_step(b, 1, rate, words(16'666'667));
  }
  CHECK(number(b.phase) - number(a.phase) == std::uint64_t{1} << 62);
}

TEST_CASE_TEMPLATE("no time and NaN targets do not change a spin, a long time reaches the target", T, Float, Double) {
  using Real = typename T::Real;
  Spinner<T> spinner;
  spinner.step(3, words(kSecondNs / 3));
  const auto before = spinner.spin;
  spinner.step(3, words(0));
  CHECK(spinner.spin.phase == before.phase);
  CHECK(spinner.spin.rate_hz == before.rate_hz);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e7}) {
    spinner.spin = spin_step(spinner.spin, spinner.ramp, static_cast<Real>(bad), words(kSecondNs));
    CHECK(spinner.spin.phase == before.phase);
  }
  spinner.spin = spin_step(spinner.spin, spinner.ramp, Real(-2), words(1'000'000'000'000'000'000));
  CHECK(spinner.spin.rate_hz == -2);
}

TEST_CASE("a continuous motor moves the shorter way to a position") {
  CHECK(f64::turns_way(f64::turns_from(0.9), f64::turns_from(0.1)) == doctest::Approx(0.2));
  CHECK(f64::turns_way(f64::turns_from(0.1), f64::turns_from(0.9)) == doctest::Approx(-0.2));
}

}  // namespace
}  // namespace footlight
