// The motor axis compared with its own laws and with a reference that does not use its closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <type_traits>

#include "tests/sim/shared/cut.h"

namespace footlight {
namespace {

// A typical state, target and limits of moving heads: radians, up to a turn and a half away.
struct Case {
  double position, speed, target, speed_max, acceleration_max;
};

// `over`: how many times faster than the limit the axis may start (a reduced limit).
Case random_case(std::mt19937& random, double over = 1) {
  const auto in = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
  Case c{};
  c.speed_max = in(0.5, 6);
  c.acceleration_max = in(2, 30);
  c.position = in(-4.7, 4.7);
  c.speed = in(-1, 1) * over * c.speed_max;
  // Every fourth has a near target, where the branches of the closed form meet.
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
  return axis_step(axis, static_cast<Real>(c.target), static_cast<Real>(c.speed_max),
                   static_cast<Real>(c.acceleration_max), static_cast<Real>(dt_s));
}

constexpr double kRange = 9.4;  // rad, of the positions and targets of random_case()

// Largest difference in position between one step and the same time in pieces, over `count` random cases.
template <class T>
double split_error(int count, double over, bool retarget) {
  std::mt19937 random(7);
  const auto in = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    Case c = random_case(random, over);
    typename T::Axis whole = start<T>(c);
    if (retarget) {  // start in the middle of another move
      whole = step<T>(whole, c, in(0, 0.8));
      c.target = in(-4.7, 4.7);
      c.speed_max = in(0.5, 6);
    }
    typename T::Axis pieces = whole;
    // Pieces of 2^-10 s are exact in float, so that both cover the same time.
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

TEST_CASE("a step of a + b equals a step of a and then one of b") {
  const double d = split_error<Double>(20'000, 1, false);
  const double f = split_error<Float>(20'000, 1, false);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 1e-6 * kRange);
}

TEST_CASE("a step can be split after a new target in the middle of a move") {
  const double d = split_error<Double>(20'000, 1, true);
  const double f = split_error<Float>(20'000, 1, true);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 1e-6 * kRange);
}

TEST_CASE("a step can be split while the axis is faster than a reduced limit") {
  const double d = split_error<Double>(20'000, 4, false);
  const double f = split_error<Float>(20'000, 4, false);
  MESSAGE("largest difference: ", d, " rad in double, ", f, " rad in float");
  CHECK(d < 1e-12);
  CHECK(f < 2e-5);  // such an axis travels up to ten times as far
}

TEST_CASE("no step breaks the limits of speed and acceleration") {
  std::mt19937 random(11);
  double speed_over = 0;         // beyond the limit, or beyond the speed at the start if that was higher
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
      // Position and speed match: no jump in position.
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

// An independent reference: the control law of the double integrator, applied every `h` seconds. Brakes when braking is
// just enough, else accelerates towards the target, never past the speed limit.
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

TEST_CASE("the closed form matches the control law applied in small steps") {
  std::mt19937 random(5);
  constexpr double kStepS = 2e-5;
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random, i % 4 == 0 ? 2.5 : 1);
    const double dt_s = std::uniform_real_distribution<double>(0.02, 2.5)(random);
    const f64::Axis exact = step<Double>(start<Double>(c), c, dt_s);
    worst = std::max(worst, std::abs(exact.position - by_small_steps(c, dt_s, kStepS).position));
  }
  MESSAGE("largest difference: ", worst, " rad with steps of ", kStepS, " s");
  CHECK(worst < 1e-3);  // at 20 rad/s, the fastest start, a step of 2e-5 s covers 4e-4 rad
}

TEST_CASE("a rest-to-rest move takes the textbook time") {
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

TEST_CASE("an axis that moves away from its target turns round and comes back") {
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
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(8), Real(0))));
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(8), Real(-1))));
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(8), kNan)));
  CHECK(same(axis_step(axis, Real(3), Real(0), Real(8), Real(1))));
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(0), Real(1))));
  CHECK(same(axis_step(axis, Real(3), kNan, Real(8), Real(1))));
  CHECK(same(axis_step(axis, Real(3), Real(2), kNan, Real(1))));
  CHECK(same(axis_step(axis, kNan, Real(2), Real(8), Real(1))));
  CHECK(same(axis_step(axis, kInf, Real(2), Real(8), Real(1))));
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(8), kInf)));
  for (const Real dt : {Real(60), Real(1e9)}) {
    const typename T::Axis there = axis_step(axis, Real(3), Real(2), Real(8), dt);
    CHECK(there.position == Real(3));
    CHECK(there.speed == Real(0));
  }
  axis.position = Real(3);
  axis.speed = Real(0);
  CHECK(same(axis_step(axis, Real(3), Real(2), Real(8), Real(0.01))));
}

