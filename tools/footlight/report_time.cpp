// footlight report --time: error against run time of what moves, glows and flashes.
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "render/reference/report.h"
#include "render/reference/time_report.h"
#include "tools/footlight/report_parts.h"

namespace footlight::tools {
namespace {

Status report_time(const ReportOptions& options) {
  render::TimeReportOptions time_options;
  if (options.quick) {
    time_options.stiffness_per_s = {20, 200};
    time_options.fps = {30, 60};
    time_options.substeps = {1, 16};
    time_options.seconds = 5;
  }
  const auto rows = render::time_rows(time_options);
  if (options.json) {
    fmt::print("{}", render::json_lines_of(rows));
  } else {
    fmt::print("Motors and shutters: error against run time on one CPU core; the judge's own error is {:.1e}.\n\n",
               render::axis_judge_own_error(time_options));
    fmt::print("{}\n", render::table_of(rows));
  }
  const std::string csv = options.csv.empty() ? "" : with_report_suffix(options.csv, "time");
  if (!csv.empty()) FL_TRY(write_report_file(csv, render::csv_of(rows)));
  if (!options.svg.empty()) {
    std::vector<render::TimeRow> axis;
    for (const auto& row : rows) {
      if (row.model == "axis" && row.stiffness == 20 && row.fps == 60) axis.push_back(row);
    }
    FL_TRY(write_report_file(with_report_suffix(options.svg, "time"),
                             render::svg_plot({"axis: 540 degrees of pan, stiffness 20 /s, 60 fps", "one CPU core",
                                               "time a step, ns", "largest error over the range"},
                                              render::curves_of(axis))));
  }
  return {};
}

}  // namespace

ReportHalf add_report_time(Arguments&) { return report_time; }

}  // namespace footlight::tools
