// Pulses and random flashes, arcs that strike and run up, and motors with jerk smoothing.
#include <algorithm>
#include <cmath>
#include <utility>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

// ---- Pulses: triangles that fill the duty, one per period; random ones start at a random place in their period ----

constexpr double kPulseDuty = 0.375;
constexpr std::uint32_t kPulseSeed = 77;

// The level at time t of a triangle that starts at 0 and has this length.
Wide triangle(Wide t, Wide length) {
  if (!(t > 0) || !(t < length)) return 0;
  return t < length / 2 ? t / (length / 2) : (length - t) / (length / 2);
}

// The start of a pulse in its period, in periods. Random pulses use the hash that sim/shared/shutter.h names.
Wide pulse_place(bool random, std::int64_t period) {
  if (!random) return 0;
  const auto drawn = f64::hash_two(kPulseSeed, static_cast<std::uint32_t>(period)) >> 8u;
  return Wide(1 - kPulseDuty) * static_cast<Wide>(drawn) / 16777216;
}

// The mean over from..to, in periods: the sum over the straight pieces of each pulse that overlaps.
Wide pulses_judged(bool random, Wide from, Wide to) {
  Wide light = 0;
  for (auto period = static_cast<std::int64_t>(std::floor(from)) - 1; static_cast<Wide>(period) < to; ++period) {
    const Wide begin = static_cast<Wide>(period) + pulse_place(random, period);
    const Wide length = kPulseDuty;
    const Wide knots[] = {begin, begin + length / 2, begin + length};
    for (int piece = 0; piece < 2 && period >= 0; ++piece) {
      const Wide a = std::max(from, knots[piece]);
      const Wide b = std::min(to, knots[piece + 1]);
      if (b > a) light += (b - a) * triangle((a + b) / 2 - begin, length);
    }
  }
  return light / (to - from);
}

// The same by the midpoint rule.
double pulses_sampled(bool random, Wide from, Wide to, int samples) {
  Wide light = 0;
  for (int s = 0; s < samples; ++s) {
    const Wide at = from + (to - from) * (static_cast<Wide>(s) + 0.5L) / samples;
    const auto period = static_cast<std::int64_t>(std::floor(at));
    light += triangle(at - static_cast<Wide>(period) - pulse_place(random, period), kPulseDuty);
  }
  return static_cast<double>(light / samples);
}

