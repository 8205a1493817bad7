// Error against run time as rows, tables, JSON lines, CSV and a plot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/result.h"

namespace footlight::render {

// One picture of one scene by one method at one knob value.
struct PictureRow {
  std::string scene;
  std::string method;
  double knob = 0;         // the quality setting of the method: nodes, steps
  double hits_per_px = 0;  // mean number of beams that the visible part of a pixel's ray crosses
  double ms_p10 = 0;       // time per frame
  double ms_p50 = 0;
  double ms_p90 = 0;
  double own_ms = 0;  // median, of the passes in which methods differ: light in the haze, or on surfaces
  double rel_l2 = 0;  // defined in norms.h
  // 95 % confidence interval of rel_l2 if only a sample of the pixels is judged; else equal to rel_l2
  double rel_l2_low = 0;
  double rel_l2_high = 0;
  double rel_mse = 0;
  double p999 = 0;
  double max = 0;
  double flip = 0;  // NaN if only a sample is judged, because FLIP compares neighbouring pixels
  std::int64_t nonfinite = 0;
  std::int64_t bytes = 0;  // GPU memory that the method allocates
};

// How a run of a time-dependent model ended.
enum class TimeOutcome {
  kOk,
  kUseless,    // relative L2 error of 0.999 or more: no better than darkness
  kDiverged,   // a value left the range of the judge's values by more than a tenth of it
  kNonFinite,  // a value was infinite or NaN
};
[[nodiscard]] const char* word_of(TimeOutcome outcome);  // "ok", "useless", "diverged", "non-finite"

// One method at one knob value, on one scene of one time-dependent model.
struct TimeRow {
  std::string model;  // "filament", "motion", "strobe", "spin", "smoothing", "belt"
  std::string method;
  double knob = 0;    // sub-steps or samples per frame; a tolerance; 1 if there is none
  double tau_ms = 0;  // the time constant of the scene (time_report.h); a short one is stiff
  double fps = 0;
  double seconds = 0;    // simulated time, until the last value that is judged
  double error_max = 0;  // largest absolute error, in `unit`
  std::string unit;      // "K", "range", "share", "turn"
  double rel_l2 = 0;     // of the visible quantity: light, position, direction
  double ns_p10 = 0;     // time per frame
  double ns_p50 = 0;
  double ns_p90 = 0;  // all 0: not timed
  TimeOutcome outcome = TimeOutcome::kOk;
};
// True if the row is timed and p90 is more than 1.15 times p10: the median is uncertain.
[[nodiscard]] bool is_unstable(const TimeRow& row);

// A text table: aligned columns, one row per line, a header line with units. Ends with a newline.
[[nodiscard]] std::string table_of(std::span<const PictureRow> rows);
// Single lines of such a table, for printing each row when it is measured. Columns have fixed width. The header is made
// from the first row.
[[nodiscard]] std::string table_line_of(const PictureRow& row);
[[nodiscard]] std::string table_names_of(const PictureRow& first_row);
[[nodiscard]] std::string table_of(std::span<const TimeRow> rows);
// One JSON object per line, with the names of the struct. A number that is not finite is written as null.
[[nodiscard]] std::string json_lines_of(std::span<const PictureRow> rows);
[[nodiscard]] std::string json_lines_of(std::span<const TimeRow> rows);
// Comma-separated values with a header line. Texts are quoted if necessary (RFC 4180), lines end with CR LF.
[[nodiscard]] std::string csv_of(std::span<const PictureRow> rows);
[[nodiscard]] std::string csv_of(std::span<const TimeRow> rows);
// Reads rows from JSON lines, to compare with an older report. The error names the wrong line.
[[nodiscard]] Result<std::vector<PictureRow>> picture_rows_from_json_lines(const std::string& text,
                                                                           const std::string& name);

// One curve of a plot. Points whose cost or error is not positive and finite are left out.
struct CurvePoint {
  double cost = 0;
  double error = 0;
  std::string label;  // the knob, "n=4"; may be empty
};
struct Curve {
  std::string name;
  std::vector<CurvePoint> points;
};

// Returns one curve per method, in order of first appearance: error rel_l2 against ms_p50 or ns_p50. Failed rows are
// left out. An error of 0 is drawn as kLeastError, so that it has a logarithm. All rows must be of one scene.
inline constexpr double kLeastError = 1e-17;
[[nodiscard]] std::vector<Curve> curves_of(std::span<const PictureRow> rows);
[[nodiscard]] std::vector<Curve> curves_of(std::span<const TimeRow> rows);

struct PlotText {
  std::string title;
  std::string subtitle;    // the machine, the command
  std::string cost_axis;   // "time per frame, ms"
  std::string error_axis;  // "relative L2 error"
};

// Returns a log-log plot of error against cost as a complete SVG file, with one colour per method and the legend at the
// right.
[[nodiscard]] std::string svg_plot(const PlotText& text, std::span<const Curve> curves);

// Returns the least cost at which a curve reaches an error, by linear interpolation of the logarithms between
// neighbours in order of cost. If all points are at or below the error, returns the cost of the cheapest. Empty: not
// reached.
[[nodiscard]] std::optional<double> cost_at_error(const Curve& curve, double error);
// Returns the least error that a curve reaches within a cost, in the same way. Empty: every point costs more.
[[nodiscard]] std::optional<double> error_at_cost(const Curve& curve, double cost);
// Order of convergence: minus the least-squares slope of log error over log cost. Empty if the costs differ by less
// than a tenth: then the knob does not change the time.
[[nodiscard]] std::optional<double> order_of(const Curve& curve);

// Returns a text with one line per method: "time at error 1e-2, 1e-3, 1e-4", "error at 1, 4, 16 ms" and the order, or
// "not reached". cost_unit: "ms" or "ns".
[[nodiscard]] std::string summary_of(std::span<const Curve> curves, const std::string& cost_unit,
                                     std::span<const double> costs);

}  // namespace footlight::render