TEST_CASE("no time, bad time and bad limits leave the axis alone, a long time brings it to the target") {
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

// Motors: the same axis with a stored last change.

template <class T>
typename T::MotorLimits limits_of(double speed_max, double acceleration_max) {
  typename T::MotorLimits limits;
  limits.speed_max = static_cast<typename T::Real>(speed_max);
  limits.acceleration_max = static_cast<typename T::Real>(acceleration_max);
  return limits;
}

template <class T>
typename T::Motor motor_at(double position) {
  if constexpr (std::is_same_v<T, Float>)
    return f32::motor_start(static_cast<float>(position));
  else
    return f64::motor_start(position);
}
template <class T>
typename T::Flex flex_at(double position) {
  if constexpr (std::is_same_v<T, Float>)
    return f32::flex_start(static_cast<float>(position));
  else
    return f64::flex_start(position);
}
template <class T>
typename T::MotorLimits limits_from_fade(double range, double fade_s, double acceleration_s) {
  using Real = typename T::Real;
  if constexpr (std::is_same_v<T, Float>)
    return f32::motor_limits(static_cast<Real>(range), static_cast<Real>(fade_s), static_cast<Real>(acceleration_s));
  else
    return f64::motor_limits(range, fade_s, acceleration_s);
}

// A motor with its flex, sent to random targets.
template <class T>
struct Follower {
  typename T::Motor motor = motor_at<T>(0);
  typename T::Flex flex = flex_at<T>(0);
  typename T::MotorLimits limits = limits_of<T>(4, 20);
  typename T::FlexLimits soft{};
  double range = kRange;
  bool vector = false;

  void go(typename T::Real target, glm::uvec2 dt_ns, typename T::MotorLimits with) {
    const typename T::Motor before = motor;
    motor = motor_step(motor, with, target, dt_ns);
    flex = flex_step(flex, soft, before, motor, with);
  }
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    // Holds, jumps, a fine walk and the ends of the range.
    const std::uint32_t part = change / 88 % 4;
    double share = chance(1, change);
    if (part == 0) share = chance(1, change / 44);
    if (part == 2) share = 0.5 + 0.001 * share;
    if (part == 3) share = change / 30 % 2;
    auto with = limits;
    if (vector) with = motor_vector(limits, static_cast<typename T::Real>(chance(2, change / 20)));
    go(static_cast<typename T::Real>(range * (share - 0.5)), dt_ns, with);
  }
  [[nodiscard]] double value() const { return static_cast<double>(flex.now.position); }
};

template <class T>
typename T::FlexLimits soft_of(double rate, double damping) {
  typename T::FlexLimits limits;
  limits.rate = static_cast<typename T::Real>(rate);
  limits.damping = static_cast<typename T::Real>(damping);
  return limits;
}

TEST_CASE_TEMPLATE("a motor is at the same place at 15 to 1000 frames a second over 60 s of demanding moves", T, Float,
                   Double) {
  Follower<T> rigid;
  CHECK(rate_spread(rigid) <= 1e-6 * kRange);
  rigid.vector = true;
  CHECK(rate_spread(rigid) <= 1e-6 * kRange);
  Follower<T> smooth;
  smooth.soft = soft_of<T>(25, 1);
  CHECK(rate_spread(smooth) <= 1e-6 * kRange);
  Follower<T> belt;
  belt.soft = soft_of<T>(157, 0.05);
  CHECK(rate_spread(belt) <= 1e-6 * kRange);
}

TEST_CASE_TEMPLATE("targets that change every millisecond give one motion at every frame rate", T, Float, Double) {
  Follower<T> motor;
  motor.soft = soft_of<T>(25, 1);
  CHECK(rate_spread(motor, 1'000'000) <= 1e-6 * kRange);
}