void report_pulses(const char* model, bool random, const TimeReportOptions& options, TimeReport& report) {
  constexpr std::size_t kSecondFrames = 60;
  constexpr int kSecondSamples = 20'000;
  const std::vector<double> no_levels(inputs_needed(options.seconds), 0);
  JudgeError own{.model = model,
                 .judge = "straight pieces of each pulse in long double",
                 .own = 0x1p-53,
                 .second = "20,000 midpoints per frame, 60 frames",
                 .unit = "share"};
  TimeBench bench(options, report.rows);
  for (const double pulse_hz : options.strobe_hz) {
    const auto hz = static_cast<float>(pulse_hz);
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, no_levels);
      TimeScene scene{.model = model,
                      .unit = "share",
                      .tau_ms = 1000 / pulse_hz,
                      .fps = fps,
                      .seconds = options.seconds,
                      .span = {0, 1}};
      const auto periods = [&](std::size_t i) { return Wide(hz) * Wide(show.start_ns[i]) * 1e-9L; };
      for (std::size_t i = 0; i < show.size(); ++i) {
        scene.judge.push_back(static_cast<double>(pulses_judged(random, periods(i), periods(i + 1))));
        if (i >= kSecondFrames) continue;
        const double sampled = pulses_sampled(random, periods(i), periods(i + 1), kSecondSamples);
        own.difference = std::max(own.difference, std::abs(sampled - scene.judge.back()));
      }
      bench.add(scene, "exposure integral f32", 1, [&] {
        f32::ShutterParams params{};
        params.kind = random ? f32::kShutterRandomPulse : f32::kShutterPulse;
        params.rate_hz = hz;
        params.duty = static_cast<float>(kPulseDuty);
        params.seed = kPulseSeed;
        return [&, params, shutter = f32::shutter_begin()](std::size_t i) mutable {
          return static_cast<double>(f32::shutter_step(shutter, params, dt_of(show, i)));
        };
      });
      bench.add(scene, "exposure integral f64", 1, [&] {
        f64::ShutterParams params{};
        params.kind = random ? f64::kShutterRandomPulse : f64::kShutterPulse;
        params.rate_hz = static_cast<double>(hz);
        params.duty = kPulseDuty;
        params.seed = kPulseSeed;
        return [&, params, shutter = f64::shutter_begin()](std::size_t i) mutable {
          return f64::shutter_step(shutter, params, dt_of(show, i));
        };
      });
      for (const int samples : options.substeps) {
        bench.add(scene, "point samples", samples, [&, samples] {
          return [&, samples](std::size_t i) {
            double light = 0;
            for (int s = 0; s < samples; ++s) {
              const double t_s = static_cast<double>(show.start_ns[i]) * 1e-9 + (s + 0.5) / samples * show.dt_s[i];
              const double at = static_cast<double>(hz) * t_s;
              const double period = std::floor(at);
              const auto place = static_cast<double>(pulse_place(random, static_cast<std::int64_t>(period)));
              const double x = (at - period - place) / kPulseDuty;
              light += x > 0 && x < 1 ? 1 - std::abs(2 * x - 1) : 0;
            }
            return light / samples;
          };
        });
      }
    }
  }
  report.judges.push_back(own);
}

// ---- Discharge: warm' = (1 - warm) / run-up while the arc burns, else -warm / cooling ----

struct ArcLaw {
  double ignite_s = 0.15;
  double run_up_s = 1;
  double cool_s = 2;
  double restrike_warm = 0.25;
  double first_light = 0.125;
};

// Fixed steps with a state machine, as common programs use them; with short steps it is the judge.
template <class Number>
struct ArcSteps {
  ArcLaw law;
  Number warm = 0;
  Number ignites_s = 0;  // time since the lockout ended
  bool lit = false;
  bool powered = false;

  [[nodiscard]] Number light() const {
    return lit ? Number(1) - (Number(1) - Number(law.first_light)) * (Number(1) - warm) : Number(0);
  }
  [[nodiscard]] Number slope(Number at) const {
    return lit ? (Number(1) - at) / Number(law.run_up_s) : -at / Number(law.cool_s);
  }
  void rk4(Number h) {
    const Number a = slope(warm), b = slope(warm + a * h / 2), c = slope(warm + b * h / 2), d = slope(warm + c * h);
    warm += (a + 2 * b + 2 * c + d) * h / 6;
  }
  void euler(Number h) { warm += slope(warm) * h; }
  void power(bool on) {
    if (on == powered) return;
    powered = on;
    ignites_s = 0;
    if (!on) lit = false;
  }
};

// Returns the mean light over dt_s, by RK4 in steps of at most h_s. Steps end where the lockout ends (found by
// bisection) and where the arc strikes.
Wide arc_judged(ArcSteps<Wide>& arc, bool on, Wide dt_s, Wide h_s) {
  Wide light = 0;
  arc.power(on);
  for (Wide left_s = dt_s; left_s > 0;) {
    Wide h = std::min(left_s, h_s);
    bool strikes = false;
    if (arc.powered && !arc.lit) {
      if (arc.warm > arc.law.restrike_warm) {
        ArcSteps<Wide> there = arc;
        there.rk4(h);
        if (there.warm < arc.law.restrike_warm) {  // the lockout ends within this step
          Wide low = 0, high = h;
          for (int i = 0; i < 80; ++i) {
            const Wide middle = (low + high) / 2;
            ArcSteps<Wide> trial = arc;
            trial.rk4(middle);
            (trial.warm > arc.law.restrike_warm ? low : high) = middle;
          }
          h = high;
        }
      } else {
        const Wide wait_s = Wide(arc.law.ignite_s) - arc.ignites_s;
        strikes = wait_s <= h;
        h = std::min(h, wait_s);
        arc.ignites_s += h;
      }
    }
    const Wide before = arc.light();
    ArcSteps<Wide> middle = arc;
    middle.rk4(h / 2);
    arc.rk4(h);
    light += (before + 4 * middle.light() + arc.light()) * h / 6;  // Simpson
    if (strikes) arc.lit = true;
    left_s -= h;
    if (h == 0 && !strikes) break;
  }
  return light / dt_s;
}

