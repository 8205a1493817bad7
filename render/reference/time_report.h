// Error against run time of what moves and flashes: sim/shared/motion.h and shutter.h against rivals.
//
// Model "axis": a pan axis of 540 degrees is sent to random targets by levels that change at 44 Hz; the program sees
// the newest levels once a frame and holds them for the frame. Every method gets the same held targets, and so does the
// judge: an integrator in long double that follows the time-optimal control law event by event, finding each event by
// bisection. It shares no formula with the closed form. Its own error is the difference to bisection a hundred times
// coarser. The method "hold" is apart: the closed form against a judge that sees every change of level when it comes.
// It says what looking at the levels once a frame costs, whatever integrates.
//
// Model "strobe": the share of a frame during which the shutter is open, against the sum of the overlaps of the frame
// with each flash in long double.
//
// A row has failed where a value is not finite, or a position leaves the span of all targets and all the judge's
// positions by more than 1 % of the axis's range, or an open share leaves 0 to 1.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/reference/report.h"

namespace footlight::render {

struct TimeReportOptions {
  std::vector<double> stiffness_per_s{2, 20, 200, 2000};      // acceleration limit over speed limit
  std::vector<double> fps{15, 30, 60, 120, 240};
  std::vector<int> substeps{1, 4, 16, 64};                    // of the rivals
  std::vector<double> strobe_hz{1.3, 10, 25, 59.94};
  double seconds = 20;       // of show, each row
  std::uint64_t seed = 1;    // of the targets
  bool measure_time = true;  // false: ns_per_step is 0 and the rows are the same on every run
};

[[nodiscard]] std::vector<TimeRow> time_rows(const TimeReportOptions& options = {});

// The axis judge's own largest error over the axis's range, for the report's head: bisection to 1e-17 s against 1e-15
// s.
[[nodiscard]] double axis_judge_own_error(const TimeReportOptions& options = {});

}  // namespace footlight::render
