// What the files time_*.cpp share: shows as one frame rate sees them, the clock, and rows from values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/reference/report.h"
#include "render/reference/time_report.h"

namespace footlight::render {

inline constexpr std::int64_t kLevelsPeriodNs = 22'727'273;  // DMX at 44 Hz

[[nodiscard]] std::uint64_t time_hash(std::uint64_t seed, std::uint64_t index);
[[nodiscard]] double share_of(std::uint64_t bits);  // [0, 1)

// A show as one frame rate sees it: inputs change at 44 Hz, and a frame has the newest at its start.
struct Frames {
  std::vector<std::int64_t> start_ns;  // of each frame, and the end of the last
  std::vector<double> dt_s;
  std::vector<double> input;

  [[nodiscard]] std::size_t size() const { return dt_s.size(); }
};
// `inputs`: one every kLevelsPeriodNs, enough for `seconds`.
[[nodiscard]] Frames frames_of(double seconds, double fps, std::span<const double> inputs);
[[nodiscard]] std::size_t inputs_needed(double seconds);

// Levels of 16 bits in 0 to 1, one every 1/44 s: seconds of rest, of a busy show and of noise take turns at random.
// Every value is an exact float.
[[nodiscard]] std::vector<double> moves_of(double seconds, std::uint64_t seed);
// Levels for lamps: a second of full, a second of dark, a second of fade, a second of chase, and again.
[[nodiscard]] std::vector<double> flashes_of(double seconds, std::uint64_t seed);

// Whether the caller wants no more rows.
[[nodiscard]] inline bool has_ended(const TimeReportOptions& options) { return options.ended && options.ended(); }

struct TimeScene {
  std::string model;
  std::string unit;
  double tau_ms = 0;
  double fps = 0;
  double seconds = 0;
  std::vector<double> judge;      // one value a frame
  double unit_scale = 1;          // error_max = largest |value - judge| times this
  std::vector<double> span = {};  // values that are right to reach, beside the judge's
  // What rel_l2 compares: how much is seen, and how far from it a value is.
  double (*seen)(double right) = [](double right) { return right; };
  double (*miss)(double value, double right) = [](double value, double right) { return value - right; };
};

// Time that this thread has had a core: what other programs take from it is not the method's.
[[nodiscard]] double thread_ns();

// Time a frame over several runs.
struct NsPerFrame {
  double p10 = 0;
  double p50 = 0;
  double p90 = 0;
};
[[nodiscard]] NsPerFrame percentiles_of(std::vector<double> ns);

// Errors and outcome of values against the judge's.
[[nodiscard]] TimeRow time_row_of(const TimeScene& scene, const std::string& method, double knob,
                                  std::span<const double> values);

class TimeBench {
 public:
  TimeBench(const TimeReportOptions& options, std::vector<TimeRow>& rows) : options_(options), rows_(rows) {}

  // `begin()` gives a fresh method; calling that with the number of a frame steps it and gives the value at the frame's
  // end. Where times are taken: 3 runs to warm up, then `runs` that count, each long enough for the clock.
  template <class Begin>
  void add(const TimeScene& scene, const std::string& method, double knob, Begin begin) {
    if (has_ended(options_)) return;
    std::vector<double> values(scene.judge.size());
    run(values, begin);
    TimeRow row = time_row_of(scene, method, knob, values);
    set_time(row, time_of(values, begin));
    rows_.push_back(std::move(row));
  }

  // Values that were made elsewhere.
  void add_values(const TimeScene& scene, const std::string& method, double knob, std::span<const double> values,
                  const NsPerFrame& time) {
    if (has_ended(options_)) return;
    TimeRow row = time_row_of(scene, method, knob, values);
    set_time(row, time);
    rows_.push_back(std::move(row));
  }

  template <class Begin>
  NsPerFrame time_of(std::vector<double>& values, Begin begin) const {
    constexpr int kWarmUps = 3;
    constexpr double kLeastRunNs = 50'000;
    if (options_.runs <= 0 || values.empty()) return {};
    double passes = 1;
    std::vector<double> ns;
    for (int i = 0; i < kWarmUps + options_.runs; ++i) {
      const double from_ns = thread_ns();
      for (double pass = 0; pass < passes; ++pass) {
        auto step = begin();
        for (std::size_t f = 0; f < values.size(); ++f) values[f] = step(f);
      }
      const double taken_ns = thread_ns() - from_ns;
      if (i >= kWarmUps) {
        ns.push_back(taken_ns / passes / static_cast<double>(values.size()));
      } else {
        passes = std::ceil(std::max(kLeastRunNs / std::max(taken_ns / passes, 1.0), 1.0));
      }
    }
    return percentiles_of(std::move(ns));
  }

 private:
  template <class Begin>
  static void run(std::vector<double>& values, Begin begin) {
    auto step = begin();
    for (std::size_t f = 0; f < values.size(); ++f) values[f] = step(f);
  }
  static void set_time(TimeRow& row, const NsPerFrame& time) {
    row.ns_p10 = time.p10;
    row.ns_p50 = time.p50;
    row.ns_p90 = time.p90;
  }

  const TimeReportOptions& options_;
  std::vector<TimeRow>& rows_;
};

// The models. Each adds its rows and what its judges say of themselves.
void report_filament(const TimeReportOptions& options, TimeReport& report);
void report_motion(const TimeReportOptions& options, TimeReport& report);
void report_strobe(const TimeReportOptions& options, TimeReport& report);
void report_spin(const TimeReportOptions& options, TimeReport& report);
void report_smoothing(const TimeReportOptions& options, TimeReport& report);
void report_belt(const TimeReportOptions& options, TimeReport& report);
void report_led(const TimeReportOptions& options, TimeReport& report);
void report_mains(const TimeReportOptions& options, TimeReport& report);
void report_dimmer(const TimeReportOptions& options, TimeReport& report);
void report_pulse(const TimeReportOptions& options, TimeReport& report);  // and random ones
void report_discharge(const TimeReportOptions& options, TimeReport& report);
void report_jerk(const TimeReportOptions& options, TimeReport& report);

}  // namespace footlight::render
