// Two poles: the smoothing of levels (critically damped) and a load on a belt (weakly damped).
#include <algorithm>
#include <cmath>
#include <utility>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr double kBeltDamping = 0.05;

// x'' + 2 damping rate x' + rate^2 (x - u) = 0.
struct Spring {
  double rate = 0;
  double damping = 1;
};

struct SpringRival {
  double x = 0;
  double v = 0;

  static double pull(const Spring& s, double x, double v, double u) {
    return s.rate * s.rate * (u - x) - 2 * s.damping * s.rate * v;
  }
  void explicit_euler(const Spring& s, double u, double h) {
    const double a = pull(s, x, v, u);
    x += v * h;
    v += a * h;
  }
  void semi_implicit_euler(const Spring& s, double u, double h) {
    v += pull(s, x, v, u) * h;
    x += v * h;
  }
  void implicit_euler(const Spring& s, double u, double h) {
    const double w = s.rate * h;
    v = (v + s.rate * w * (u - x)) / (1 + 2 * s.damping * w + w * w);
    x += v * h;
  }
  void rk4(const Spring& s, double u, double h) {
    const double a1 = pull(s, x, v, u);
    const double v2 = v + a1 * h / 2;
    const double a2 = pull(s, x + v * h / 2, v2, u);
    const double v3 = v + a2 * h / 2;
    const double a3 = pull(s, x + v2 * h / 2, v3, u);
    const double v4 = v + a3 * h;
    const double a4 = pull(s, x + v3 * h, v4, u);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  // The critically damped step of game engines: exp(-z) as a rational function (T. Lowe, Game Programming Gems 4, 2004,
  // chapter 1.10).
  void rational(const Spring& s, double u, double h) {
    const double z = s.rate * h;
    const double gain = 1 / (1 + z + 0.48 * z * z + 0.235 * z * z * z);
    const double away = x - u;
    const double push = (v + s.rate * away) * h;
    v = (v - s.rate * push) * gain;
    x = u + (away + push) * gain;
  }
};

std::vector<double> judged(const Spring& spring, const Frames& show, int halve_until) {
  SpringJudge judge{.stiffness = Wide(spring.rate) * Wide(spring.rate),
                    .damping = 2 * Wide(spring.damping) * Wide(spring.rate),
                    .halve_until = halve_until};
  std::vector<double> values;
  for (std::size_t i = 0; i < show.size(); ++i) {
    judge.advance(show.input[i], show.dt_s[i]);
    values.push_back(static_cast<double>(judge.x));
  }
  return values;
}

// The second judge: RK4 in steps of a thousandth of the time constant, over the first frames.
double rk4_difference(const Spring& spring, const Frames& show, const std::vector<double>& judge) {
  constexpr std::size_t kFrames = 100;
  SpringRival rival;
  double difference = 0;
  for (std::size_t i = 0; i < std::min(kFrames, show.size()); ++i) {
    const double steps = std::ceil(show.dt_s[i] * spring.rate * 1000);
    for (double s = 0; s < steps; ++s) rival.rk4(spring, show.input[i], show.dt_s[i] / steps);
    difference = std::max(difference, std::abs(rival.x - judge[i]));
  }
  return difference;
}

using SpringMethod = void (SpringRival::*)(const Spring&, double, double);

struct Case {
  TimeScene scene;
  Frames show;
  Spring spring;
};

Case case_of(const char* model, const TimeReportOptions& options, std::span<const double> levels, double tau_ms,
             double fps, double damping, JudgeError& own) {
  Case made{.scene = {.model = model, .unit = "full", .tau_ms = tau_ms, .fps = fps, .seconds = options.seconds},
            .show = frames_of(options.seconds, fps, levels),
            .spring = {1 / (tau_ms * 1e-3), damping}};
  constexpr int kHalveUntil = 1;
  constexpr int kHalveFurther = 6;
  made.scene.judge = judged(made.spring, made.show, kHalveUntil);
  const std::vector<double> fine = judged(made.spring, made.show, kHalveFurther);
  for (std::size_t i = 0; i < fine.size(); ++i) own.own = std::max(own.own, std::abs(fine[i] - made.scene.judge[i]));
  own.difference = std::max(own.difference, rk4_difference(made.spring, made.show, made.scene.judge));
  return made;
}

void add_rivals(const Case& c, std::span<const std::pair<const char*, SpringMethod>> rivals,
                std::span<const int> substeps, TimeBench& bench) {
  for (const auto& [name, method] : rivals) {
    for (const int count : substeps) {
      bench.add(c.scene, name, count, [&, m = method, count] {
        return [&, m, count, rival = SpringRival{}](std::size_t i) mutable {
          const double h = c.show.dt_s[i] / count;
          for (int s = 0; s < count; ++s) (rival.*m)(c.spring, c.show.input[i], h);
          return rival.x;
        };
      });
    }
  }
}

JudgeError judge_of(const char* model) {
  return {.model = model,
          .judge = "matrix exponential by Taylor series, steps halved 5 times more",
          .second = "RK4 in steps of tau / 1000, 100 frames",
          .unit = "full"};
}

}  // namespace

