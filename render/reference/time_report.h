// Error against run time of time behaviour: the models of sim/shared/ compared with other methods.
//
// Inputs change at 44 Hz, as DMX does. Every method and the judge read the newest input once per frame and hold it for
// the frame. The row "hold" measures the error of this. The judges are in time_judges.h.
//
// Model       value               tau_ms                         error_max in        rel_l2 of
// filament    temperature         linear time constant at full   K                   light at 555 nm, Planck's law
// motion      position            top speed over acceleration    the axis's range    position
// strobe      open share          period of the flashes          share of the frame  open share
// spin        phase               period of the rotation         turns               direction
// smoothing   level               time constant of each pole     full level          level
// belt        position            1 / angular frequency          full level          position
// led         mean light          rise of the driver             full light          light
// mains       mean power          half wave                      full power          power
// dimmer      mean light          rise of the driver             full light          light
// pulse       open share          period of the pulses           share of the frame  open share; also: random-pulse
// discharge   mean light          run-up of the arc              full light          light
// jerk        position            lag of the smoothing           the axis's range    position
//
// Times are processor times of the calling thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "render/reference/report.h"

namespace footlight::render {

struct TimeReportOptions {
  std::vector<double> tau_ms{3, 34, 350};  // filament, motion, smoothing, belt, led
  std::vector<double> fps{15, 24, 44, 60, 120, 240};
  std::vector<int> substeps{1, 4, 16, 64};                                   // of methods with a fixed step
  std::vector<double> tolerances{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};  // of methods that choose their step
  std::vector<double> strobe_hz{1.3, 9.7, 25, 59.94};
  std::vector<double> spin_hz{0.37, 10};
  std::vector<double> spin_s{3600, 86'400, 2'592'000};  // 1 hour, 24 hours, 30 days; days at 60 fps only
  double seconds = 6;                                   // of show, per scene
  int runs = 11;           // timed, after 3 warm-up runs; 0: no times, and the rows are the same on every run
  std::uint64_t seed = 1;  // of the inputs
  // Called before each row and each scene; true ends the report with the rows so far. Empty: never ends early.
  std::function<bool()> ended;
};

// Options with few scenes, for a quick report and for tests.
[[nodiscard]] TimeReportOptions quick_time_report();

// The largest error of a judge over all scenes of its model.
struct JudgeError {
  std::string model;
  std::string judge;
  double own = 0;         // against itself at another resolution
  std::string second;     // an independent judge
  double difference = 0;  // between the two judges
  std::string unit;
};

struct TimeReport {
  std::vector<TimeRow> rows;
  std::vector<JudgeError> judges;
};
[[nodiscard]] TimeReport time_report(const TimeReportOptions& options = {});

// The same in parts, so that each can be printed when it is done. Part 0 to kTimePartCount - 1 adds its rows and
// judges. A part is one model or a few similar ones.
inline constexpr int kTimePartCount = 12;
void add_time_part(int part, const TimeReportOptions& options, TimeReport& report);

// True if this build contains CVODE.
[[nodiscard]] bool has_cvode();

// ---- Differences between float and double ----

// The results of one step of one model from one state in float and in double. Inputs are exact floats.
struct Disagreement {
  std::string model;
  double f32 = 0;
  double f64 = 0;
  double error = 0;  // in `unit`
  std::string unit;
  std::string input;  // "level=0.25 dt_s=0.0166667 ..."
};
inline constexpr int kWorstCount = 3;
// Returns the kWorstCount largest differences of each model over `states` random states, largest first.
[[nodiscard]] std::vector<Disagreement> worst_disagreements(int states = 200'000, std::uint64_t seed = 1);
[[nodiscard]] std::string json_lines_of(const std::vector<Disagreement>& worst);

// ---- Summaries ----

// One method of one model at one knob value, over all scenes.
struct TimeSummary {
  std::string model;
  std::string method;
  double knob = 0;
  int scenes = 0;
  int failed = 0;  // outcome other than ok
  int unstable = 0;
  double rel_l2_mean = 0;   // geometric mean; a failed scene, or one above 1, counts as 1
  double rel_l2_worst = 0;  // of the scenes that did not fail
  double error_worst = 0;   // of all scenes, in the unit of the model; infinite if a value was
  double worst_tau_ms = 0;  // the scene of error_worst
  double worst_fps = 0;
  double ns_mean = 0;   // geometric mean of the medians
  std::string outcome;  // of the worst scene
};
[[nodiscard]] std::vector<TimeSummary> summaries_of(const std::vector<TimeRow>& rows);
[[nodiscard]] std::string table_of(const std::vector<TimeSummary>& summaries, const std::string& unit);

// Returns a table with "time at relL2 1e-2, 1e-3, 1e-4": the geometric mean over the scenes that reach the error, and
// their number. It also has the time of each method for the error of `ours`, relative to the time of `ours`, by relL2
// and by the largest error: the geometric mean and the least over the scenes that reach it.
[[nodiscard]] std::string time_at_error_of(const std::vector<TimeRow>& rows_of_one_model, const std::string& ours);

// Returns, for each scene at a frame rate, the largest error of `ours` and its time, and the other method that reaches
// that error in the least time.
[[nodiscard]] std::string cheapest_rivals_of(const std::vector<TimeRow>& rows_of_one_model, const std::string& ours,
                                             double fps);

// One curve per method, with the summaries as points.
[[nodiscard]] std::vector<Curve> curves_of(const std::vector<TimeSummary>& summaries);

}  // namespace footlight::render
