// A motor that turns endlessly at a constant rate, after an hour, a day and a month.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

// Every frame is stepped. More than an hour runs at 60 fps only, more than a day at the last rate only.
constexpr double kHourS = 3600;
constexpr double kDayS = 86'400;
constexpr std::size_t kJudgedFrames = 64;  // the last ones of the run
constexpr std::size_t kTimedFrames = 20'000;

double fraction(double turns) { return turns - std::floor(turns); }

std::int64_t start_ns_of(std::int64_t frame, double fps) {
  return static_cast<std::int64_t>(std::llround(static_cast<double>(frame) * 1e9 / fps));
}

// The methods. Each steps by one frame and returns the phase in turns, [0, 1).
struct FloatSum {  // adds up radians
  float phase = 0;
  void step(float rate_hz, std::int64_t dt_ns) {
    phase += 2 * std::numbers::pi_v<float> * rate_hz * (static_cast<float>(dt_ns) * 1e-9f);
  }
  [[nodiscard]] double turns() const { return fraction(static_cast<double>(phase) / (2 * std::numbers::pi)); }
};
struct DoubleSum {
  double phase = 0;
  void step(float rate_hz, std::int64_t dt_ns) {
    phase += 2 * std::numbers::pi * static_cast<double>(rate_hz) * (static_cast<double>(dt_ns) * 1e-9);
  }
  [[nodiscard]] double turns() const { return fraction(phase / (2 * std::numbers::pi)); }
};
struct WrappedFloat {  // adds up turns and keeps them below 1
  float phase = 0;
  void step(float rate_hz, std::int64_t dt_ns) {
    phase += rate_hz * (static_cast<float>(dt_ns) * 1e-9f);
    phase -= std::floor(phase);
  }
  [[nodiscard]] double turns() const { return static_cast<double>(phase); }
};
struct FloatSeconds {  // multiplies float seconds since the start by the rate
  std::int64_t now_ns = 0;
  float rate_hz = 0;
  void step(float rate, std::int64_t dt_ns) {
    now_ns += dt_ns;
    rate_hz = rate;
  }
  [[nodiscard]] double turns() const {
    const float t_s = static_cast<float>(static_cast<double>(now_ns) * 1e-9);
    const float product = t_s * rate_hz;
    return static_cast<double>(product - std::floor(product));
  }
};
template <class Phase>
double turns_of(Phase phase) {
  return (static_cast<double>(phase.y) + static_cast<double>(phase.x) * 0x1p-32) * 0x1p-32;
}
struct Turns64F32 {
  f32::Turns phase{0, 0};
  void step(float rate_hz, std::int64_t dt_ns) {
    phase = f32::turns_step(phase, rate_hz, {static_cast<std::uint32_t>(dt_ns), 0});
  }
  [[nodiscard]] double turns() const { return turns_of(phase); }
};
struct Turns64F64 {
  f64::Turns phase{0, 0};
  void step(float rate_hz, std::int64_t dt_ns) {
    phase = f64::turns_step(phase, static_cast<double>(rate_hz), {static_cast<std::uint32_t>(dt_ns), 0});
  }
  [[nodiscard]] double turns() const { return turns_of(phase); }
};

// Moves a phase to within half a turn of the judge's, so that a wrap does not count as an error.
double beside(double turns, double judge) { return judge + (fraction(turns - judge + 0.5) - 0.5); }

template <class Method>
void add_method(const TimeScene& scene, const char* name, float rate_hz, TimeBench& bench) {
  const auto frames = static_cast<std::int64_t>(scene.seconds * scene.fps);
  const auto judged_from = frames - static_cast<std::int64_t>(scene.judge.size());
  Method method;
  std::vector<double> values;
  std::int64_t from_ns = 0;
  for (std::int64_t i = 1; i <= frames; ++i) {
    const std::int64_t to_ns = start_ns_of(i, scene.fps);
    method.step(rate_hz, to_ns - from_ns);
    from_ns = to_ns;
    if (i > judged_from) values.push_back(beside(method.turns(), scene.judge[values.size()]));
  }
  std::vector<double> timed(kTimedFrames);
  const std::int64_t dt_ns = start_ns_of(1, scene.fps);
  bench.add_values(scene, name, 1, values, bench.time_of(timed, [&] {
    return [=, m = Method{}](std::size_t) mutable {
      m.step(rate_hz, dt_ns);
      return m.turns();
    };
  }));
}

}  // namespace

void report_spin(const TimeReportOptions& options, TimeReport& report) {
  JudgeError own{.model = "spin",
                 .judge = "128-bit integers, rounded once",
                 .own = 0,
                 .second = "rate times time in long double",
                 .unit = "turn"};
  TimeBench bench(options, report.rows);
  for (const double rate : options.spin_hz) {
    const auto rate_hz = static_cast<float>(rate);
    for (const double seconds : options.spin_s) {
      for (const double fps : options.fps) {
        if (has_ended(options)) break;
        if (seconds > kHourS && fps != 60) continue;
        if (seconds > kDayS && rate != options.spin_hz.back()) continue;
        TimeScene scene{
            .model = "spin", .unit = "turn", .tau_ms = 1000 / rate, .fps = fps, .seconds = seconds, .span = {0, 1}};
        scene.seen = [](double) { return 1.0; };
        scene.miss = [](double value, double judge) { return 2 * std::sin(std::numbers::pi * (value - judge)); };
        const auto frames = static_cast<std::int64_t>(seconds * fps);
        for (auto i = std::max<std::int64_t>(frames - static_cast<std::int64_t>(kJudgedFrames), 0) + 1; i <= frames;
             ++i) {
          const Wide exact = turns_judged(rate_hz, start_ns_of(i, fps));
          const Wide other = turns_judged_wide(rate_hz, start_ns_of(i, fps));
          scene.judge.push_back(static_cast<double>(exact));
          const auto difference = static_cast<double>(std::fabs(exact - other));
          own.difference = std::max(own.difference, std::min(difference, 1 - difference));
        }
        add_method<Turns64F32>(scene, "64-bit turns f32", rate_hz, bench);
        add_method<Turns64F64>(scene, "64-bit turns f64", rate_hz, bench);
        add_method<FloatSum>(scene, "float sum", rate_hz, bench);
        add_method<WrappedFloat>(scene, "wrapped float", rate_hz, bench);
        add_method<FloatSeconds>(scene, "float seconds", rate_hz, bench);
        add_method<DoubleSum>(scene, "double sum", rate_hz, bench);
      }
    }
  }
  own.own = 0x1p-53;
  report.judges.push_back(own);
}

}  // namespace footlight::render
