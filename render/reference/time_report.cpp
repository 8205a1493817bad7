#include "render/reference/time_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <utility>

#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

using Wide = long double;

constexpr double kRangeRad = 9.42477796076938;   // 540 degrees
constexpr double kSpeedMax = 4.0;                // rad/s: 540 degrees in 2.4 s
constexpr std::int64_t kLevelsPeriodNs = 22'727'273;  // 44 Hz
constexpr double kEscapeShare = 0.01;            // of the range, past the judge's span: the row has failed
constexpr double kStrobeDuty = 0.5;
constexpr double kFineS = 1e-17;                 // the judge's bisection
constexpr double kCoarseS = 1e-15;

std::uint64_t hash(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15u + index * 0xd1b54a32d192ed03u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
double share(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

// Targets of 16 bits as the levels say them, every 1/44 s: seconds of rest, of a busy show and of noise take turns at
// random. Every value is an exact float.
std::vector<double> targets_of(const TimeReportOptions& options) {
  const auto count = static_cast<std::size_t>(options.seconds * 1e9 / kLevelsPeriodNs) + 2;
  std::vector<double> targets;
  double target = 0;
  for (std::size_t i = 0; i < count; ++i) {
    constexpr double kChance[3] = {0.03, 0.3, 1.0};
    const double chance = kChance[hash(options.seed, 3 * (i / 44)) % 3];
    if (share(hash(options.seed, 3 * i + 1)) < chance) {
      const auto raw = static_cast<double>(hash(options.seed, 3 * i + 2) & 0xffff);
      target = static_cast<double>(static_cast<float>((raw / 65535 - 0.5) * kRangeRad));
    }
    targets.push_back(target);
  }
  return targets;
}

// A show as one frame rate sees it.
struct Show {
  std::vector<std::int64_t> start_ns;  // of each frame, and the end of the last
  std::vector<double> dt_s;
  std::vector<double> target;          // the newest at the start of each frame
};

Show show_at(const TimeReportOptions& options, const std::vector<double>& targets, double fps) {
  Show show;
  const auto frames = static_cast<std::int64_t>(options.seconds * fps);
  for (std::int64_t i = 0; i <= frames; ++i) {
    show.start_ns.push_back(static_cast<std::int64_t>(std::llround(static_cast<double>(i) * 1e9 / fps)));
  }
  for (std::size_t i = 0; i + 1 < show.start_ns.size(); ++i) {
    show.dt_s.push_back(static_cast<double>(show.start_ns[i + 1] - show.start_ns[i]) * 1e-9);
    show.target.push_back(targets[static_cast<std::size_t>(show.start_ns[i] / kLevelsPeriodNs)]);
  }
  return show;
}

// ---- The judge of the axis ----

// Follows the control law event by event: push towards the target while braking now would stop short of it, coast at
// the speed limit, brake from where braking now would stop on it. Each event is found by halving an interval of time.
class AxisJudge {
 public:
  AxisJudge(double start, double speed_max, double acceleration_max, double resolution_s)
      : x_(start), target_(start), v_max_(speed_max), a_max_(acceleration_max), resolution_s_(resolution_s) {}

  double position() const { return static_cast<double>(x_); }

  void advance(double target, Wide dt_s) {
    if (Wide(target) != target_) {
      target_ = target;
      mode_ = Mode::kPush;
      side_ = stop_at(x_, v_) <= target_ ? 1 : -1;
    }
    Wide left_s = dt_s;
    while (left_s > 0 && mode_ != Mode::kRest) {
      const Wide a = mode_ == Mode::kPush ? side_ * a_max_ : mode_ == Mode::kCoast ? Wide(0) : -side_ * a_max_;
      const Wide event_s = first(left_s, a);
      x_ += (v_ + a * event_s / 2) * event_s;
      v_ += a * event_s;
      if (!happened(x_, v_)) break;  // the step ended first
      left_s -= event_s;
      if (mode_ == Mode::kBrake) {
        mode_ = Mode::kRest;
        v_ = 0;
      } else if (side_ * (stop_at(x_, v_) - target_) >= 0) {
        mode_ = Mode::kBrake;
      } else {
        mode_ = Mode::kCoast;
        v_ = side_ * v_max_;
      }
    }
  }

 private:
  enum class Mode { kPush, kCoast, kBrake, kRest };

  Wide stop_at(Wide x, Wide v) const { return x + v * std::fabs(v) / (2 * a_max_); }

  // Whether the mode is over in this state; once it is, it stays so under the mode's own acceleration.
  bool happened(Wide x, Wide v) const {
    switch (mode_) {
      case Mode::kPush: return side_ * v >= v_max_ || side_ * (stop_at(x, v) - target_) >= 0;
      case Mode::kCoast: return side_ * (stop_at(x, v) - target_) >= 0;
      case Mode::kBrake: return side_ * v <= 0;
      case Mode::kRest: break;
    }
    return false;
  }

  // The first time in 0..left_s at which the mode is over, or left_s.
  Wide first(Wide left_s, Wide a) const {
    const auto over = [&](Wide t) { return happened(x_ + (v_ + a * t / 2) * t, v_ + a * t); };
    if (over(0)) return 0;
    if (!over(left_s)) return left_s;
    Wide no = 0;
    Wide yes = left_s;
    while (yes - no > resolution_s_) {
      const Wide middle = (no + yes) / 2;
      if (!(middle > no && middle < yes)) break;
      (over(middle) ? yes : no) = middle;
    }
    return yes;
  }

  Wide x_;
  Wide v_ = 0;
  Wide target_;
  Wide v_max_;
  Wide a_max_;
  Wide resolution_s_;
  Wide side_ = 1;
  Mode mode_ = Mode::kRest;
};

// Positions at the ends of the frames with the target held for each frame.
std::vector<double> judged_held(const Show& show, double acceleration_max, double resolution_s) {
  AxisJudge axis(0, kSpeedMax, acceleration_max, resolution_s);
  std::vector<double> positions;
  for (std::size_t i = 0; i < show.dt_s.size(); ++i) {
    axis.advance(show.target[i], Wide(show.start_ns[i + 1] - show.start_ns[i]) * 1e-9L);
    positions.push_back(axis.position());
  }
  return positions;
}

// The same with every change of target when it comes.
std::vector<double> judged_live(const Show& show, const std::vector<double>& targets, double acceleration_max) {
  AxisJudge axis(0, kSpeedMax, acceleration_max, kFineS);
  std::vector<double> positions;
  std::int64_t now_ns = 0;
  for (std::size_t i = 0; i < show.dt_s.size(); ++i) {
    while (now_ns < show.start_ns[i + 1]) {
      const std::int64_t period = now_ns / kLevelsPeriodNs;
      const std::int64_t until_ns = std::min((period + 1) * kLevelsPeriodNs, show.start_ns[i + 1]);
      axis.advance(targets[static_cast<std::size_t>(period)], Wide(until_ns - now_ns) * 1e-9L);
      now_ns = until_ns;
    }
    positions.push_back(axis.position());
  }
  return positions;
}

// ---- The methods ----

// Runs `step(frame)` -> value over a show, several times when timed; the time is the median of the runs.
struct Run {
  std::vector<double> values;
  double ns_per_step = 0;
};

template <class Begin>
Run run_of(std::size_t frames, bool timed, Begin begin) {
  Run run;
  run.values.resize(frames);
  std::vector<double> ns;
  for (int repeat = 0; repeat < (timed ? 5 : 1); ++repeat) {
    auto step = begin();
    const auto from = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < frames; ++i) run.values[i] = step(i);
    const auto to = std::chrono::steady_clock::now();
    ns.push_back(std::chrono::duration<double, std::nano>(to - from).count() / static_cast<double>(frames));
  }
  if (timed) {
    std::sort(ns.begin(), ns.end());
    run.ns_per_step = ns[ns.size() / 2];
  }
  return run;
}

// The control law as game code writes it: full push towards where braking would stop on the target.
struct Rival {
  double x = 0;
  double v = 0;

  static double push(double x, double v, double target, double a_max) {
    const double miss = target - x - v * std::abs(v) / (2 * a_max);
    if (std::abs(v) >= kSpeedMax && miss * v > 0) return 0;
    return miss > 0 ? a_max : miss < 0 ? -a_max : 0;
  }
  void limit() { v = std::clamp(v, -kSpeedMax, kSpeedMax); }
  // Within one step's reach of rest on the target: there. Without it the rivals would tremble around it for ever.
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
};

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = std::abs(a[i] - b[i]);
    if (!(d <= largest)) largest = d;  // NaN stays
  }
  return largest;
}