TEST_CASE_TEMPLATE("a motor's step of a + b equals its steps of a and b, from any state and up to 60 s each", T, Float,
                   Double) {
  std::mt19937_64 random(8);
  double worst = 0;
  for (int i = 0; i < 10'000; ++i) {
    Follower<T> whole;
    whole.soft = soft_of<T>(5 + 200 * chance(3, static_cast<std::uint32_t>(i)), i % 2 == 0 ? 1 : 0.05);
    whole.limits = limits_of<T>(0.5 + 6 * chance(4, static_cast<std::uint32_t>(i)), 2 + 30 * chance(5, 1));
    for (std::uint32_t k = 0; k < 3; ++k)
      whole.step(static_cast<std::uint32_t>(random()), words(random() % 400'000'000));
    Follower<T> pieces = whole;
    const auto a = static_cast<std::uint64_t>(random_ns(random));
    const auto b = static_cast<std::uint64_t>(random_ns(random));
    const auto change = static_cast<std::uint32_t>(random());
    whole.step(change, words(a + b));
    pieces.step(change, words(a));
    pieces.step(change, words(b));
    worst = std::max(worst, static_cast<double>(std::abs(whole.motor.now.position - pieces.motor.now.position)));
    worst = std::max(worst, static_cast<double>(std::abs(whole.flex.now.position - pieces.flex.now.position)));
  }
  CHECK(worst <= (std::is_same_v<T, Float> ? 1e-6 : 1e-12));
}

TEST_CASE_TEMPLATE("1e9 s bring a motor to its target and no time leaves it where it is", T, Float, Double) {
  Follower<T> motor;
  motor.soft = soft_of<T>(157, 0.05);
  motor.go(3, words(200'000'000), motor.limits);
  const Follower<T> before = motor;
  motor.go(3, words(0), motor.limits);
  CHECK(motor.motor.now.position == before.motor.now.position);
  CHECK(motor.flex.now.position == before.flex.now.position);
  motor.go(-2, words(0), motor.limits);  // a new target in no time
  CHECK(motor.motor.now.position == before.motor.now.position);
  motor.go(-2, words(1'000'000'000'000'000'000), motor.limits);
  CHECK(motor.motor.now.position == -2);
  CHECK(motor.flex.now.position == doctest::Approx(-2).epsilon(1e-9));
  CHECK(motor.flex.now.speed == doctest::Approx(0).epsilon(1e-9));
}

TEST_CASE("an invalid step becomes no time: negative, NaN, infinite") {
  for (const double dt : {-1.0, -1e-9, 0.0, std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300})
    CHECK(number(f64::time_ns(dt)) == 0);
  for (const float dt : {-1.0f, std::nanf(""), HUGE_VALF}) CHECK(number(f32::time_ns(dt)) == 0);
  CHECK(number(f64::time_ns(1e9)) == 1'000'000'000'000'000'000u);
  CHECK(number(f64::time_ns(0.25)) == 250'000'000u);
  CHECK(number(f32::time_ns(60)) == 60'000'000'000u);
}

TEST_CASE_TEMPLATE("a NaN target does not change the motor, and a motor without speed is at its target", T, Float,
                   Double) {
  Follower<T> motor;
  motor.go(1, words(100'000'000), motor.limits);
  const auto at = motor.motor.now.position;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    motor.go(static_cast<typename T::Real>(bad), words(100'000'000), motor.limits);
    CHECK(motor.motor.now.position == at);
  }
  motor.go(1, words(0), limits_of<T>(std::nan(""), 1));
  CHECK(motor.motor.now.position == at);
  motor.go(-3, words(0), limits_of<T>(0, 0));
  CHECK(motor.motor.now.position == -3);
  CHECK(motor.flex.now.position == -3);
}

