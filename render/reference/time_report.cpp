#include "render/reference/time_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include <fmt/format.h>

#include "render/reference/time_bench.h"

namespace footlight::render {
namespace {

// Sums of logarithms, for geometric means.
struct LogMean {
  double sum = 0;
  int count = 0;

  void add(double value) {
    sum += std::log(std::max(value, kLeastError));
    ++count;
  }
  [[nodiscard]] double value() const { return count > 0 ? std::exp(sum / count) : 0; }
};

using SceneKey = std::tuple<double, double, double>;
SceneKey scene_of(const TimeRow& row) { return {row.tau_ms, row.fps, row.seconds}; }

std::string text_of(double value) { return fmt::format("{:.2g}", value); }

// Columns of minimal width; the first `words` of them are left-aligned.
std::string columns_of(const std::vector<std::vector<std::string>>& lines, std::size_t words) {
  std::vector<std::size_t> widths(lines[0].size(), 0);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const auto& line : lines) {
    std::string out;
    for (std::size_t c = 0; c < line.size(); ++c) {
      if (c > 0) out += "  ";
      out += c < words ? fmt::format("{:<{}}", line[c], widths[c]) : fmt::format("{:>{}}", line[c], widths[c]);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + "\n";
  }
  return text;
}

std::vector<SceneKey> scenes_of(const std::vector<TimeRow>& rows) {
  std::vector<SceneKey> scenes;
  for (const TimeRow& row : rows) {
    if (std::find(scenes.begin(), scenes.end(), scene_of(row)) == scenes.end()) scenes.push_back(scene_of(row));
  }
  return scenes;
}

std::vector<std::string> methods_of(const std::vector<TimeRow>& rows) {
  std::vector<std::string> methods;
  for (const TimeRow& row : rows) {
    if (std::find(methods.begin(), methods.end(), row.method) == methods.end()) methods.push_back(row.method);
  }
  return methods;
}

// The points of a method in one scene, one per knob, with one of the errors of a row.
Curve curve_in(const std::vector<TimeRow>& rows, const std::string& method, const SceneKey& scene,
               double TimeRow::*error) {
  Curve curve;
  for (const TimeRow& row : rows) {
    if (row.method != method || scene_of(row) != scene || row.outcome != TimeOutcome::kOk) continue;
    curve.points.push_back({row.ns_p50, std::max(row.*error, kLeastError), ""});
  }
  return curve;
}

}  // namespace

TimeReportOptions quick_time_report() {
  TimeReportOptions options;
  options.fps = {24, 60};
  options.tau_ms = {3, 350};
  options.substeps = {1, 16};
  options.tolerances = {1e-3, 1e-7};
  options.strobe_hz = {1.3, 25};
  options.spin_s = {3600, 86'400};
  options.seconds = 4;
  return options;
}

void add_time_part(int part, const TimeReportOptions& options, TimeReport& report) {
  using Part = void (*)(const TimeReportOptions&, TimeReport&);
  constexpr std::array<Part, kTimePartCount> kParts{report_filament,  report_motion, report_strobe,    report_spin,
                                                    report_smoothing, report_belt,   report_led,       report_mains,
                                                    report_dimmer,    report_pulse,  report_discharge, report_jerk};
  kParts.at(static_cast<std::size_t>(part))(options, report);
}

TimeReport time_report(const TimeReportOptions& options) {
  TimeReport report;
  for (int part = 0; part < kTimePartCount; ++part) add_time_part(part, options, report);
  return report;
}

std::vector<TimeSummary> summaries_of(const std::vector<TimeRow>& rows) {
  struct Gathered {
    TimeSummary summary;
    LogMean rel_l2;
    LogMean ns;
  };
  std::vector<Gathered> all;
  for (const TimeRow& row : rows) {
    auto at = std::find_if(all.begin(), all.end(), [&](const Gathered& g) {
      return g.summary.model == row.model && g.summary.method == row.method && g.summary.knob == row.knob;
    });
    if (at == all.end()) {
      at = all.emplace(all.end());
      at->summary.model = row.model;
      at->summary.method = row.method;
      at->summary.knob = row.knob;
      at->summary.error_worst = -1;
    }
    TimeSummary& summary = at->summary;
    const bool failed = row.outcome != TimeOutcome::kOk;
    ++summary.scenes;
    summary.failed += failed ? 1 : 0;
    summary.unstable += is_unstable(row) ? 1 : 0;
    at->rel_l2.add(failed ? 1 : std::min(row.rel_l2, 1.0));
    if (row.ns_p50 > 0) at->ns.add(row.ns_p50);
    if (!failed) summary.rel_l2_worst = std::max(summary.rel_l2_worst, row.rel_l2);
    if (row.error_max > summary.error_worst) {
      summary.error_worst = row.error_max;
      summary.worst_tau_ms = row.tau_ms;
      summary.worst_fps = row.fps;
      summary.outcome = word_of(row.outcome);
    }
  }
  std::vector<TimeSummary> summaries;
  for (Gathered& gathered : all) {
    gathered.summary.rel_l2_mean = gathered.rel_l2.value();
    gathered.summary.ns_mean = gathered.ns.value();
    summaries.push_back(std::move(gathered.summary));
  }
  return summaries;
}

std::string table_of(const std::vector<TimeSummary>& summaries, const std::string& unit) {
  std::vector<std::vector<std::string>> lines{{"method", "knob", "ns/frame", "unstable", "relL2 mean", "relL2 worst",
                                               "error worst, " + unit, "at tau, ms", "at fps", "failed", "worst"}};
  for (const TimeSummary& s : summaries) {
    lines.push_back({s.method, fmt::format("{:g}", s.knob), s.ns_mean > 0 ? fmt::format("{:.3g}", s.ns_mean) : "-",
                     fmt::format("{}/{}", s.unstable, s.scenes), text_of(s.rel_l2_mean),
                     s.failed == s.scenes ? "-" : text_of(s.rel_l2_worst), text_of(s.error_worst),
                     fmt::format("{:.3g}", s.worst_tau_ms), fmt::format("{:g}", s.worst_fps),
                     fmt::format("{}/{}", s.failed, s.scenes), s.outcome});
  }
  return columns_of(lines, 1);
}

std::string time_at_error_of(const std::vector<TimeRow>& rows, const std::string& ours) {
  const std::vector<SceneKey> scenes = scenes_of(rows);
  const std::vector<std::string> methods = methods_of(rows);
  const auto reached_text = [&](const LogMean& mean, int of) {
    if (mean.count == 0) return std::string("not reached");
    const std::string value = fmt::format("{:.3g}", mean.value());
    return mean.count == of ? value : fmt::format("{} ({}/{})", value, mean.count, of);
  };
  std::vector<std::vector<std::string>> lines{
      {"method", "ns at 1e-2", "ns at 1e-3", "ns at 1e-4", "times ours", "least", "by largest error", "least"}};
  for (const std::string& method : methods) {
    std::vector<std::string> line{method};
    const auto count = static_cast<int>(std::count_if(scenes.begin(), scenes.end(), [&](const SceneKey& scene) {
      return std::any_of(rows.begin(), rows.end(),
                         [&](const TimeRow& row) { return row.method == method && scene_of(row) == scene; });
    }));
    for (const double error : {1e-2, 1e-3, 1e-4}) {
      LogMean mean;
      for (const SceneKey& scene : scenes) {
        if (const auto ns = cost_at_error(curve_in(rows, method, scene, &TimeRow::rel_l2), error)) mean.add(*ns);
      }
      line.push_back(reached_text(mean, count));
    }
    for (double TimeRow::*const error : {&TimeRow::rel_l2, &TimeRow::error_max}) {
      LogMean ratio;
      double least = std::numeric_limits<double>::infinity();
      for (const SceneKey& scene : scenes) {
        const Curve mine = curve_in(rows, ours, scene, error);
        if (mine.points.empty()) continue;
        if (const auto ns = cost_at_error(curve_in(rows, method, scene, error), mine.points[0].error)) {
          ratio.add(*ns / mine.points[0].cost);
          least = std::min(least, *ns / mine.points[0].cost);
        }
      }
      line.push_back(reached_text(ratio, count));
      line.push_back(ratio.count > 0 ? fmt::format("{:.3g}", least) : "-");
    }
    lines.push_back(std::move(line));
  }
  return columns_of(lines, 1);
}

std::string cheapest_rivals_of(const std::vector<TimeRow>& rows, const std::string& ours, double fps) {
  std::string text;
  for (const SceneKey& scene : scenes_of(rows)) {
    const auto& [tau_ms, scene_fps, seconds] = scene;
    const Curve mine = curve_in(rows, ours, scene, &TimeRow::error_max);
    if (scene_fps != fps || mine.points.empty()) continue;
    const CurvePoint& point = mine.points[0];
    text += fmt::format("tau {:.3g} ms, {:g} fps, {:g} s: {} has {:.2g} {} in {:.3g} ns; ", tau_ms, fps, seconds, ours,
                        point.error, rows[0].unit, point.cost);
    std::string best;
    double least_ns = std::numeric_limits<double>::infinity();
    for (const std::string& method : methods_of(rows)) {
      if (method == ours || method.ends_with(" f32") || method.ends_with(" f64")) continue;
      const auto ns = cost_at_error(curve_in(rows, method, scene, &TimeRow::error_max), point.error);
      if (!ns || !(*ns < least_ns)) continue;
      least_ns = *ns;
      best = method;
    }
    text += best.empty() ? "no other method is as accurate\n"
                         : fmt::format("as accurate: {} in {:.3g} times the time\n", best, least_ns / point.cost);
  }
  return text;
}

std::vector<Curve> curves_of(const std::vector<TimeSummary>& summaries) {
  std::vector<Curve> curves;
  for (const TimeSummary& s : summaries) {
    auto at = std::find_if(curves.begin(), curves.end(), [&](const Curve& c) { return c.name == s.method; });
    if (at == curves.end()) at = curves.insert(curves.end(), Curve{s.method, {}});
    if (s.failed == s.scenes) continue;
    at->points.push_back({s.ns_mean, std::max(s.rel_l2_mean, kLeastError), fmt::format("{:g}", s.knob)});
  }
  return curves;
}

}  // namespace footlight::render
