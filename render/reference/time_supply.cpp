// Means over a frame, as a camera records them: an LED whose driver and heat lag, and a lamp without inertia on a
// phase-cut dimmer.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr double kHeatS = 60;
constexpr double kDroop = 0.125;
constexpr std::array<float, 2> kHalfWavesHz{100, 120};

// ---- LED ----

// level' = (u - level) / rise, heat' = (level - heat) / heat_s; light = level (1 - droop heat).
struct LedState {
  Wide level = 0;
  Wide heat = 0;
};

// The mean light over dt_s, by Taylor series of level and heat in pieces of `share` of the rise time.
Wide led_judged(LedState& state, Wide rise_s, Wide u, Wide dt_s, Wide share) {
  constexpr std::size_t kDegree = 24;
  const Wide pieces = std::ceil(dt_s / (share * rise_s));
  const Wide h = dt_s / pieces;
  Wide light = 0;
  for (Wide piece = 0; piece < pieces; piece += 1) {
    std::array<Wide, kDegree + 1> level{state.level};
    std::array<Wide, kDegree + 1> heat{state.heat};
    for (std::size_t k = 0; k < kDegree; ++k) {  // coefficients times h^k
      const auto next = static_cast<Wide>(k + 1);
      level[k + 1] = ((k == 0 ? u : Wide(0)) - level[k]) / rise_s * h / next;
      heat[k + 1] = (level[k] - heat[k]) / Wide(kHeatS) * h / next;
    }
    state = {};
    for (std::size_t k = 0; k <= kDegree; ++k) {
      state.level += level[k];
      state.heat += heat[k];
      light += level[k] / static_cast<Wide>(k + 1);
      for (std::size_t j = 0; j <= kDegree; ++j) {
        light -= Wide(kDroop) * level[k] * heat[j] / static_cast<Wide>(k + j + 1);
      }
    }
  }
  return light / pieces;
}

std::vector<double> led_judged_show(const Frames& show, Wide rise_s, Wide share) {
  std::vector<double> values;
  LedState state;
  for (std::size_t i = 0; i < show.size(); ++i) {
    values.push_back(static_cast<double>(led_judged(state, rise_s, show.input[i], show.dt_s[i], share)));
  }
  return values;
}

struct LedRival {
  double level = 0;
  double heat = 0;

  double light() const { return level * (1 - kDroop * heat); }
  // Explicit steps; the light is the mean of both ends.
  double explicit_euler(double rise_s, double u, double h) {
    const double before = light();
    const double slope = (u - level) / rise_s;
    heat += (level - heat) / kHeatS * h;
    level += slope * h;
    return (before + light()) / 2;
  }
  double rk4(double rise_s, double u, double h) {
    const double before = light();
    const auto slope = [&](double x) { return (u - x) / rise_s; };
    const double a = slope(level);
    const double b = slope(level + a * h / 2);
    const double c = slope(level + b * h / 2);
    const double d = slope(level + c * h);
    heat += (level - heat) / kHeatS * h;
    level += (a + 2 * b + 2 * c + d) * h / 6;
    return (before + light()) / 2;
  }
};

// ---- Mains ----

double mains_power(double p, double cut) {
  const double s = std::sin(std::numbers::pi * p);
  return p > cut ? 2 * s * s : 0;
}

// Mean power over the half waves from..to, by quadrature of each half wave.
double mains_judged(double from, double to, double cut) {
  double energy = 0;
  for (double wave = std::floor(from); wave < to; wave += 1) {
    const double a = std::max(from, wave + cut) - wave;
    const double b = std::min(to, wave + 1) - wave;
    if (b > a) {
      energy += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(
          [](double p) { return mains_power(p, -1); }, a, b, 5, 1e-14);
    }
  }
  return energy / (to - from);
}

// The same by the antiderivative of the squared sine, in long double.
double mains_judged_wide(Wide from, Wide to, Wide cut) {
  const auto up_to = [](Wide p) {
    return p - std::sin(2 * std::numbers::pi_v<Wide> * p) / (2 * std::numbers::pi_v<Wide>);
  };
  Wide energy = 0;
  for (Wide wave = std::floor(from); wave < to; wave += 1) {
    const Wide a = std::max(from, wave + cut) - wave;
    const Wide b = std::min(to, wave + 1) - wave;
    if (b > a) energy += up_to(b) - up_to(a);
  }
  return static_cast<double>(energy / (to - from));
}

