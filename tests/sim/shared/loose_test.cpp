// Motors on a processor whose quotients and roots are as inexact as Vulkan allows (2.5 units in the last place).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/sim/shared/cut.h"

namespace footlight {

// A float whose quotients and roots are wrong by up to 2.5 units in the last place, in either direction.
class Loose {
 public:
  constexpr Loose() = default;
  constexpr explicit Loose(double value) : value_(static_cast<float>(value)) {}
  constexpr explicit operator float() const { return value_; }
  constexpr explicit operator std::uint32_t() const { return static_cast<std::uint32_t>(value_); }

  friend constexpr Loose operator+(Loose a, Loose b) { return of(a.value_ + b.value_); }
  friend constexpr Loose operator-(Loose a, Loose b) { return of(a.value_ - b.value_); }
  friend constexpr Loose operator*(Loose a, Loose b) { return of(a.value_ * b.value_); }
  friend Loose operator/(Loose a, Loose b) {
    return near(static_cast<double>(a.value_) / static_cast<double>(b.value_));
  }
  friend constexpr Loose operator-(Loose a) { return of(-a.value_); }
  constexpr Loose& operator+=(Loose b) { return *this = *this + b; }
  constexpr Loose& operator-=(Loose b) { return *this = *this - b; }
  constexpr Loose& operator*=(Loose b) { return *this = *this * b; }
  friend constexpr bool operator==(Loose a, Loose b) { return a.value_ == b.value_; }
  friend constexpr bool operator!=(Loose a, Loose b) { return a.value_ != b.value_; }
  friend constexpr bool operator<(Loose a, Loose b) { return a.value_ < b.value_; }
  friend constexpr bool operator>(Loose a, Loose b) { return a.value_ > b.value_; }
  friend constexpr bool operator<=(Loose a, Loose b) { return a.value_ <= b.value_; }
  friend constexpr bool operator>=(Loose a, Loose b) { return a.value_ >= b.value_; }

  friend Loose sqrt(Loose a) { return near(std::sqrt(static_cast<double>(a.value_))); }
  friend Loose abs(Loose a) { return of(std::abs(a.value_)); }
  friend Loose floor(Loose a) { return of(std::floor(a.value_)); }
  friend Loose min(Loose a, Loose b) { return b < a ? b : a; }
  friend Loose max(Loose a, Loose b) { return a < b ? b : a; }
  friend Loose clamp(Loose a, Loose low, Loose high) { return min(max(a, low), high); }
  friend Loose exp(Loose a) { return of(std::exp(a.value_)); }
  friend Loose sin(Loose a) { return of(std::sin(a.value_)); }
  friend Loose cos(Loose a) { return of(std::cos(a.value_)); }

