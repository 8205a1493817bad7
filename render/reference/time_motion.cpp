// A pan axis of 540 degrees and 4 rad/s with random targets, against an integrator that finds each event by bisection.
#include <algorithm>
#include <cmath>
#include <utility>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr double kRangeRad = 9.42477796076938;  // 540 degrees
constexpr double kSpeedMax = 4.0;               // rad/s: 540 degrees in 2.4 s
constexpr double kFineS = 1e-17;                // resolution of the judge's bisection
constexpr double kCoarseS = 1e-15;

double place_of(double level) { return static_cast<double>(static_cast<float>((level - 0.5) * kRangeRad)); }

std::vector<double> judged(const Frames& show, double a_max, double resolution_s) {
  AxisJudge axis(0, kSpeedMax, a_max, resolution_s);
  std::vector<double> positions;
  for (std::size_t i = 0; i < show.size(); ++i) {
    axis.advance(place_of(show.input[i]), Wide(show.start_ns[i + 1] - show.start_ns[i]) * 1e-9L);
    positions.push_back(axis.position());
  }
  return positions;
}

// The same, but every new target takes effect when it arrives and not at the next frame.
std::vector<double> judged_live(const Frames& show, std::span<const double> levels, double a_max) {
  AxisJudge axis(0, kSpeedMax, a_max, kFineS);
  std::vector<double> positions;
  std::int64_t now_ns = 0;
  for (std::size_t i = 0; i < show.size(); ++i) {
    while (now_ns < show.start_ns[i + 1]) {
      const std::int64_t period = now_ns / kLevelsPeriodNs;
      const std::int64_t until_ns = std::min((period + 1) * kLevelsPeriodNs, show.start_ns[i + 1]);
      axis.advance(place_of(levels[static_cast<std::size_t>(period)]), Wide(until_ns - now_ns) * 1e-9L);
      now_ns = until_ns;
    }
    positions.push_back(axis.position());
  }
  return positions;
}

// The control law as common programs implement it.
struct MotionRival {
  double x = 0;
  double v = 0;

  // Full acceleration towards the point at which braking would stop on the target.
  static double push(double x, double v, double target, double a_max) {
    const double miss = target - x - v * std::abs(v) / (2 * a_max);
    if (std::abs(v) >= kSpeedMax && miss * v > 0) return 0;
    return miss > 0 ? a_max : miss < 0 ? -a_max : 0;
  }
  void limit() { v = std::clamp(v, -kSpeedMax, kSpeedMax); }
  // If the target can be reached at rest within one step, goes there. Without this the other methods oscillate around
  // it for ever.
  bool settles(double target, double a_max, double h) {
    if (!(std::abs(target - x) <= a_max * h * h && std::abs(v) <= a_max * h)) return false;
    x = target;
    v = 0;
    return true;
  }
  void explicit_euler(double target, double a_max, double h) {
    if (settles(target, a_max, h)) return;
    const double a = push(x, v, target, a_max);
    x += v * h;
    v += a * h;
    limit();
  }
  void semi_implicit_euler(double target, double a_max, double h) {
    if (settles(target, a_max, h)) return;
    v += push(x, v, target, a_max) * h;
    limit();
    x += v * h;
  }
  void rk4(double target, double a_max, double h) {
    if (settles(target, a_max, h)) return;
    const double a1 = push(x, v, target, a_max);
    const double v2 = v + a1 * h / 2;
    const double a2 = push(x + v * h / 2, v2, target, a_max);
    const double v3 = v + a2 * h / 2;
    const double a3 = push(x + v2 * h / 2, v3, target, a_max);
    const double v4 = v + a3 * h;
    const double a4 = push(x + v3 * h, v4, target, a_max);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    limit();
  }
  // Plans the speed of a trapezoid for the remaining distance at every step, and follows it with the acceleration
  // limit.
  void trapezoid(double target, double a_max, double h) {
    if (settles(target, a_max, h)) return;
    const double way = target - x;
    const double wanted = std::copysign(std::min(kSpeedMax, std::sqrt(2 * a_max * std::abs(way))), way);
    v += std::clamp(wanted - v, -a_max * h, a_max * h);
    x += v * h;
  }
};