TEST_CASE_TEMPLATE("a move over the whole range takes RealFade: 0.01 s, 1866 s, and with half of it or more for ramps",
                   T, Float, Double) {
  struct Row {
    double range, fade_s, acceleration_s;
  };
  const Row rows[] = {{540, 2.45, 0.4}, {540, 0.01, 0},  {540, 0.01, 0.002}, {9.4, 1866, 1},   {9.4, 1866, 0},
                      {250, 1.3, 0.65}, {250, 1.3, 0.9}, {250, 1.3, 5},      {1, 0.001, 0.01}, {90, 0.5, -1}};
  for (const Row& row : rows) {
    CAPTURE(row.fade_s);
    CAPTURE(row.acceleration_s);
    const auto limits = limits_from_fade<T>(row.range, row.fade_s, row.acceleration_s);
    const auto target = static_cast<typename T::Real>(row.range);
    const auto after = [&](double share) {
      return static_cast<double>(
          motor_step(motor_at<T>(0), limits, target, words(static_cast<std::uint64_t>(row.fade_s * share * 1e9)))
              .now.position);
    };
    CHECK(after(1.00001) == static_cast<double>(target));
    CHECK(after(0.999) < static_cast<double>(target));
    CHECK(after(0.5) == doctest::Approx(row.range / 2).epsilon(1e-5));  // symmetrical
    CHECK(after(0.25) > 0);
  }
}

TEST_CASE_TEMPLATE("RealFade 0, or an invalid time, is no motor", T, Float, Double) {
  for (const double fade : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    CHECK(limits_from_fade<T>(540, fade, 0.1).speed_max == 0);
    CHECK(motor_step(motor_at<T>(0), limits_from_fade<T>(540, fade, 0.1), 5, words(0)).now.position == 5);
  }
  CHECK(limits_from_fade<T>(std::nan(""), 1, 0.1).speed_max == 0);
}

TEST_CASE_TEMPLATE("from 65535 to 0 pan goes 540 degrees back through the middle, never the short way", T, Float,
                   Double) {
  const auto limits = limits_from_fade<T>(540, 2.45, 0.4);
  typename T::Motor pan = motor_at<T>(270);
  double way = 0;
  for (int i = 0; i < 300; ++i) {
    const auto before = pan.now.position;
    pan = motor_step(pan, limits, static_cast<typename T::Real>(-270), words(10'000'000));
    CHECK(pan.now.position <= before);
    way += static_cast<double>(before - pan.now.position);
    if (i == 122) CHECK(pan.now.position == doctest::Approx(0).scale(540).epsilon(0.01));
  }
  CHECK(way == doctest::Approx(540).epsilon(1e-5));
}

TEST_CASE("a stall of 60 s ends where 60 s of frames end") {
  Follower<Double> stalled;
  stalled.soft = soft_of<Double>(157, 0.05);
  stalled.go(1, words(300'000'000), stalled.limits);
  Follower<Double> running = stalled;
  stalled.go(4, words(60 * kSecondNs), stalled.limits);
  for (int i = 0; i < 3600; ++i) running.go(4, words(60 * kSecondNs / 3600), running.limits);
  CHECK(stalled.value() == doctest::Approx(running.value()).epsilon(1e-12));
}