struct Span {
  double low = 0;
  double high = 0;
};

void widen(Span& span, const std::vector<double>& values) {
  for (const double v : values) {
    span.low = std::min(span.low, v);
    span.high = std::max(span.high, v);
  }
}

bool leaves(const std::vector<double>& values, const Span& span, double slack) {
  return std::any_of(values.begin(), values.end(),
                     [&](double v) { return !(v >= span.low - slack && v <= span.high + slack); });
}

void add_axis_rows(const TimeReportOptions& options, const std::vector<double>& targets, double stiffness, double fps,
                   std::vector<TimeRow>& rows) {
  const Show show = show_at(options, targets, fps);
  const std::size_t frames = show.dt_s.size();
  const auto a_max = static_cast<double>(static_cast<float>(stiffness * kSpeedMax));
  const std::vector<double> judge = judged_held(show, a_max, kFineS);

  Span span;
  widen(span, judge);
  widen(span, targets);

  const auto add = [&](const std::string& method, double knob, const std::vector<double>& against, const Run& run) {
    rows.push_back({"axis", method, knob, stiffness, fps, largest_difference(run.values, against) / kRangeRad,
                    run.ns_per_step, leaves(run.values, span, kEscapeShare * kRangeRad)});
  };
  add("closed form f32", 1, judge, run_of(frames, options.measure_time, [&] {
        return [&, axis = f32::Axis{0, 0}](std::size_t i) mutable {
          axis = f32::axis_step(axis, static_cast<float>(show.target[i]), static_cast<float>(kSpeedMax),
                                static_cast<float>(a_max), static_cast<float>(show.dt_s[i]));
          return static_cast<double>(axis.position);
        };
      }));
  const Run closed_f64 = run_of(frames, options.measure_time, [&] {
    return [&, axis = f64::Axis{0, 0}](std::size_t i) mutable {
      axis = f64::axis_step(axis, show.target[i], kSpeedMax, a_max, show.dt_s[i]);
      return axis.position;
    };
  });
  add("closed form f64", 1, judge, closed_f64);
  add("hold", 1, judged_live(show, targets, a_max), closed_f64);

  using Method = void (Rival::*)(double, double, double);
  const std::pair<const char*, Method> rivals[] = {{"explicit Euler", &Rival::explicit_euler},
                                                   {"semi-implicit Euler", &Rival::semi_implicit_euler},
                                                   {"RK4", &Rival::rk4}};
  for (const auto& [name, method] : rivals) {
    for (const int substeps : options.substeps) {
      add(name, substeps, judge, run_of(frames, options.measure_time, [&, m = method] {
            return [&, m, rival = Rival{}](std::size_t i) mutable {
              const double h = show.dt_s[i] / substeps;
              for (int s = 0; s < substeps; ++s) (rival.*m)(show.target[i], a_max, h);
              return rival.x;
            };
          }));
    }
  }
  for (const double tau_ms : {50.0, 100.0, 200.0, 400.0}) {
    add("exponential smoothing", tau_ms, judge, run_of(frames, options.measure_time, [&] {
          return [&, x = 0.0](std::size_t i) mutable {
            x += (show.target[i] - x) * -std::expm1(-show.dt_s[i] / (tau_ms * 1e-3));
            return x;
          };
        }));
  }
}

