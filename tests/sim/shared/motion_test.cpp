// The motor axis against its own laws and against a judge that knows nothing of its closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sim/shared/shared.h"

namespace footlight {
namespace {

struct Float {
  using Real = float;
  using Axis = f32::Axis;
  static Axis step(Axis a, Real target, Real v, Real acc, Real dt) { return f32::axis_step(a, target, v, acc, dt); }
};
struct Double {
  using Real = double;
  using Axis = f64::Axis;
  static Axis step(Axis a, Real target, Real v, Real acc, Real dt) { return f64::axis_step(a, target, v, acc, dt); }
};

// A state, a target and limits as moving heads have them: radians, up to a turn and a half away.
struct Case {
  double position, speed, target, speed_max, acceleration_max;
};

// `over`: how many times faster than the limit the axis may start (a limit that was lowered).
Case random_case(std::mt19937& random, double over = 1) {
  const auto in = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
  Case c{};
  c.speed_max = in(0.5, 6);
  c.acceleration_max = in(2, 30);
  c.position = in(-4.7, 4.7);
  c.speed = in(-1, 1) * over * c.speed_max;
  // Every fourth goes to a target close by, where the ways of the closed form meet.
  c.target = random() % 4 == 0 ? c.position + in(-0.05, 0.05) : in(-4.7, 4.7);
  return c;
}

template <class T>
typename T::Axis start(const Case& c) {
  typename T::Axis axis;
  axis.position = static_cast<typename T::Real>(c.position);
  axis.speed = static_cast<typename T::Real>(c.speed);
  return axis;
}

template <class T>
typename T::Axis step(const typename T::Axis& axis, const Case& c, double dt_s) {
  using Real = typename T::Real;
  return T::step(axis, static_cast<Real>(c.target), static_cast<Real>(c.speed_max),
                 static_cast<Real>(c.acceleration_max), static_cast<Real>(dt_s));
}

// Largest difference in position between one step and the same time in pieces, over `count` random cases.
template <class T>
double split_error(int count, double over, bool retarget) {
  std::mt19937 random(7);
  const auto in = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    Case c = random_case(random, over);
    typename T::Axis whole = start<T>(c);
    if (retarget) {  // begin in the middle of another move
      whole = step<T>(whole, c, in(0, 0.8));
      c.target = in(-4.7, 4.7);
      c.speed_max = in(0.5, 6);
    }
    typename T::Axis pieces = whole;
    // Pieces of 2^-10 s are exact in float, so that both ways cover the same time.
    const int ticks = 1 + static_cast<int>(random() % 3000);
    whole = step<T>(whole, c, ticks / 1024.0);
    for (int done = 0; done < ticks;) {
      const int now = std::min(ticks - done, 1 + static_cast<int>(random() % 400));
      pieces = step<T>(pieces, c, now / 1024.0);
      done += now;
    }
    worst = std::max(worst, std::abs(static_cast<double>(whole.position) - static_cast<double>(pieces.position)));
  }
  return worst;
}

TEST_CASE("a step of a + b is a step of a and then one of b") {
  const double d = split_error<Double>(20'000, 1, false);
  const double f = split_error<Float>(20'000, 1, false);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 1e-5);
}

TEST_CASE("a step can be split after a new target in the middle of a move") {
  const double d = split_error<Double>(20'000, 1, true);
  const double f = split_error<Float>(20'000, 1, true);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 1e-5);
}

TEST_CASE("a step can be split while the axis is faster than a limit that was lowered") {
  const double d = split_error<Double>(20'000, 4, false);
  const double f = split_error<Float>(20'000, 4, false);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 2e-5);  // such an axis runs up to ten times further
}

TEST_CASE("no step breaks the limits of speed and acceleration") {
  std::mt19937 random(11);
  double speed_over = 0;         // beyond the limit, or beyond the speed at the start where that was higher
  double acceleration_over = 0;  // share
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(random, i % 3 == 0 ? 3 : 1);
    f64::Axis axis = start<Double>(c);
    constexpr double kDt = 1.0 / 512;
    for (int k = 0; k < 1500; ++k) {
      const f64::Axis next = step<Double>(axis, c, kDt);
      speed_over = std::max(speed_over, std::abs(next.speed) - std::max(c.speed_max, std::abs(axis.speed)));
      acceleration_over =
          std::max(acceleration_over, std::abs(next.speed - axis.speed) / (kDt * c.acceleration_max) - 1);
      // Position and speed belong together: no jump in place.
      const double mean = (next.position - axis.position) / kDt;
      const double reach = c.acceleration_max * kDt + 1e-9;
      REQUIRE(mean <= std::max(axis.speed, next.speed) + reach);
      REQUIRE(mean >= std::min(axis.speed, next.speed) - reach);
      axis = next;
    }
    axis = step<Double>(axis, c, 60);
    REQUIRE(axis.position == c.target);
    REQUIRE(axis.speed == 0);
  }
  CHECK(speed_over < 1e-12);
  CHECK(acceleration_over < 1e-9);
}

// A judge of another kind: the control law of the double integrator, applied anew every `h` seconds. Brake when braking
// is just enough, else push towards the target, never past the speed limit.
f64::Axis by_small_steps(const Case& c, double dt_s, double h) {
  double x = c.position;
  double v = c.speed;
  for (double t = 0; t < dt_s; t += h) {
    const double stop = x + v * std::abs(v) / (2 * c.acceleration_max);
    double a = stop < c.target ? c.acceleration_max : -c.acceleration_max;
    if (a * v > 0 && std::abs(v) >= c.speed_max) a = std::abs(v) > c.speed_max + c.acceleration_max * h ? -a : 0;
    x += v * h + 0.5 * a * h * h;
    v += a * h;
  }
  f64::Axis axis;
  axis.position = x;
  axis.speed = v;
  return axis;
}

TEST_CASE("the closed form goes where the control law goes when it is applied in small steps") {
  std::mt19937 random(5);
  constexpr double kStep_s = 2e-5;
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random, i % 4 == 0 ? 2.5 : 1);
    const double dt_s = std::uniform_real_distribution<double>(0.02, 2.5)(random);
    const f64::Axis exact = step<Double>(start<Double>(c), c, dt_s);
    worst = std::max(worst, std::abs(exact.position - by_small_steps(c, dt_s, kStep_s).position));
  }
  MESSAGE("largest difference: ", worst, " rad with steps of ", kStep_s, " s");
  CHECK(worst < 1e-3);  // at 20 rad/s, the fastest start, a step of 2e-5 s goes 4e-4 rad
}

TEST_CASE("a rest-to-rest move takes as long as the textbook says") {
  f64::Axis axis;
  axis.position = 0;
  axis.speed = 0;
  // 8 rad at 4 rad/s and 8 rad/s^2: half a second up, half a second down, 2 rad of ramps, 6 rad of cruise in 1.5 s.
  CHECK(f64::axis_step(axis, 8.0, 4.0, 8.0, 2.4999).position < 8.0);
  CHECK(f64::axis_step(axis, 8.0, 4.0, 8.0, 2.5001).position == 8.0);
  CHECK(f64::axis_step(axis, 8.0, 4.0, 8.0, 1.25).position == doctest::Approx(4.0));
  CHECK(f64::axis_step(axis, 8.0, 4.0, 8.0, 1.25).speed == doctest::Approx(4.0));
  // Too short for the limit: 0.5 rad at 8 rad/s^2 is 2 sqrt(D / A) = 0.5 s with a peak of 2 rad/s.
  CHECK(f64::axis_step(axis, -0.5, 4.0, 8.0, 0.25).speed == doctest::Approx(-2.0));
  CHECK(f64::axis_step(axis, -0.5, 4.0, 8.0, 0.5001).position == -0.5);
}

TEST_CASE("an axis that runs away from its target turns round and comes back") {
  f64::Axis axis;
  axis.position = 0;
  axis.speed = -4;
  const f64::Axis furthest = f64::axis_step(axis, 1.0, 4.0, 8.0, 0.5);
  CHECK(furthest.position == doctest::Approx(-1.0));
  CHECK(furthest.speed == doctest::Approx(0.0));
  CHECK(f64::axis_step(axis, 1.0, 4.0, 8.0, 5.0).position == 1.0);
}

TEST_CASE("an axis too fast to stop overshoots and comes back") {
  f64::Axis axis;
  axis.position = 0;
  axis.speed = 4;
  CHECK(f64::axis_step(axis, 0.5, 4.0, 8.0, 0.5).position == doctest::Approx(1.0));
  CHECK(f64::axis_step(axis, 0.5, 4.0, 8.0, 5.0).position == 0.5);
}

template <class T>
void check_edges() {
  using Real = typename T::Real;
  constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
  constexpr Real kInf = std::numeric_limits<Real>::infinity();
  typename T::Axis axis;
  axis.position = Real(1.25);
  axis.speed = Real(-0.5);
  const auto same = [&](const typename T::Axis& a) { return a.position == axis.position && a.speed == axis.speed; };
  CHECK(same(T::step(axis, Real(3), Real(2), Real(8), Real(0))));
  CHECK(same(T::step(axis, Real(3), Real(2), Real(8), Real(-1))));
  CHECK(same(T::step(axis, Real(3), Real(2), Real(8), kNan)));
  CHECK(same(T::step(axis, Real(3), Real(0), Real(8), Real(1))));
  CHECK(same(T::step(axis, Real(3), Real(2), Real(0), Real(1))));
  CHECK(same(T::step(axis, Real(3), kNan, Real(8), Real(1))));
  CHECK(same(T::step(axis, Real(3), Real(2), kNan, Real(1))));
  CHECK(same(T::step(axis, kNan, Real(2), Real(8), Real(1))));
  CHECK(same(T::step(axis, kInf, Real(2), Real(8), Real(1))));
  for (const Real dt : {Real(60), Real(1e9), kInf}) {
    const typename T::Axis there = T::step(axis, Real(3), Real(2), Real(8), dt);
    CHECK(there.position == Real(3));
    CHECK(there.speed == Real(0));
  }
  axis.position = Real(3);
  axis.speed = Real(0);
  CHECK(same(T::step(axis, Real(3), Real(2), Real(8), Real(0.01))));
}

TEST_CASE("no time, bad time and bad limits leave the axis alone; a long time brings it to the target") {
  check_edges<Float>();
  check_edges<Double>();
}

TEST_CASE("float stays near double over random moves") {
  std::mt19937 random(3);
  double worst = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Case c = random_case(random);
    const double dt_s = static_cast<double>(1 + random() % 3000) / 1024;
    worst = std::max(worst, std::abs(step<Double>(start<Double>(c), c, dt_s).position -
                                     static_cast<double>(step<Float>(start<Float>(c), c, dt_s).position)));
  }
  MESSAGE("largest difference: ", worst, " rad");
  CHECK(worst < 1e-5);
}

}  // namespace
}  // namespace footlight
