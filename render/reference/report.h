// Error against run time, on paper: rows, tables, JSON lines, CSV, and a plot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/result.h"

namespace footlight::render {

// One picture of one scene by one method with its knob at one value.
struct PictureRow {
  std::string scene;
  std::string method;
  double knob = 0;         // what the method's quality is set by: nodes, steps
  double hits_per_px = 0;  // beams that the visible part of a pixel's ray crosses, mean
  double ms_p10 = 0;       // time a frame
  double ms_p50 = 0;
  double ms_p90 = 0;
  double rel_l2 = 0;       // norms.h
  double rel_l2_low = 0;   // 95 % confidence interval of rel_l2, where only a sample of the pixels is judged; else
  double rel_l2_high = 0;  // equal to it
  double rel_mse = 0;
  double p999 = 0;
  double max = 0;
  double flip = 0;  // NaN where only a sample is judged: it compares neighbours
  std::int64_t nonfinite = 0;
  std::int64_t bytes = 0;  // GPU memory that the method allocates
};

// How a run of a time-dependent model ended.
enum class TimeOutcome {
  kOk,
  kUseless,    // relative L2 error of 0.999 or more: as wrong as darkness
  kDiverged,   // a value left the span of the judge's values by more than a tenth of it on either side
  kNonFinite,  // a value was infinite or no number
};
[[nodiscard]] const char* word_of(TimeOutcome outcome);  // "ok", "useless", "diverged", "non-finite"

// One method with its knob at one value, on one scene of one time-dependent model.
struct TimeRow {
  std::string model;  // "filament", "motion", "strobe", "spin", "smoothing", "belt"
  std::string method;
  double knob = 0;    // sub-steps or samples a frame; a tolerance; 1 where there is none
  double tau_ms = 0;  // the scene's own time, as time_report.h says for each model: short is stiff
  double fps = 0;
  double seconds = 0;    // simulated, until the last value that is judged
  double error_max = 0;  // largest absolute error, in `unit`
  std::string unit;      // "K", "range", "share", "turn"
  double rel_l2 = 0;     // of what is seen: light, position, direction
  double ns_p10 = 0;     // time a frame
  double ns_p50 = 0;
  double ns_p90 = 0;  // all 0: not timed
  TimeOutcome outcome = TimeOutcome::kOk;
};
// Timed, and p90 is more than 1.15 times p10: believe the median less.
[[nodiscard]] bool is_unstable(const TimeRow& row);

// Text: columns aligned, one row a line, a line of names on top, units in the names. Ends with a newline.
[[nodiscard]] std::string table_of(std::span<const PictureRow> rows);
// Single lines of such a table, to print each row when it is there: columns of fixed width, the names with those of a
// first row.
[[nodiscard]] std::string table_line_of(const PictureRow& row);
[[nodiscard]] std::string table_names_of(const PictureRow& first_row);
[[nodiscard]] std::string table_of(std::span<const TimeRow> rows);
// One JSON object a line with the names of the struct. A number that is not finite is written as null.
[[nodiscard]] std::string json_lines_of(std::span<const PictureRow> rows);
[[nodiscard]] std::string json_lines_of(std::span<const TimeRow> rows);
// Comma-separated with a header line; texts are quoted where they need it (RFC 4180), lines end with CR LF.
[[nodiscard]] std::string csv_of(std::span<const PictureRow> rows);
[[nodiscard]] std::string csv_of(std::span<const TimeRow> rows);
// Rows back from JSON lines, for comparing with an older report. Names the line that is wrong.
[[nodiscard]] Result<std::vector<PictureRow>> picture_rows_from_json_lines(const std::string& text,
                                                                           const std::string& name);

// One curve of a plot: points of positive finite cost and error; others are left out.
struct CurvePoint {
  double cost = 0;
  double error = 0;
  std::string label;  // of the knob: "n=4"; may be empty
};
struct Curve {
  std::string name;
  std::vector<CurvePoint> points;
};

// One curve a method, in order of first appearance: error rel_l2 against ms_p50 or ns_p50. Failed rows are not points;
// an error of 0 stands as kLeastError, so that it has a logarithm. Give rows of one scene.
inline constexpr double kLeastError = 1e-17;
[[nodiscard]] std::vector<Curve> curves_of(std::span<const PictureRow> rows);
[[nodiscard]] std::vector<Curve> curves_of(std::span<const TimeRow> rows);

struct PlotText {
  std::string title;
  std::string subtitle;    // the machine, the command
  std::string cost_axis;   // "time a frame, ms"
  std::string error_axis;  // "relative L2 error"
};

// A log-log plot of error against cost as an SVG file of its own; one colour a method, legend at the right.
[[nodiscard]] std::string svg_plot(const PlotText& text, std::span<const Curve> curves);

// Least cost at which a curve reaches an error, by linear interpolation of the logarithms between neighbours in order
// of cost. A curve whose every point is at or below the error gives its cheapest point's cost. Empty: not reached.
[[nodiscard]] std::optional<double> cost_at_error(const Curve& curve, double error);
// Least error that a curve reaches within a cost, likewise. Empty: every point costs more.
[[nodiscard]] std::optional<double> error_at_cost(const Curve& curve, double cost);
// Order of convergence: minus the least-squares slope of log error over log cost. Empty where the costs
// differ by less than a tenth: then the knob does not buy error with time.
[[nodiscard]] std::optional<double> order_of(const Curve& curve);

// "time at error 1e-2, 1e-3, 1e-4", "error at 1, 4, 16 ms" and the order, one line a method; "not reached" where so.
// cost_unit: "ms" or "ns".
[[nodiscard]] std::string summary_of(std::span<const Curve> curves, const std::string& cost_unit,
                                     std::span<const double> costs);

}  // namespace footlight::render