// ---- Strobe ----

// Sum over the flashes [i / f, (i + duty) / f] of their overlap with from..to, over to - from. Seconds.
double judged_open_share(Wide hz, Wide from_s, Wide to_s) {
  Wide open_s = 0;
  for (Wide i = std::floor(from_s * hz) - 1; i / hz < to_s; i += 1) {
    const Wide on = std::max(i / hz, from_s);
    const Wide off = std::min((i + kStrobeDuty) / hz, to_s);
    if (off > on) open_s += off - on;
  }
  return static_cast<double>(open_s / (to_s - from_s));
}

void add_strobe_rows(const TimeReportOptions& options, double strobe_hz, double fps, std::vector<TimeRow>& rows) {
  constexpr Wide kDayS = 86'400;
  const auto hz = static_cast<double>(static_cast<float>(strobe_hz));
  const Show show = show_at(options, targets_of(options), fps);
  const std::size_t frames = show.dt_s.size();
  std::vector<double> judge(frames);
  std::vector<double> judge_next_day(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const Wide from_s = Wide(show.start_ns[i]) * 1e-9L;
    const Wide to_s = Wide(show.start_ns[i + 1]) * 1e-9L;
    judge[i] = judged_open_share(hz, from_s, to_s);
    judge_next_day[i] = judged_open_share(hz, kDayS + from_s, kDayS + to_s);
  }
  const auto add = [&](const std::string& method, double knob, const std::vector<double>& against, const Run& run) {
    rows.push_back({"strobe", method, knob, strobe_hz, fps, largest_difference(run.values, against), run.ns_per_step,
                    leaves(run.values, {0, 1}, 1e-6)});
  };
  const auto words = [&](std::size_t i) {
    return glm::uvec2(static_cast<std::uint32_t>(show.start_ns[i + 1] - show.start_ns[i]), 0u);
  };
  add("exposure integral f32", 1, judge, run_of(frames, options.measure_time, [&] {
        return [&, phase = f32::Turns(0, 0)](std::size_t i) mutable {
          const float open = f32::shutter_open_share(
              f32::turns_fraction(phase), static_cast<float>(hz) * static_cast<float>(show.dt_s[i]),
              static_cast<float>(kStrobeDuty));
          phase = f32::turns_step(phase, static_cast<float>(hz), words(i));
          return static_cast<double>(open);
        };
      }));
  add("exposure integral f64", 1, judge, run_of(frames, options.measure_time, [&] {
        return [&, phase = f64::Turns(0, 0)](std::size_t i) mutable {
          const double open =
              f64::shutter_open_share(f64::turns_fraction(phase), hz * show.dt_s[i], kStrobeDuty);
          phase = f64::turns_step(phase, hz, words(i));
          return open;
        };
      }));
  for (const int samples : options.substeps) {
    add("point samples", samples, judge, run_of(frames, options.measure_time, [&] {
          return [&](std::size_t i) {
            int open = 0;
            for (int s = 0; s < samples; ++s) {
              const double t_s = static_cast<double>(show.start_ns[i]) * 1e-9 + (s + 0.5) / samples * show.dt_s[i];
              const double turns = t_s * hz;
              open += turns - std::floor(turns) < kStrobeDuty ? 1 : 0;
            }
            return static_cast<double>(open) / samples;
          };
        }));
  }
  // What a shader does that multiplies a float of seconds by the rate, one day after the program started.
  add("point sample, float time after a day", 1, judge_next_day, run_of(frames, options.measure_time, [&] {
        return [&](std::size_t i) {
          const double after_s = static_cast<double>(show.start_ns[i]) * 1e-9;
          const auto t_s = static_cast<float>(static_cast<double>(kDayS) + after_s);
          const float turns = t_s * static_cast<float>(hz);
          return turns - std::floor(turns) < static_cast<float>(kStrobeDuty) ? 1.0 : 0.0;
        };
      }));
}

}  // namespace

std::vector<TimeRow> time_rows(const TimeReportOptions& options) {
  std::vector<TimeRow> rows;
  const std::vector<double> targets = targets_of(options);
  for (const double stiffness : options.stiffness_per_s) {
    for (const double fps : options.fps) add_axis_rows(options, targets, stiffness, fps, rows);
  }
  for (const double hz : options.strobe_hz) {
    for (const double fps : options.fps) add_strobe_rows(options, hz, fps, rows);
  }
  return rows;
}

double axis_judge_own_error(const TimeReportOptions& options) {
  const std::vector<double> targets = targets_of(options);
  double largest = 0;
  for (const double stiffness : options.stiffness_per_s) {
    const auto a_max = static_cast<double>(static_cast<float>(stiffness * kSpeedMax));
    for (const double fps : options.fps) {
      const Show show = show_at(options, targets, fps);
      const std::vector<double> fine = judged_held(show, a_max, kFineS);
      largest = std::max(largest, largest_difference(fine, judged_held(show, a_max, kCoarseS)));
    }
  }
  return largest / kRangeRad;
}

}  // namespace footlight::render
