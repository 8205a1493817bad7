// What the files time_*.cpp share: the inputs of each frame, the clock, and rows from values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "render/reference/report.h"
#include "render/reference/time_report.h"

namespace footlight::render {

inline constexpr std::int64_t kLevelsPeriodNs = 22'727'273;  // DMX at 44 Hz

[[nodiscard]] std::uint64_t time_hash(std::uint64_t seed, std::uint64_t index);
[[nodiscard]] double share_of(std::uint64_t bits);  // [0, 1)

// The inputs of a show at one frame rate. Inputs change at 44 Hz; a frame has the newest input at its start.
struct Frames {
  std::vector<std::int64_t> start_ns;  // start of each frame, and the end of the last
  std::vector<double> dt_s;
  std::vector<double> input;

  [[nodiscard]] std::size_t size() const { return dt_s.size(); }
};
// The length of frame i as the step functions take it.
[[nodiscard]] inline glm::uvec2 dt_of(const Frames& show, std::size_t i) {
  return {static_cast<std::uint32_t>(show.start_ns[i + 1] - show.start_ns[i]), 0u};
}
// `inputs`: one per kLevelsPeriodNs, at least inputs_needed(seconds).
[[nodiscard]] Frames frames_of(double seconds, double fps, std::span<const double> inputs);
[[nodiscard]] std::size_t inputs_needed(double seconds);

// Returns levels of 16 bits in 0 to 1, one per 1/44 s. Seconds of rest, of a busy show and of noise alternate at
// random. Every value is an exact float.
[[nodiscard]] std::vector<double> moves_of(double seconds, std::uint64_t seed);
// Returns levels for lamps, repeating every 4 s: a second of full, of dark, of a fade and of a chase.
[[nodiscard]] std::vector<double> flashes_of(double seconds, std::uint64_t seed);

// True if the caller requests no more rows.
[[nodiscard]] inline bool has_ended(const TimeReportOptions& options) { return options.ended && options.ended(); }

struct TimeScene {
  std::string model;
  std::string unit;
  double tau_ms = 0;
  double fps = 0;
  double seconds = 0;
  std::vector<double> judge;      // one value per frame
  double unit_scale = 1;          // error_max is the largest |value - judge| times this
  std::vector<double> span = {};  // values that methods may reach besides those of the judge
  // The quantity of which rel_l2 is computed: its value, and the error of a method's value.
  double (*seen)(double right) = [](double right) { return right; };
  double (*miss)(double value, double right) = [](double value, double right) { return value - right; };
};

// Processor time of this thread, so that other programs do not count.
[[nodiscard]] double thread_ns();

// Time per frame over several runs.
struct NsPerFrame {
  double p10 = 0;
  double p50 = 0;
  double p90 = 0;
};
[[nodiscard]] NsPerFrame percentiles_of(std::vector<double> ns);

// Computes errors and outcome of `values` against the judge's values.
[[nodiscard]] TimeRow time_row_of(const TimeScene& scene, const std::string& method, double knob,
                                  std::span<const double> values);

class TimeBench {
 public:
  TimeBench(const TimeReportOptions& options, std::vector<TimeRow>& rows) : options_(options), rows_(rows) {}

  // `begin()` returns a new method. Calling it with the number of a frame steps it and returns the value at the frame's
  // end. If times are measured, 3 warm-up runs precede `runs` timed ones, each long enough for the clock.
  template <class Begin>
  void add(const TimeScene& scene, const std::string& method, double knob, Begin begin) {
    if (has_ended(options_)) return;
    std::vector<double> values(scene.judge.size());
    run(values, begin);
    TimeRow row = time_row_of(scene, method, knob, values);
    set_time(row, time_of(values, begin));
    rows_.push_back(std::move(row));
  }

  // Adds a row of values that were computed elsewhere.
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

// One function per model. Each adds its rows and the errors of its judges.
void report_filament(const TimeReportOptions& options, TimeReport& report);
void report_motion(const TimeReportOptions& options, TimeReport& report);
void report_strobe(const TimeReportOptions& options, TimeReport& report);
void report_spin(const TimeReportOptions& options, TimeReport& report);
void report_smoothing(const TimeReportOptions& options, TimeReport& report);
void report_belt(const TimeReportOptions& options, TimeReport& report);
void report_led(const TimeReportOptions& options, TimeReport& report);
void report_mains(const TimeReportOptions& options, TimeReport& report);
void report_dimmer(const TimeReportOptions& options, TimeReport& report);
void report_pulse(const TimeReportOptions& options, TimeReport& report);  // also random pulses
void report_discharge(const TimeReportOptions& options, TimeReport& report);
void report_jerk(const TimeReportOptions& options, TimeReport& report);

}  // namespace footlight::render