TEST_CASE("vector mode uses the speed of its channel and changes it in the middle of a move") {
  Follower<Double> motor;
  double fastest = 0;
  for (int i = 0; i < 100; ++i) {
    motor.go(100, words(10'000'000), f64::motor_vector(motor.limits, 0.25));
    fastest = std::max(fastest, motor.motor.now.speed);
  }
  CHECK(fastest == doctest::Approx(1.0));
  for (int i = 0; i < 100; ++i) motor.go(100, words(10'000'000), f64::motor_vector(motor.limits, 1));
  CHECK(motor.motor.now.speed == doctest::Approx(4.0));
  for (int i = 0; i < 100; ++i) motor.go(100, words(10'000'000), f64::motor_vector(motor.limits, 0.5));
  CHECK(motor.motor.now.speed == doctest::Approx(2.0));
  motor.go(100, words(1'000'000'000'000'000), f64::motor_vector(motor.limits, 0));
  CHECK(motor.motor.now.position == 100);  // the slowest speed still arrives
}

// A reference for a load on a motor: RK4 in small steps over the motor's own path.
double flex_by_small_steps(const f64::Motor& from, f64::MotorLimits limits, f64::FlexLimits soft, f64::Axis x, double t,
                           int steps) {
  const auto u = [&](double at) {
    return f64::axis_step(from.now, from.target, limits.speed_max, limits.acceleration_max, at).position;
  };
  const double w = soft.rate;
  const double h = t / steps;
  const auto push = [&](double at, double position, double speed) {
    return w * w * (u(at) - position) - 2 * soft.damping * w * speed;
  };
  for (int i = 0; i < steps; ++i) {
    const double at = i * h;
    const double v1 = x.speed, a1 = push(at, x.position, x.speed);
    const double v2 = x.speed + h / 2 * a1, a2 = push(at + h / 2, x.position + h / 2 * v1, v2);
    const double v3 = x.speed + h / 2 * a2, a3 = push(at + h / 2, x.position + h / 2 * v2, v3);
    const double v4 = x.speed + h * a3, a4 = push(at + h, x.position + h * v3, v4);
    x.position += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    x.speed += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return x.position;
}

TEST_CASE("smoothing and belt match 20000 small steps of their equation") {
  double worst = 0;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const f64::MotorLimits limits = limits_of<Double>(1 + 4 * chance(1, i), 5 + 20 * chance(2, i));
    const f64::FlexLimits soft = soft_of<Double>(10 + 150 * chance(3, i), i % 3 == 0 ? 1 : 0.03 + 0.9 * chance(4, i));
    f64::Motor motor = f64::motor_start(0);
    motor.now.speed = limits.speed_max * (chance(5, i) * 4 - 2);  // faster than the limit, too, and away
    f64::Flex flex = f64::flex_start(0.2);
    flex.now.speed = -1;
    const double target = 4 * chance(6, i) - 2;
    const double t = 0.05 + 2 * chance(7, i);
    const f64::Motor after = f64::motor_step(motor, limits, target, f64::time_ns(t));
    flex = f64::flex_step(flex, soft, motor, after, limits);
    f64::Axis start;
    start.position = 0.2;
    start.speed = -1;
    motor.target = target;
    worst = std::max(worst, std::abs(flex.now.position - flex_by_small_steps(motor, limits, soft, start, t, 20'000)));
  }
  MESSAGE("largest difference: ", worst, " rad");
  CHECK(worst < 2e-8);
}

TEST_CASE("smoothing keeps speed, acceleration and jerk within bounds and does not overshoot") {
  Follower<Double> head;
  head.soft = soft_of<Double>(40, 1);
  constexpr double kDt = 1e-4;
  double speed = 0, acceleration = 0, jerk = 0, furthest = 0;
  double v_before = 0, a_before = 0;
  for (int i = 0; i < 20'000; ++i) {
    head.go(3, words(100'000), head.limits);
    const double a = (head.flex.now.speed - v_before) / kDt;
    if (i > 2) jerk = std::max(jerk, std::abs(a - a_before) / kDt);
    acceleration = std::max(acceleration, std::abs(a));
    speed = std::max(speed, std::abs(head.flex.now.speed));
    furthest = std::max(furthest, head.flex.now.position);
    v_before = head.flex.now.speed;
    a_before = a;
  }
  CHECK(speed <= 4 * (1 + 1e-9));
  CHECK(speed > 3.9);
  CHECK(acceleration <= 20 * (1 + 1e-6));
  CHECK(jerk <= 2 * 20 * 40 / std::exp(1.0) * 1.001);
  CHECK(furthest <= 3 + 1e-12);
  CHECK(head.flex.now.position == doctest::Approx(3).epsilon(1e-9));
}

TEST_CASE("a belt of 25 Hz and damping 0.05 rings at 25 Hz and dies away") {
  Follower<Double> head;
  head.soft = f64::flex_belt(25, 0.05);
  head.go(1, words(600'000'000), head.limits);  // arrives at 0.45 s
  REQUIRE(head.motor.now.position == 1);
  double before = 0, last_up_s = 0, first_up_s = 0, largest = 0;
  int ups = 0;
  for (int i = 1; i <= 4000; ++i) {
    head.go(1, words(100'000), head.limits);
    const double off = head.flex.now.position - 1;
    if (i < 400) largest = std::max(largest, std::abs(off));
    if (before < 0 && off >= 0) {
      last_up_s = i * 1e-4;
      if (ups++ == 0) first_up_s = last_up_s;
    }
    before = off;
  }
  CHECK((ups - 1) / (last_up_s - first_up_s) == doctest::Approx(25).epsilon(0.01));
  CHECK(largest > 1e-5);
  CHECK(std::abs(before) < 0.1 * largest);
}

TEST_CASE_TEMPLATE("every value is finite over random motors, limits and times", T, Float, Double) {
  std::mt19937_64 random(77);
  const double odd[] = {0, -0.0, 1, -1, 1e-30, 1e-7, 1e6, 1e9, 1e20, 1e29, 1e38, std::nan(""), HUGE_VAL, -HUGE_VAL};
  const auto any = [&] {
    return static_cast<typename T::Real>(random() % 3 == 0 ? odd[random() % std::size(odd)]
                                                           : chance(1, static_cast<std::uint32_t>(random())) * 10 - 5);
  };
  int bad = 0;
  Follower<T> motor;
  for (int i = 0, trials = hunt_trials(); i < trials; ++i) {
    if (i % 20 == 0) motor = Follower<T>();
    typename T::MotorLimits limits;
    limits.speed_max = any();
    limits.acceleration_max = any();
    motor.soft.rate = any();
    motor.soft.damping = any();
    const auto target = any();
    if (std::abs(target) > 1e9) continue;  // beyond any range of a fixture; NaN and infinity are included
    motor.go(target, words(random() >> (random() % 64)), limits);
    bad += !std::isfinite(motor.motor.now.position) || !std::isfinite(motor.flex.now.position);
  }
  CHECK(bad == 0);
}

TEST_CASE("tracking mode smooths the console's steps and lags by its time, vector mode does neither") {
  // A fader that moves 1 u/s in steps of 44 Hz. Both follow; they differ in the ripple of the speed.
  for (const bool tracking : {true, false}) {
    Follower<Double> head;
    head.limits = limits_of<Double>(10, 200);
    if (tracking) head.soft = f64::flex_smoothing(0.3);
    double least = 1e9, most = -1e9, lag = 0;
    for (int frame = 0; frame < 440; ++frame) {
      const double target = frame / 44.0;
      for (int part = 0; part < 10; ++part) {
        head.go(target, words(kSecondNs / 440), head.limits);
        if (frame < 220) continue;
        least = std::min(least, head.flex.now.speed);
        most = std::max(most, head.flex.now.speed);
      }
      lag = target + 1 / 44.0 - head.value();
    }
    CHECK((most - least < 0.1) == tracking);
    CHECK(lag == doctest::Approx(tracking ? 0.3 : 0.02).epsilon(0.2));
  }
}

// A wheel of eight slots, one slot at a time, sometimes reversed before it arrives.
template <class T>
struct WheelTurner {
  typename T::Motor motor = motor_at<T>(0);
  typename T::MotorLimits limits = limits_of<T>(16, 60);
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    const auto slot = static_cast<typename T::Real>(f64::hash_two(7, change / 6) % 8);
    motor = motor_step(motor, limits, motor_nearest(motor, slot, typename T::Real(8)), dt_ns);
  }
  [[nodiscard]] double value() const { return static_cast<double>(motor.now.position); }
};

TEST_CASE_TEMPLATE("a wheel turns the same way round at 15 to 1000 frames a second", T, Float, Double) {
  CHECK(rate_spread(WheelTurner<T>{}) <= 1e-6 * 8);
}

TEST_CASE("a wheel moves the shorter way to a slot, and keeps the direction during the move") {
  f64::Motor wheel = f64::motor_start(1);
  CHECK(f64::motor_nearest(wheel, 7, 8) == -1);
  CHECK(f64::motor_nearest(wheel, 3, 8) == 3);
  CHECK(f64::motor_nearest(wheel, 7, 0) == 7);
  wheel.target = -1;
  wheel.now.position = 5;  // moved far beyond: 7 would be nearer now
  CHECK(f64::motor_nearest(wheel, 7, 8) == -1);
  CHECK(f64::motor_nearest(wheel, 6, 8) == 6);
}

}  // namespace
}  // namespace footlight