std::vector<double> arc_judged_show(const ArcLaw& law, const Frames& show, Wide h_s) {
  std::vector<double> values;
  ArcSteps<Wide> arc{.law = law};
  for (std::size_t i = 0; i < show.size(); ++i)
    values.push_back(static_cast<double>(arc_judged(arc, show.input[i] > 0.5, show.dt_s[i], h_s)));
  return values;
}

// ---- A motor with jerk smoothing ----

constexpr double kFadeS = 2.45;
constexpr double kAccelerationS = 0.4;

// x'' + 2 w x' + w^2 (x - u) = 0 with the motor's position u from AxisJudge, by RK4 in steps of 1 / (w steps).
std::vector<double> jerk_judged(const Frames& show, double w, int steps) {
  const f64::MotorLimits limits = f64::motor_limits(1, kFadeS, kAccelerationS);
  AxisJudge motor(0, limits.speed_max, limits.acceleration_max, 1e-12);
  Wide x = 0, v = 0;
  std::vector<double> values;
  const Wide rate = w;
  for (std::size_t i = 0; i < show.size(); ++i) {
    const auto count = static_cast<int>(std::ceil(show.dt_s[i] * w * steps));
    const Wide h = Wide(show.dt_s[i]) / count;
    const auto pull = [&](Wide at, Wide speed, Wide u) { return rate * rate * (u - at) - 2 * rate * speed; };
    for (int s = 0; s < count; ++s) {
      const Wide u0 = motor.position();
      motor.advance(show.input[i], h / 2);
      const Wide u1 = motor.position();
      motor.advance(show.input[i], h / 2);
      const Wide u2 = motor.position();
      const Wide a1 = pull(x, v, u0), v2 = v + a1 * h / 2;
      const Wide a2 = pull(x + v * h / 2, v2, u1), v3 = v + a2 * h / 2;
      const Wide a3 = pull(x + v2 * h / 2, v3, u1), v4 = v + a3 * h;
      const Wide a4 = pull(x + v3 * h, v4, u2);
      x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    values.push_back(static_cast<double>(x));
  }
  return values;
}

// The second judge: the matrix exponential with u constant during each step, at its value in the middle.
double jerk_difference(const Frames& show, double w, const std::vector<double>& judge) {
  constexpr std::size_t kFrames = 100;
  const f64::MotorLimits limits = f64::motor_limits(1, kFadeS, kAccelerationS);
  AxisJudge motor(0, limits.speed_max, limits.acceleration_max, 1e-12);
  SpringJudge spring{.stiffness = Wide(w) * Wide(w), .damping = 2 * Wide(w)};
  double difference = 0;
  for (std::size_t i = 0; i < std::min(kFrames, show.size()); ++i) {
    const auto count = static_cast<int>(std::ceil(show.dt_s[i] * w * 100)) + 20;
    const Wide h = Wide(show.dt_s[i]) / count;
    for (int s = 0; s < count; ++s) {
      motor.advance(show.input[i], h / 2);
      const Wide u = motor.position();
      motor.advance(show.input[i], h / 2);
      spring.advance(u, h);
    }
    difference = std::max(difference, std::abs(static_cast<double>(spring.x) - judge[i]));
  }
  return difference;
}

struct JerkRival {
  f64::Motor motor = f64::motor_start(0);
  double x = 0;
  double v = 0;

  double drive(const f64::MotorLimits& limits, double target, double h) {
    motor = f64::motor_step(motor, limits, target, f64::time_ns(h));
    return motor.now.position;
  }
  void semi_implicit_euler(double w, double u, double h) {
    v += (w * w * (u - x) - 2 * w * v) * h;
    x += v * h;
  }
  void two_lerps(double w, double u, double h) {
    const double share = std::min(w * h, 1.0);
    v += (u - v) * share;  // v is the first pole here
    x += (v - x) * share;
  }
};

}  // namespace

