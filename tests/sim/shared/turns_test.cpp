// Phases as 64-bit integers.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "sim/shared/shared.h"

namespace footlight {
namespace {

glm::uvec2 words(std::uint64_t value) {
  return {static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)};
}
std::uint64_t number(glm::uvec2 value) { return static_cast<std::uint64_t>(value.y) << 32 | value.x; }

TEST_CASE("sums and products agree with 64-bit integers to the bit") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t a = random();
    const std::uint64_t b = random() >> (random() % 64);
    REQUIRE(number(f32::turns_add(words(a), words(b))) == a + b);
    REQUIRE(number(f32::turns_mul(words(a), words(b))) == a * b);
  }
}

TEST_CASE("a step of a + b is a step of a and then one of b, to the bit, in float and in double") {
  std::mt19937_64 random(4);
  for (int i = 0; i < 20'000; ++i) {
    const double rate = std::uniform_real_distribution<double>(0, 100)(random);
    const std::uint64_t phase = random();
    const std::uint64_t a = random() % 100'000'000'000;
    const std::uint64_t b = random() % 100'000'000'000;
    REQUIRE(number(f64::turns_step(f64::turns_step(words(phase), rate, words(a)), rate, words(b))) ==
            number(f64::turns_step(words(phase), rate, words(a + b))));
    const auto rate_f = static_cast<float>(rate);
    REQUIRE(number(f32::turns_step(f32::turns_step(words(phase), rate_f, words(a)), rate_f, words(b))) ==
            number(f32::turns_step(words(phase), rate_f, words(a + b))));
  }
}

TEST_CASE("after a day a whole rate is off by less than a ten-thousandth of a turn") {
  constexpr std::uint64_t kDay_ns = 86'400'000'000'000;
  for (const double rate : {1.0, 7.0, 12.0, 25.0}) {
    const auto phase = static_cast<std::int64_t>(number(f64::turns_step(words(0), rate, words(kDay_ns))));
    CHECK(std::abs(static_cast<double>(phase)) * std::pow(2.0, -64) < 1e-4);  // whole turns: the phase comes back to 0
  }
}

TEST_CASE("the rate is right to nine digits for fractions of a hertz") {
  for (const double rate : {0.02, 0.5, 0.123456, 3.75, 24.999}) {
    const double per_ns = static_cast<double>(number(f64::turns_per_ns(rate)));
    CHECK(per_ns == doctest::Approx(rate * std::pow(2.0, 64) * 1e-9).epsilon(1e-7));
  }
}

TEST_CASE("rates that are negative or no number stand still, and rates past the limit are cut") {
  CHECK(number(f64::turns_per_ns(-1.0)) == 0);
  CHECK(number(f64::turns_per_ns(0.0)) == 0);
  CHECK(number(f64::turns_per_ns(std::nan(""))) == 0);
  CHECK(number(f64::turns_per_ns(1e300)) == number(f64::turns_per_ns(1e6)));
  CHECK(number(f64::turns_per_ns(std::numeric_limits<double>::infinity())) == number(f64::turns_per_ns(1e6)));
}

TEST_CASE("a fraction of a turn is below one") {
  CHECK(f32::turns_fraction(words(~std::uint64_t{0})) < 1.0f);
  CHECK(f32::turns_fraction(words(std::uint64_t{1} << 63)) == 0.5f);
}

}  // namespace
}  // namespace footlight
