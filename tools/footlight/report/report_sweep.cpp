#include "tools/footlight/report/report_sweep.h"

#include <algorithm>

#include <fmt/format.h>

namespace footlight::tools {
namespace {

// One curve for each method and knob: time against the value. `at`: the value of each row.
std::vector<render::Curve> curves_of_sweep(const std::vector<render::PictureRow>& rows, const std::vector<double>& at) {
  std::vector<render::Curve> curves;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].method.ends_with(", fitted")) continue;  // takes the time of the row before
    const std::string name = fmt::format("{} {:g}", rows[i].method, rows[i].knob);
    auto curve = std::find_if(curves.begin(), curves.end(), [&](const auto& each) { return each.name == name; });
    if (curve == curves.end()) curve = curves.insert(curve, {name, {}});
    curve->points.push_back({at[i], rows[i].ms_p50, ""});
  }
  return curves;
}

}  // namespace

Status report_sweep(render::vk::Device& device, const Sweep& sweep, const SweepScene& scene,
                    PictureReportOptions pictures, const ReportOptions& options) {
  std::vector<render::PictureRow> rows;
  std::vector<double> at;
  std::string of_device;
  bool first = true;
  for (const double value : sweep.values) {
    FL_ASSIGN(const Scene made, scene_of_sweep(sweep, value, scene, pictures));
    pictures.on_row = [&](const PictureReport& so_far) {
      const render::PictureRow& row = so_far.rows.back();
      if (options.json) {
        options.print(render::json_lines_of({&row, 1}));
      } else {
        options.print((first ? render::table_names_of(row) : "") + render::table_line_of(row));
      }
      first = false;
    };
    FL_ASSIGN(const PictureReport report, make_picture_report(device, made, pictures));
    of_device = report.device;
    rows.insert(rows.end(), report.rows.begin(), report.rows.end());
    at.insert(at.end(), report.rows.size(), value);
    if (report.ended) break;
  }
  if (!options.csv.empty()) FL_TRY(write_report_file(options.csv, render::csv_of(rows)));
  if (!options.svg.empty()) {
    FL_TRY(write_report_file(options.svg, render::svg_plot({fmt::format("cost against {}", axis_of(sweep)), of_device,
                                                            axis_of(sweep), "GPU time per frame, ms"},
                                                           curves_of_sweep(rows, at))));
  }
  return {};
}

}  // namespace footlight::tools