void report_pulse(const TimeReportOptions& options, TimeReport& report) {
  report_pulses("pulse", false, options, report);
  report_pulses("random-pulse", true, options, report);
}

void report_discharge(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = flashes_of(options.seconds, options.seed);
  JudgeError own{.model = "discharge",
                 .judge = "RK4 and Simpson with events, long double, steps of tau / 50",
                 .second = "the same in steps of tau / 20, ends of events found anew",
                 .unit = "full"};
  TimeBench bench(options, report.rows);
  for (const double tau_ms : options.tau_ms) {
    ArcLaw law;
    // Exact floats, so that float and double simulate the same lamp.
    law.ignite_s = 0.15625;
    law.run_up_s = static_cast<double>(static_cast<float>(tau_ms * 1e-3));
    law.cool_s = 2 * law.run_up_s;
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, levels);
      TimeScene scene{.model = "discharge",
                      .unit = "full",
                      .tau_ms = tau_ms,
                      .fps = fps,
                      .seconds = options.seconds,
                      .judge = arc_judged_show(law, show, law.run_up_s / 50),
                      .span = {0, 1}};
      const std::vector<double> finer = arc_judged_show(law, show, law.run_up_s / 80);
      const std::vector<double> coarse = arc_judged_show(law, show, law.run_up_s / 20);
      for (std::size_t i = 0; i < show.size(); ++i) {
        own.own = std::max(own.own, std::abs(finer[i] - scene.judge[i]));
        own.difference = std::max(own.difference, std::abs(coarse[i] - scene.judge[i]));
      }
      bench.add(scene, "exact f32", 1, [&] {
        const f32::DischargeType type{static_cast<float>(law.ignite_s), static_cast<float>(law.run_up_s),
                                      static_cast<float>(law.cool_s), static_cast<float>(law.restrike_warm),
                                      static_cast<float>(law.first_light)};
        return [&, type, lamp = f32::discharge_start()](std::size_t i) mutable {
          return static_cast<double>(f32::discharge_step(lamp, type, show.input[i] > 0.5 ? 1u : 0u, dt_of(show, i)));
        };
      });
      bench.add(scene, "exact f64", 1, [&] {
        const f64::DischargeType type{law.ignite_s, law.run_up_s, law.cool_s, law.restrike_warm, law.first_light};
        return [&, type, lamp = f64::discharge_start()](std::size_t i) mutable {
          return f64::discharge_step(lamp, type, show.input[i] > 0.5 ? 1u : 0u, dt_of(show, i));
        };
      });
      bench.add(scene, "on and off", 1, [&] { return [&](std::size_t i) { return show.input[i] > 0.5 ? 1.0 : 0.0; }; });
      for (const bool fourth : {false, true}) {
        for (const int count : options.substeps) {
          bench.add(scene, fourth ? "RK4, events polled" : "explicit Euler, events polled", count, [&, fourth, count] {
            return [&, fourth, count, arc = ArcSteps<double>{.law = law}](std::size_t i) mutable {
              arc.power(show.input[i] > 0.5);
              const double h = show.dt_s[i] / count;
              double light = 0;
              for (int s = 0; s < count; ++s) {
                if (arc.powered && !arc.lit && arc.warm <= law.restrike_warm) {
                  arc.ignites_s += h;
                  arc.lit = arc.ignites_s >= law.ignite_s;
                }
                const double before = arc.light();
                fourth ? arc.rk4(h) : arc.euler(h);
                light += (before + arc.light()) / 2;
              }
              return light / count;
            };
          });
        }
      }
    }
  }
  report.judges.push_back(own);
}