 private:
  static constexpr Loose of(float value) {
    Loose loose;
    loose.value_ = value;
    return loose;
  }
  static Loose near(double value) {
    static std::mt19937 random(17);
    if (value == 0 || !std::isfinite(value)) return of(static_cast<float>(value));
    const auto size = std::abs(static_cast<float>(value));
    const double unit = static_cast<double>(std::nextafter(size, HUGE_VALF)) - static_cast<double>(size);
    return of(static_cast<float>(value + unit * std::uniform_real_distribution<double>(-2.5, 2.5)(random)));
  }
  float value_ = 0;
};

// As computed by the processor.
namespace loose {
using Real = Loose;
using uint = std::uint32_t;
using Turns = glm::uvec2;
using glm::min;
// Each header uses those above it.
// clang-format off
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
// clang-format on
}  // namespace loose

// As computed by the shaders: with the correction step.
#define FL_LOOSE_QUOTIENTS
namespace corrected {
using Real = Loose;
using uint = std::uint32_t;
using Turns = glm::uvec2;
using glm::min;
// Each header uses those above it.
// clang-format off
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
// clang-format on
}  // namespace corrected
#undef FL_LOOSE_QUOTIENTS

namespace {

// 500 motors over 400 steps of typical lengths, with a new target at every eighth: the largest difference to float.
template <class Start, class Step, class Limits>
double apart(Start start, Step step, Limits limits_of) {
  using Real = decltype(start(0.0).now.position);
  double worst = 0;
  for (std::uint32_t m = 0; m < 500; ++m) {
    std::mt19937 random(m + 1);
    const auto limits = limits_of(9.4, 1 + 2 * chance(1, m), 0.1 + 0.4 * chance(2, m));
    const f32::MotorLimits same{static_cast<float>(limits.speed_max), static_cast<float>(limits.acceleration_max)};
    auto motor = start(0.0);
    f32::Motor judge = f32::motor_start(0);
    float target = 0;
    const std::uint64_t lengths_ns[] = {0, 1, 1'000'000, 22'727'272, 40'000'000, 200'000'000};
    for (int i = 0; i < 400; ++i) {
      if (random() % 8 == 0) target = static_cast<float>(9.4 * (static_cast<double>(random() % 65536) / 65535 - 0.5));
      const glm::uvec2 dt_ns = words(lengths_ns[random() % 6]);
      motor = step(motor, limits, Real(static_cast<double>(target)), dt_ns);
      judge = f32::motor_step(judge, same, target, dt_ns);
      worst = std::max(worst, std::abs(static_cast<double>(static_cast<float>(motor.now.position)) -
                                       static_cast<double>(judge.now.position)));
    }
  }
  return worst;
}

TEST_CASE("motors with corrected quotients match float to the bit, without the correction, an H100 was 7e-5 rad off") {
  const auto limits = [](double range, double fade_s, double acceleration_s) {
    const f32::MotorLimits exact =
        f32::motor_limits(static_cast<float>(range), static_cast<float>(fade_s), static_cast<float>(acceleration_s));
    return exact;
  };
  const double plain = apart([](double at) { return loose::motor_start(Loose(at)); },
                             [](auto motor, auto with, Loose target, glm::uvec2 dt_ns) {
                               return loose::motor_step(motor, with, target, dt_ns);
                             },
                             [&](double range, double fade_s, double acceleration_s) {
                               const auto exact = limits(range, fade_s, acceleration_s);
                               return loose::MotorLimits{Loose(static_cast<double>(exact.speed_max)),
                                                         Loose(static_cast<double>(exact.acceleration_max))};
                             });
  const double exact = apart([](double at) { return corrected::motor_start(Loose(at)); },
                             [](auto motor, auto with, Loose target, glm::uvec2 dt_ns) {
                               return corrected::motor_step(motor, with, target, dt_ns);
                             },
                             [&](double range, double fade_s, double acceleration_s) {
                               const auto exact_limits = limits(range, fade_s, acceleration_s);
                               return corrected::MotorLimits{Loose(static_cast<double>(exact_limits.speed_max)),
                                                             Loose(static_cast<double>(exact_limits.acceleration_max))};
                             });
  MESSAGE("largest difference: ", plain, " rad without the correction, ", exact, " rad with it");
  CHECK(plain > 1.7e-5);  // else this test would prove nothing
  CHECK(exact == 0);
}

// True if a number is so near the middle of two floats that a correction of 3 units, itself wrong by 2.5 of its own
// last places (3e-7), can round it to the other one.
bool is_tie(double exact) {
  const double unit = std::ldexp(1.0, std::ilogb(exact) - 23);
  const double units = exact / unit;
  return std::abs(units - std::floor(units) - 0.5) < 1e-6;
}

TEST_CASE("a corrected quotient and root are those of IEEE 754, except within 1e-6 of a unit of a tie") {
  std::mt19937 random(5);
  int wrong = 0;
  int ties = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const auto any = [&] {
      return static_cast<float>(
          std::ldexp(1 + static_cast<double>(random()) / 4294967296.0, static_cast<int>(random() % 40u) - 20));
    };
    const float a = any(), b = any();
    const Loose loose_a(static_cast<double>(a)), loose_b(static_cast<double>(b));
    const bool quotient_tie = is_tie(static_cast<double>(a) / static_cast<double>(b));
    const bool root_tie = is_tie(std::sqrt(static_cast<double>(a)));
    ties += quotient_tie + root_tie;
    wrong += !quotient_tie && static_cast<float>(corrected::exact_quotient(loose_a, loose_b)) != a / b;
    wrong += !root_tie && static_cast<float>(corrected::exact_root(loose_a)) != std::sqrt(a);
  }
  CHECK(wrong == 0);
  CHECK(ties < 30);  // of two million
  CHECK(static_cast<float>(corrected::exact_root(Loose(0))) == 0);
  CHECK(static_cast<float>(corrected::exact_quotient(Loose(0), Loose(3))) == 0);
}

}  // namespace
}  // namespace footlight
