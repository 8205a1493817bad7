// Haze and fog in the air of a room. Compared with the reference: tests/render/reference/time_judges_test.cpp.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <type_traits>

#include "tests/sim/shared/cut.h"

namespace footlight {
namespace {

template <class T>
struct Roomful {
  using Real = typename T::Real;
  using Air = std::conditional_t<std::is_same_v<T, Float>, f32::RoomAir, f64::RoomAir>;
  Air air{};
  Real tau_s = Real(120);
  void go(double output, double mixing_hz, glm::uvec2 dt_ns) {
    air = room_step(air, tau_s, static_cast<Real>(output), static_cast<Real>(mixing_hz), dt_ns);
  }
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    go(change / 66 % 2 == 0 ? 4e-3 * chance(1, change) : 0, change / 33 % 2 == 0 ? 0.02 : 0.1, dt_ns);
  }
  [[nodiscard]] double value() const { return static_cast<double>(room_scattering(air)); }
};

TEST_CASE_TEMPLATE("the air of a room is bit-identical at 15 to 1000 frames a second over 60 s of a demanding log", T,
                   Float, Double) {
  CHECK(rate_spread(Roomful<T>{}) == 0);
  Roomful<T> quick;
  quick.tau_s = static_cast<typename T::Real>(0.01);
  CHECK(rate_spread(quick) == 0);
}

TEST_CASE_TEMPLATE("a room's step of a + b equals its steps of a and b, to the bit and from any state", T, Float,
                   Double) {
  std::mt19937_64 random(7);
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Roomful<T> whole;
    whole.tau_s = static_cast<typename T::Real>(std::pow(10.0, 9 * chance(1, i) - 4));
    whole.go(chance(2, i), chance(3, i), words(random() % (60 * kSecondNs)));
    Roomful<T> pieces = whole;
    const auto a = static_cast<std::uint64_t>(random_ns(random));
    const auto b = static_cast<std::uint64_t>(random_ns(random));
    whole.go(chance(4, i), 0.1, words(a + b));
    pieces.go(chance(4, i), 0.1, words(a));
    pieces.go(chance(4, i), 0.1, words(b));
    REQUIRE(whole.value() == pieces.value());
  }
}

TEST_CASE("explicit Euler at 24 frames a second diverges in a stiff room, and the exact step does not") {
  double euler = 0;
  for (int i = 0; i < 240; ++i) euler += (1.0 / 24) * (4e-3 - euler / 0.01);  // ventilated in 10 ms
  CHECK(std::abs(euler) > 1e3);
  Roomful<Double> room;
  room.tau_s = 0.01;
  for (int i = 0; i < 240; ++i) room.go(4e-3, 1e6, words(41'666'667));
  CHECK(room.value() == doctest::Approx(4e-5).epsilon(1e-12));
}

TEST_CASE_TEMPLATE("rooms: no time is no change, a long time is the equilibrium, NaN is ignored", T, Float, Double) {
  using Real = typename T::Real;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Roomful<T> room;
  room.go(4e-3, 0.1, words(30 * kSecondNs));
  const auto before = room;
  room.go(4e-3, 0.1, words(0));
  CHECK(room.value() == before.value());
  room.go(0, 3, words(0));
  CHECK(room.value() == before.value());
  room = before;
  for (const double bad : {std::nan(""), -1.0, kInfinity, -kInfinity, 1e30}) room.go(bad, 0.1, words(0));
  for (const double bad : {std::nan(""), -1.0, -kInfinity}) room.go(4e-3, bad, words(0));
  CHECK(room.value() == before.value());
  room.go(4e-3, 0.1, words(1'000'000'000'000'000'000));
  CHECK(room.value() == doctest::Approx(4e-3 * 120 * (1 - 1 / (1 + 12.0))).epsilon(1e-6));
  room.go(4e-3, kInfinity, words(0));  // mixed at once
  CHECK(room.value() == doctest::Approx(4e-3 * 120).epsilon(1e-6));
  room.go(0, 0.1, words(1'000'000'000'000'000'000));
  CHECK(room.value() == 0);
  for (const double bad : {0.0, -1.0, std::nan(""), kInfinity, 1e-30}) {  // nothing is lost
    Roomful<T> closed;
    closed.tau_s = static_cast<Real>(bad);
    closed.go(1e-3, 1e6, words(10 * kSecondNs));
    CHECK(closed.value() == doctest::Approx(1e-2));
  }
}

TEST_CASE_TEMPLATE("every room is always finite, not negative, and not above the total output", T, Float, Double) {
  std::mt19937_64 random(11);
  const auto any = [&] {
    const double values[] = {0, 1e-30, 1e-6, 1, 1e6, 1e30, -1, std::nan(""), std::numeric_limits<double>::infinity()};
    return values[random() % 9] * (static_cast<double>(random() % 1000) / 500);
  };
  for (int i = 0; i < hunt_trials(); ++i) {
    Roomful<T> room;
    room.tau_s = static_cast<typename T::Real>(any());
    for (int n = 0; n < 4; ++n) room.go(any(), any(), words(random() >> (random() % 64)));
    REQUIRE(std::isfinite(room.value()));
    REQUIRE(room.value() >= 0);
    REQUIRE(room.value() <= static_cast<double>(room.air.total) * (1 + 1e-6));
  }
}

}  // namespace
}  // namespace footlight