void report_jerk(const TimeReportOptions& options, TimeReport& report) {
  constexpr int kSteps = 60;
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own{.model = "jerk",
                 .judge = "RK4 behind the motor's events, steps of lag / 120, against lag / 40",
                 .second = "matrix exponential, the motor at the middle of steps, 100 frames",
                 .unit = "range"};
  TimeBench bench(options, report.rows);
  const f64::MotorLimits limits = f64::motor_limits(1, kFadeS, kAccelerationS);
  const f32::MotorLimits limits_f =
      f32::motor_limits(1, static_cast<float>(kFadeS), static_cast<float>(kAccelerationS));
  for (const double tau_ms : options.tau_ms) {
    const double w = 2 / (tau_ms * 1e-3);
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, levels);
      TimeScene scene{.model = "jerk",
                      .unit = "range",
                      .tau_ms = tau_ms,
                      .fps = fps,
                      .seconds = options.seconds,
                      .judge = jerk_judged(show, w, kSteps)};
      const std::vector<double> coarse = jerk_judged(show, w, kSteps / 3);
      for (std::size_t i = 0; i < show.size(); ++i) own.own = std::max(own.own, std::abs(coarse[i] - scene.judge[i]));
      own.difference = std::max(own.difference, jerk_difference(show, w, scene.judge));
      bench.add(scene, "exact f32", 1, [&] {
        const f32::FlexLimits soft = f32::flex_smoothing(static_cast<float>(tau_ms * 1e-3));
        return [&, soft, motor = f32::motor_start(0), flex = f32::flex_start(0)](std::size_t i) mutable {
          const f32::Motor before = motor;
          motor = f32::motor_step(motor, limits_f, static_cast<float>(show.input[i]), dt_of(show, i));
          flex = f32::flex_step(flex, soft, before, motor, limits_f);
          return static_cast<double>(flex.now.position);
        };
      });
      bench.add(scene, "exact f64", 1, [&] {
        const f64::FlexLimits soft = f64::flex_smoothing(tau_ms * 1e-3);
        return [&, soft, motor = f64::motor_start(0), flex = f64::flex_start(0)](std::size_t i) mutable {
          const f64::Motor before = motor;
          motor = f64::motor_step(motor, limits, show.input[i], dt_of(show, i));
          flex = f64::flex_step(flex, soft, before, motor, limits);
          return flex.now.position;
        };
      });
      bench.add(scene, "none", 1, [&] {
        return [&, rival = JerkRival{}](std::size_t i) mutable {
          return rival.drive(limits, show.input[i], show.dt_s[i]);
        };
      });
      using Method = void (JerkRival::*)(double, double, double);
      const std::pair<const char*, Method> rivals[] = {{"two lerps with dt", &JerkRival::two_lerps},
                                                       {"semi-implicit Euler", &JerkRival::semi_implicit_euler}};
      for (const auto& [name, method] : rivals) {
        for (const int count : options.substeps) {
          bench.add(scene, name, count, [&, m = method, count] {
            return [&, m, count, rival = JerkRival{}](std::size_t i) mutable {
              const double h = show.dt_s[i] / count;
              for (int s = 0; s < count; ++s) (rival.*m)(w, rival.drive(limits, show.input[i], h), h);
              return rival.x;
            };
          });
        }
      }
    }
  }
  report.judges.push_back(own);
}

}  // namespace footlight::render