void add_motion_scene(const TimeReportOptions& options, std::span<const double> levels, double tau_ms, double fps,
                      TimeReport& report, JudgeError& own) {
  const Frames show = frames_of(options.seconds, fps, levels);
  const auto a_max = static_cast<double>(static_cast<float>(kSpeedMax / (tau_ms * 1e-3)));
  TimeScene scene{.model = "motion",
                  .unit = "range",
                  .tau_ms = tau_ms,
                  .fps = fps,
                  .seconds = options.seconds,
                  .judge = judged(show, a_max, kFineS),
                  .unit_scale = 1 / kRangeRad};
  for (const double level : levels) scene.span.push_back(place_of(level));
  const std::vector<double> coarse = judged(show, a_max, kCoarseS);
  for (std::size_t i = 0; i < show.size(); ++i) {
    own.own = std::max(own.own, std::abs(scene.judge[i] - coarse[i]) / kRangeRad);
  }
  TimeBench bench(options, report.rows);
  bench.add(scene, "motor f32", 1, [&] {
    return [&, motor = f32::motor_start(0)](std::size_t i) mutable {
      const f32::MotorLimits limits{static_cast<float>(kSpeedMax), static_cast<float>(a_max)};
      motor = f32::motor_step(motor, limits, static_cast<float>(place_of(show.input[i])), dt_of(show, i));
      return static_cast<double>(motor.now.position);
    };
  });
  const auto motor_f64 = [&] {
    return [&, motor = f64::motor_start(0)](std::size_t i) mutable {
      motor = f64::motor_step(motor, {kSpeedMax, a_max}, place_of(show.input[i]), dt_of(show, i));
      return motor.now.position;
    };
  };
  bench.add(scene, "motor f64", 1, motor_f64);
  TimeScene live = scene;
  live.judge = judged_live(show, levels, a_max);
  bench.add(live, "hold", 1, motor_f64);

  using Method = void (MotionRival::*)(double, double, double);
  const std::pair<const char*, Method> rivals[] = {{"explicit Euler", &MotionRival::explicit_euler},
                                                   {"semi-implicit Euler", &MotionRival::semi_implicit_euler},
                                                   {"RK4", &MotionRival::rk4},
                                                   {"trapezoid anew", &MotionRival::trapezoid}};
  for (const auto& [name, method] : rivals) {
    for (const int substeps : options.substeps) {
      bench.add(scene, name, substeps, [&, m = method] {
        return [&, m, rival = MotionRival{}](std::size_t i) mutable {
          const double h = show.dt_s[i] / substeps;
          for (int s = 0; s < substeps; ++s) (rival.*m)(place_of(show.input[i]), a_max, h);
          return rival.x;
        };
      });
    }
  }
  // Knobs: the share of the distance that each frame covers; a time constant in ms.
  for (const double factor : {0.05, 0.1, 0.2}) {
    bench.add(scene, "lerp a frame", factor, [&] {
      return [&, x = 0.0](std::size_t i) mutable { return x += (place_of(show.input[i]) - x) * factor; };
    });
  }
  for (const double smoothing_ms : {50.0, 100.0, 200.0, 400.0}) {
    bench.add(scene, "exponential smoothing", smoothing_ms, [&] {
      return [&, x = 0.0](std::size_t i) mutable {
        return x += (place_of(show.input[i]) - x) * -std::expm1(-show.dt_s[i] / (smoothing_ms * 1e-3));
      };
    });
  }
}

}  // namespace

void report_motion(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own{.model = "motion", .judge = "events by bisection to 1e-17 s, against 1e-15 s", .unit = "range"};
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      add_motion_scene(options, levels, tau_ms, fps, report, own);
    }
  }
  // The second judge has no closed form: steps of a microsecond that accelerate while braking would stop short, on one
  // move.
  const auto a_max = static_cast<double>(static_cast<float>(kSpeedMax / (options.tau_ms.back() * 1e-3)));
  AxisJudge axis(0, kSpeedMax, a_max, kFineS);
  MotionRival rival;
  const double target = place_of(0.8);
  constexpr int kSteps = 400'000;
  own.second = "semi-implicit Euler in steps of 1 us, one move of 0.4 s";
  for (int i = 0; i < kSteps; ++i) {
    rival.semi_implicit_euler(target, a_max, 1e-6);
    if ((i + 1) % 40'000 != 0) continue;
    axis.advance(target, Wide(0.04));
    own.difference = std::max(own.difference, std::abs(rival.x - axis.position()) / kRangeRad);
  }
  report.judges.push_back(own);
}

}  // namespace footlight::render