double mains_cut(double share) { return share > 0 ? 1 - std::min(share, 1.0) : 1; }

// Measures the judge against itself in pieces of a fifth of the rise time, and against RK4 in many steps.
void judge_led_judge(const Frames& show, double rise_s, const std::vector<double>& judge, JudgeError& own) {
  const std::vector<double> fine = led_judged_show(show, rise_s, 0.2L);
  LedRival steps;
  for (std::size_t i = 0; i < show.size(); ++i) {
    own.own = std::max(own.own, std::abs(fine[i] - judge[i]));
    if (i >= 50) continue;
    double light = 0;
    for (int s = 0; s < 4000; ++s) light += steps.rk4(rise_s, show.input[i], show.dt_s[i] / 4000) / 4000;
    own.difference = std::max(own.difference, std::abs(light - judge[i]));
  }
}

}  // namespace

void report_led(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own{.model = "led",
                 .judge = "Taylor series in pieces of half the rise, against a fifth",
                 .second = "RK4 in 4000 steps, 50 frames",
                 .unit = "full"};
  TimeBench bench(options, report.rows);
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, levels);
      const double rise_s = tau_ms * 1e-3;
      TimeScene scene{.model = "led",
                      .unit = "full",
                      .tau_ms = tau_ms,
                      .fps = fps,
                      .seconds = options.seconds,
                      .judge = led_judged_show(show, rise_s, 0.5L),
                      .span = {0, 1}};
      judge_led_judge(show, rise_s, scene.judge, own);
      bench.add(scene, "exact f32", 1, [&] {
        const f32::LedType type{static_cast<float>(rise_s), static_cast<float>(kHeatS), static_cast<float>(kDroop)};
        return [&, type, led = f32::led_start(0)](std::size_t i) mutable {
          return static_cast<double>(f32::led_step(led, type, static_cast<float>(show.input[i]), dt_of(show, i)));
        };
      });
      bench.add(scene, "exact f64", 1, [&] {
        const f64::LedType type{rise_s, kHeatS, kDroop};
        return [&, type, led = f64::led_start(0)](std::size_t i) mutable {
          return f64::led_step(led, type, show.input[i], dt_of(show, i));
        };
      });
      bench.add(scene, "at the frame's end", 1, [&] {
        return [&, level = 0.0](std::size_t i) mutable {
          return level += (show.input[i] - level) * -std::expm1(-show.dt_s[i] / rise_s);
        };
      });
      bench.add(scene, "lerp with dt", 1, [&] {
        return [&, level = 0.0](std::size_t i) mutable {
          return level += (show.input[i] - level) * std::min(show.dt_s[i] / rise_s, 1.0);
        };
      });
      using Method = double (LedRival::*)(double, double, double);
      const std::pair<const char*, Method> rivals[] = {{"explicit Euler", &LedRival::explicit_euler},
                                                       {"RK4", &LedRival::rk4}};
      for (const auto& [name, method] : rivals) {
        for (const int count : options.substeps) {
          bench.add(scene, name, count, [&, m = method, count] {
            return [&, m, count, rival = LedRival{}](std::size_t i) mutable {
              double light = 0;
              for (int s = 0; s < count; ++s) light += (rival.*m)(rise_s, show.input[i], show.dt_s[i] / count);
              return light / count;
            };
          });
        }
      }
    }
  }
  report.judges.push_back(own);
}