void report_smoothing(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own = judge_of("smoothing");
  TimeBench bench(options, report.rows);
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Case c = case_of("smoothing", options, levels, tau_ms, fps, 1, own);
      bench.add(c.scene, "exact f32", 1, [&] {
        return [&, smooth = f32::smooth_start(0)](std::size_t i) mutable {
          const auto level = static_cast<float>(c.show.input[i]);
          smooth = f32::smooth_step(smooth, static_cast<float>(tau_ms * 1e-3), level, dt_of(c.show, i));
          return static_cast<double>(smooth.now.position);
        };
      });
      bench.add(c.scene, "exact f64", 1, [&] {
        return [&, smooth = f64::smooth_start(0)](std::size_t i) mutable {
          smooth = f64::smooth_step(smooth, tau_ms * 1e-3, c.show.input[i], dt_of(c.show, i));
          return smooth.now.position;
        };
      });
      // Two in series are two poles. The fixed factor is exact at 60 frames per second.
      const double fixed = -std::expm1(-1 / (60 * tau_ms * 1e-3));
      bench.add(c.scene, "lerp, fixed factor", 1, [&] {
        return [&, first = 0.0, second = 0.0](std::size_t i) mutable {
          first += (c.show.input[i] - first) * fixed;
          return second += (first - second) * fixed;
        };
      });
      bench.add(c.scene, "lerp with dt", 1, [&] {
        return [&, first = 0.0, second = 0.0](std::size_t i) mutable {
          const double factor = std::min(c.show.dt_s[i] * c.spring.rate, 1.0);
          first += (c.show.input[i] - first) * factor;
          return second += (first - second) * factor;
        };
      });
      const std::pair<const char*, SpringMethod> rational[] = {{"rational exp", &SpringRival::rational}};
      add_rivals(c, rational, options.substeps, bench);
      const std::pair<const char*, SpringMethod> rivals[] = {{"explicit Euler", &SpringRival::explicit_euler},
                                                             {"semi-implicit Euler", &SpringRival::semi_implicit_euler},
                                                             {"implicit Euler", &SpringRival::implicit_euler}};
      add_rivals(c, rivals, options.substeps, bench);
    }
  }
  report.judges.push_back(own);
}

void report_belt(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own = judge_of("belt");
  TimeBench bench(options, report.rows);
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const auto damping = static_cast<double>(static_cast<float>(kBeltDamping));
      const Case c = case_of("belt", options, levels, tau_ms, fps, damping, own);
      bench.add(c.scene, "propagator f32", 1, [&] {
        return [&, flex = f32::Axis{0, 0}](std::size_t i) mutable {
          const f32::FlexLimits limits{static_cast<float>(c.spring.rate), static_cast<float>(c.spring.damping)};
          flex = f32::flex_stretch(flex, limits, {static_cast<float>(c.show.input[i]), 0}, 0,
                                   static_cast<float>(c.show.dt_s[i]));
          return static_cast<double>(flex.position);
        };
      });
      bench.add(c.scene, "propagator f64", 1, [&] {
        return [&, flex = f64::Axis{0, 0}](std::size_t i) mutable {
          const f64::FlexLimits limits{c.spring.rate, c.spring.damping};
          flex = f64::flex_stretch(flex, limits, {c.show.input[i], 0}, 0, c.show.dt_s[i]);
          return flex.position;
        };
      });
      const std::pair<const char*, SpringMethod> rivals[] = {{"semi-implicit Euler", &SpringRival::semi_implicit_euler},
                                                             {"implicit Euler", &SpringRival::implicit_euler},
                                                             {"RK4", &SpringRival::rk4}};
      add_rivals(c, rivals, options.substeps, bench);
    }
  }
  report.judges.push_back(own);
}

}  // namespace footlight::render
