// footlight report --time: error against run time of motors, lamps, shutters and filters.
#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "render/reference/report.h"
#include "render/reference/time_report.h"
#include "tools/footlight/report/report_parts.h"

namespace footlight::tools {
namespace {

struct TimeArguments {
  bool rows = false;
  bool worst = false;
};

struct ModelText {
  const char* model;
  const char* ours;  // the method that the others are compared with
  const char* title;
};
constexpr ModelText kModels[] = {
    {"filament", "universal curve f32", "Filament: temperature during jumps, fades and chases; relL2 of the light"},
    {"motion", "motor f32", "Motion: position of 540 degrees of pan; tau = top speed over acceleration"},
    {"strobe", "exposure integral f32", "Strobe: the open share of each frame; tau = flash period"},
    {"spin", "64-bit turns f32",
     "Spin: phase after an hour, a day, a month; tau = time of one turn; relL2 of the direction"},
    {"smoothing", "exact f32", "Smoothing of levels: two equal poles of tau"},
    {"belt", "propagator f32", "Belt resonance: damping 0.05; tau = 1 / angular frequency"},
    {"led", "exact f32", "LED: mean light of a driver that rises in tau and a heat sink of 60 s, droop 1/8"},
    {"mains", "exposure integral f32", "Phase-cut dimmer with a lamp without inertia: mean power; tau = a half wave"},
    {"dimmer", "law, then exact f32", "Dimmer law (square), then an LED driver that rises in tau: mean light"},
    {"pulse", "exposure integral f32", "Pulses: the open share of each frame; tau = pulse period, duty 3/8"},
    {"random-pulse", "exposure integral f32", "Random pulses, one per period: the open share of each frame"},
    {"discharge", "exact f32", "Discharge: mean light of an arc that locks out, strikes and runs up in tau"},
    {"jerk", "exact f32", "Jerk smoothing of 540 degrees of pan in 2.45 s: position; tau = the lag"},
};

// Prints inputs below their numbers, because they are long.
void print_worst(const ReportOptions& options) {
  const auto worst = options.quick ? render::worst_disagreements(20'000) : render::worst_disagreements();
  if (options.json) {
    fmt::print("{}", render::json_lines_of(worst));
    return;
  }
  fmt::print(
      "Largest differences between float and double: one step from random states, the {} largest of each model.\n\n",
      render::kWorstCount);
  for (const render::Disagreement& d : worst) {
    fmt::print("{:<15} {:.1e} {:<6} float {:.9g}, double {:.17g}\n                {}\n", d.model, d.error, d.unit,
               d.f32, d.f64, d.input);
  }
}

// Prints the tables, and writes the plots, of the models whose rows start at `first`.
Status show_models(const TimeArguments& arguments, const ReportOptions& options,
                   const render::TimeReportOptions& time_options, const render::TimeReport& report, std::size_t first) {
  const std::vector<render::TimeRow> new_rows(report.rows.begin() + static_cast<std::ptrdiff_t>(first),
                                              report.rows.end());
  const auto summaries = render::summaries_of(new_rows);
  for (const ModelText& text : kModels) {
    std::vector<render::TimeSummary> summary;
    std::copy_if(summaries.begin(), summaries.end(), std::back_inserter(summary),
                 [&](const auto& s) { return s.model == text.model; });
    std::vector<render::TimeRow> rows;
    std::copy_if(new_rows.begin(), new_rows.end(), std::back_inserter(rows),
                 [&](const auto& r) { return r.model == text.model; });
    if (rows.empty()) continue;
    if (!options.json) {
      std::string shown = fmt::format("{}\n", text.title);
      for (const render::JudgeError& judge : report.judges) {
        if (judge.model != text.model) continue;
        shown += fmt::format("Judge: {}: {:.1e} {}. Second judge: {}: {:.1e} {}.\n", judge.judge, judge.own, judge.unit,
                             judge.second, judge.difference, judge.unit);
      }
      shown += fmt::format("\n{}\n", render::table_of(summary, rows.front().unit));
      shown += fmt::format("{}\n", render::time_at_error_of(rows, text.ours));
      shown += fmt::format("{}\n",
                           render::cheapest_rivals_of(rows, text.ours, time_options.fps[time_options.fps.size() / 3]));
      if (arguments.rows) shown += fmt::format("{}\n", render::table_of(rows));
      options.print(shown);
    }
    if (!options.svg.empty()) {
      FL_TRY(write_report_file(
          with_report_suffix(options.svg, fmt::format("time-{}", text.model)),
          render::svg_plot({text.title, fmt::format("geometric means over {} scenes; one CPU core", summary[0].scenes),
                            "time per frame, ns", "relative L2 error"},
                           render::curves_of(summary))));
    }
  }
  return {};
}

Status report_time(const TimeArguments& arguments, const ReportOptions& options) {
  if (arguments.worst) {
    print_worst(options);
    return {};
  }
  render::TimeReportOptions time_options = options.quick ? render::quick_time_report() : render::TimeReportOptions{};
  render::TimeReport report;
  int part = 0;
  std::size_t printed = 0;
  bool ended = false;
  const auto print_rows = [&] {
    if (options.json) options.print(render::json_lines_of(std::span(report.rows).subspan(printed)));
    printed = report.rows.size();
  };
  time_options.ended = [&] {
    if (printed != report.rows.size()) print_rows();
    ended = ended || !options.go_on("models of time behaviour", part, render::kTimePartCount);
    return ended;
  };
  if (!options.json) {
    options.print(fmt::format(
        "Time behaviour: error against run time on one CPU core. Inputs change at 44 Hz and are held for a frame.\n"
        "Each scene is {:g} s of show. Scenes: tau {} ms (unless the model states another) x {} frames per second.\n"
        "Times: median of {} runs after 3 warm-up runs, geometric mean over the scenes. Unstable: p90 > 1.15 p10.\n"
        "relL2 mean: geometric mean; a failed scene counts as 1. Failed: diverged, non-finite, or relL2 >= 0.999.\n"
        "{}\n",
        time_options.seconds, fmt::join(time_options.tau_ms, ", "), fmt::join(time_options.fps, ", "),
        time_options.runs, render::has_cvode() ? "" : "Built without CVODE.\n"));
  }
  for (; part < render::kTimePartCount && !ended; ++part) {
    const std::size_t first = report.rows.size();
    render::add_time_part(part, time_options, report);
    print_rows();
    FL_TRY(show_models(arguments, options, time_options, report, first));
  }
  if (!options.csv.empty()) {
    FL_TRY(write_report_file(with_report_suffix(options.csv, "time"), render::csv_of(report.rows)));
  }
  return {};
}

}  // namespace

ReportHalf add_report_time(Arguments& arguments) {
  auto chosen = std::make_shared<TimeArguments>();
  arguments.flag("--rows", chosen->rows, "with --time: print every scene, not only the means");
  arguments.flag("--worst", chosen->worst,
                 "with --time: print the largest differences between float and double instead of the rows");
  return [chosen](const ReportOptions& options) { return report_time(*chosen, options); };
}

}  // namespace footlight::tools