void report_dimmer(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = moves_of(options.seconds, options.seed);
  JudgeError own{.model = "dimmer",
                 .judge = "Taylor series in pieces of half the rise, against a fifth",
                 .second = "RK4 in 4000 steps, 50 frames",
                 .unit = "full"};
  TimeBench bench(options, report.rows);
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, levels);
      Frames lit = show;
      for (double& level : lit.input) level *= level;
      const double rise_s = tau_ms * 1e-3;
      TimeScene scene{.model = "dimmer",
                      .unit = "full",
                      .tau_ms = tau_ms,
                      .fps = fps,
                      .seconds = options.seconds,
                      .judge = led_judged_show(lit, rise_s, 0.5L),
                      .span = {0, 1}};
      judge_led_judge(lit, rise_s, scene.judge, own);
      bench.add(scene, "law, then exact f32", 1, [&] {
        const f32::LedType type{static_cast<float>(rise_s), static_cast<float>(kHeatS), static_cast<float>(kDroop)};
        return [&, type, led = f32::led_start(0)](std::size_t i) mutable {
          const float light = f32::law_light(f32::kLawSquare, static_cast<float>(show.input[i]));
          return static_cast<double>(f32::led_step(led, type, light, dt_of(show, i)));
        };
      });
      const auto with_level = [&](auto light_of_level) {
        return [&, light_of_level] {
          const f64::LedType type{rise_s, kHeatS, kDroop};
          return [&, type, light_of_level, led = f64::led_start(0)](std::size_t i) mutable {
            return f64::led_step(led, type, light_of_level(show.input[i]), dt_of(show, i));
          };
        };
      };
      bench.add(scene, "law, then exact f64", 1,
                with_level([](double level) { return f64::law_light(f64::kLawSquare, level); }));
      bench.add(scene, "law of the coarse byte", 1, with_level([](double level) {
                  const double coarse = std::floor(level * 65535 / 256) / 255;
                  return coarse * coarse;
                }));
      bench.add(scene, "power 2.2", 1, with_level([](double level) { return std::pow(level, 2.2); }));
      bench.add(scene, "law of the lagging level", 1, [&] {
        const f64::LedType type{rise_s, 0, 0};
        return [&, type, led = f64::led_start(0)](std::size_t i) mutable {
          const double level = f64::led_step(led, type, show.input[i], dt_of(show, i));
          return level * level;
        };
      });
    }
  }
  report.judges.push_back(own);
}

void report_mains(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = flashes_of(options.seconds, options.seed);
  JudgeError own{.model = "mains",
                 .judge = "Gauss-Kronrod 31 of each half wave",
                 .own = 1e-14,
                 .second = "the integral of the sine squared in long double",
                 .unit = "full"};
  TimeBench bench(options, report.rows);
  for (const float hz : kHalfWavesHz) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, levels);
      TimeScene scene{.model = "mains",
                      .unit = "full",
                      .tau_ms = 1000 / static_cast<double>(hz),
                      .fps = fps,
                      .seconds = options.seconds,
                      .span = {0, 2}};
      for (std::size_t i = 0; i < show.size(); ++i) {
        const Wide from = Wide(hz) * Wide(show.start_ns[i]) * 1e-9L;
        const Wide to = Wide(hz) * Wide(show.start_ns[i + 1]) * 1e-9L;
        const double cut = mains_cut(show.input[i]);
        const double wide = mains_judged_wide(from, to, cut);
        scene.judge.push_back(mains_judged(static_cast<double>(from), static_cast<double>(to), cut));
        own.difference = std::max(own.difference, std::abs(scene.judge.back() - wide));
      }
      bench.add(scene, "exposure integral f32", 1, [&] {
        return [&, phase = f32::Turns(0, 0)](std::size_t i) mutable {
          const f32::Advance advance = f32::turns_advance(hz, dt_of(show, i));
          const float power = f32::mains_mean(phase, advance, static_cast<float>(show.input[i]));
          phase = f32::turns_add(phase, advance.part);
          return static_cast<double>(power);
        };
      });
      bench.add(scene, "exposure integral f64", 1, [&] {
        return [&, phase = f64::Turns(0, 0)](std::size_t i) mutable {
          const f64::Advance advance = f64::turns_advance(static_cast<double>(hz), dt_of(show, i));
          const double power = f64::mains_mean(phase, advance, show.input[i]);
          phase = f64::turns_add(phase, advance.part);
          return power;
        };
      });
      bench.add(scene, "rms", 1, [&] {  // assumes that every frame contains whole half waves
        return [&](std::size_t i) {
          const double rms = f64::phase_cut_rms(show.input[i]);
          return rms * rms;
        };
      });
      for (const int samples : options.substeps) {
        bench.add(scene, "point samples", samples, [&, samples] {
          return [&, samples](std::size_t i) {
            double power = 0;
            for (int s = 0; s < samples; ++s) {
              const double t_s = static_cast<double>(show.start_ns[i]) * 1e-9 + (s + 0.5) / samples * show.dt_s[i];
              const double waves = static_cast<double>(hz) * t_s;
              power += mains_power(waves - std::floor(waves), mains_cut(show.input[i]));
            }
            return power / samples;
          };
        });
      }
    }
  }
  report.judges.push_back(own);
}

}  // namespace footlight::render
