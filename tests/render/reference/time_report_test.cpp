#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/reference/time_bench.h"
#include "render/reference/time_report.h"

namespace {

using namespace footlight::render;

TimeReportOptions small_options() {
  TimeReportOptions options;
  options.fps = {15, 44, 240};
  options.spin_s = {3600};
  options.seconds = 4;
  options.runs = 0;
  return options;
}

const TimeReport& report() {
  static const TimeReport kReport = time_report(small_options());
  return kReport;
}

// The largest error of a method, in the unit of its model.
double worst(const std::string& model, const std::string& method) {
  double error = -1;
  for (const TimeRow& row : report().rows) {
    if (row.model == model && row.method == method) error = std::max(error, row.error_max);
  }
  REQUIRE(error >= 0);
  return error;
}

TimeRow row_at(const std::string& model, const std::string& method, double knob, double tau_ms, double fps) {
  for (const TimeRow& row : report().rows) {
    if (row.model == model && row.method == method && row.knob == knob && row.tau_ms == tau_ms && row.fps == fps) {
      return row;
    }
  }
  FAIL("no such row: ", model, " ", method, " ", knob, " ", tau_ms, " ", fps);
  return {};
}

TimeRow made_row(const std::string& method, double tau_ms, double rel_l2, double ns) {
  TimeRow row;
  row.model = "m";
  row.method = method;
  row.knob = 1;
  row.tau_ms = tau_ms;
  row.fps = 60;
  row.rel_l2 = rel_l2;
  row.error_max = rel_l2;
  row.ns_p10 = row.ns_p50 = row.ns_p90 = ns;
  return row;
}

}  // namespace

TEST_CASE("a report that ends early keeps its rows, equal to those of a full report, and measures no more") {
  TimeReportOptions options = small_options();
  int calls = 0;
  options.ended = [&] { return ++calls > 40; };
  const TimeReport part = time_report(options);
  REQUIRE(!part.rows.empty());
  REQUIRE(part.rows.size() <= 40);
  for (std::size_t i = 0; i < part.rows.size(); ++i) {
    CHECK(part.rows[i].method == report().rows[i].method);
    CHECK(part.rows[i].error_max == report().rows[i].error_max);
  }
}

TEST_CASE("every model has a row for each method, at every knob, stiffness and frame rate") {
  const TimeReportOptions options = small_options();
  const std::size_t fps = options.fps.size();
  const std::size_t scenes = options.tau_ms.size() * fps;
  const std::size_t steps = options.substeps.size();
  const std::size_t flashes = options.strobe_hz.size() * fps;
  const std::size_t spins = options.spin_hz.size() * fps;
  const std::map<std::string, std::map<std::string, std::size_t>> wanted = {
      {"filament",
       {{"universal curve f32", scenes},
        {"universal curve f64", scenes},
        {"explicit Euler", steps * scenes},
        {"RK4", steps * scenes},
        {"implicit Euler", steps * scenes},
        {"exp. Rosenbrock-Euler", steps * scenes},
        {"ROS2", steps * scenes},
        {"TR-BDF2", steps * scenes},
        {"Odeint Rosenbrock-4", options.tolerances.size() * scenes},
        {"CVODE BDF", has_cvode() ? options.tolerances.size() * scenes : 0}}},
      {"motion",
       {{"motor f32", scenes},
        {"motor f64", scenes},
        {"hold", scenes},
        {"explicit Euler", steps * scenes},
        {"semi-implicit Euler", steps * scenes},
        {"RK4", steps * scenes},
        {"trapezoid anew", steps * scenes},
        {"lerp a frame", 3 * scenes},
        {"exponential smoothing", 4 * scenes}}},
      {"strobe",
       {{"exposure integral f32", 2 * flashes},
        {"exposure integral f64", 2 * flashes},
        {"point samples", steps * flashes},
        {"point sample, float seconds", flashes}}},
      {"spin",
       {{"64-bit turns f32", spins},
        {"64-bit turns f64", spins},
        {"float sum", spins},
        {"wrapped float", spins},
        {"float seconds", spins},
        {"double sum", spins}}},
      {"smoothing",
       {{"exact f32", scenes},
        {"exact f64", scenes},
        {"lerp, fixed factor", scenes},
        {"lerp with dt", scenes},
        {"rational exp", steps * scenes},
        {"explicit Euler", steps * scenes},
        {"semi-implicit Euler", steps * scenes},
        {"implicit Euler", steps * scenes}}},
      {"led",
       {{"exact f32", scenes},
        {"exact f64", scenes},
        {"at the frame's end", scenes},
        {"lerp with dt", scenes},
        {"explicit Euler", steps * scenes},
        {"RK4", steps * scenes}}},
      {"mains",
       {{"exposure integral f32", 2 * fps},
        {"exposure integral f64", 2 * fps},
        {"rms", 2 * fps},
        {"point samples", 2 * steps * fps}}},
      {"belt",
       {{"propagator f32", scenes},
        {"propagator f64", scenes},
        {"semi-implicit Euler", steps * scenes},
        {"implicit Euler", steps * scenes},
        {"RK4", steps * scenes}}},
      {"dimmer",
       {{"law, then exact f32", scenes},
        {"law, then exact f64", scenes},
        {"law of the coarse byte", scenes},
        {"power 2.2", scenes},
        {"law of the lagging level", scenes}}},
      {"pulse",
       {{"exposure integral f32", flashes}, {"exposure integral f64", flashes}, {"point samples", steps * flashes}}},
      {"random-pulse",
       {{"exposure integral f32", flashes}, {"exposure integral f64", flashes}, {"point samples", steps * flashes}}},
      {"discharge",
       {{"exact f32", scenes},
        {"exact f64", scenes},
        {"on and off", scenes},
        {"explicit Euler, events polled", steps * scenes},
        {"RK4, events polled", steps * scenes}}},
      {"jerk",
       {{"exact f32", scenes},
        {"exact f64", scenes},
        {"none", scenes},
        {"two lerps with dt", steps * scenes},
        {"semi-implicit Euler", steps * scenes}}},
  };
  std::size_t all = 0;
  for (const auto& [model, methods] : wanted) {
    for (const auto& [method, count] : methods) {
      CAPTURE(model);
      CAPTURE(method);
      const auto found = std::count_if(report().rows.begin(), report().rows.end(),
                                       [&](const TimeRow& row) { return row.model == model && row.method == method; });
      CHECK(static_cast<std::size_t>(found) == count);
      all += count;
    }
  }
  CHECK(report().rows.size() == all);
  for (const TimeRow& row : report().rows) CHECK(row.ns_p50 == 0);
}

TEST_CASE("each judge's error is small enough for a report at 1e-12, and an independent judge agrees") {
  struct Bound {
    double own;
    double difference;
  };
  const std::map<std::string, Bound> bounds = {
      {"filament", {3200e-12, 1e-6}},  // K; the quadrature is in double and divides by the derivative
      {"motion", {1e-12, 1e-6}},       // the second judge has steps of a microsecond
      {"strobe", {1e-12, 1e-12}},
      {"spin", {1e-12, 1e-11}},
      {"smoothing", {1e-12, 1e-11}},
      {"belt", {1e-12, 1e-11}},
      {"led", {1e-12, 1e-6}},  // the second judge uses means of two points
      {"mains", {1e-12, 1e-12}},
      {"dimmer", {1e-12, 1e-6}},  // as for the LED
      {"pulse", {1e-12, 1e-6}},   // the second judge samples
      {"random-pulse", {1e-12, 1e-6}},
      // Both judges have steps, so their bounds are larger.
      {"discharge", {1e-8, 1e-6}},
      {"jerk", {1e-7, 1e-6}},
  };
  REQUIRE(report().judges.size() == bounds.size());
  for (const JudgeError& judge : report().judges) {
    CAPTURE(judge.model);
    CHECK(judge.own < bounds.at(judge.model).own);
    CHECK(judge.difference < bounds.at(judge.model).difference);
    CHECK(judge.difference > 0);  // the second judge has run
  }
}

// Measured over the default sweep, times three or more for the rounding of other compilers.
TEST_CASE("the exact models differ from their judges by rounding only, at every stiffness and frame rate") {
  CHECK(worst("filament", "universal curve f64") < 0.05);  // K
  CHECK(worst("filament", "universal curve f32") < 0.05);
  CHECK(worst("smoothing", "exact f64") < 1e-14);
  CHECK(worst("smoothing", "exact f32") < 1e-6);
  CHECK(worst("motion", "motor f64") < 1e-14);
  CHECK(worst("motion", "motor f32") < 1e-6);
  CHECK(worst("strobe", "exposure integral f64") < 1e-12);
  CHECK(worst("strobe", "exposure integral f32") < 1e-5);
  CHECK(worst("spin", "64-bit turns f64") < 1e-10);
  CHECK(worst("spin", "64-bit turns f32") < 1e-10);
  CHECK(worst("mains", "exposure integral f64") < 1e-12);
  CHECK(worst("mains", "exposure integral f32") < 1e-5);
  CHECK(worst("led", "exact f64") < 1e-3);  // the droop at the frame's end is used for the whole frame
  CHECK(worst("led", "exact f32") < 1e-3);
  CHECK(worst("belt", "propagator f64") < 1e-13);
  CHECK(worst("belt", "propagator f32") < 1.5e-5);
  CHECK(worst("dimmer", "law, then exact f64") < 1e-3);  // as for the LED
  CHECK(worst("dimmer", "law, then exact f32") < 1e-3);
  CHECK(worst("pulse", "exposure integral f64") < 1e-12);
  CHECK(worst("pulse", "exposure integral f32") < 1e-5);
  CHECK(worst("random-pulse", "exposure integral f64") < 1e-12);
  CHECK(worst("random-pulse", "exposure integral f32") < 1e-5);
  CHECK(worst("discharge", "exact f64") < 1e-8);  // error of the judge's steps
  CHECK(worst("discharge", "exact f32") < 1e-5);
  CHECK(worst("jerk", "exact f64") < 1e-7);
  CHECK(worst("jerk", "exact f32") < 1e-5);
}

TEST_CASE("methods that diverge have rows with that outcome") {
  CHECK(row_at("filament", "explicit Euler", 1, 3, 15).outcome == TimeOutcome::kDiverged);
  CHECK(row_at("filament", "RK4", 1, 3, 15).outcome == TimeOutcome::kDiverged);
  CHECK(row_at("belt", "RK4", 1, 3, 15).outcome == TimeOutcome::kNonFinite);
  CHECK(row_at("belt", "RK4", 1, 350, 240).outcome == TimeOutcome::kOk);
  CHECK(row_at("smoothing", "explicit Euler", 1, 3, 15).outcome == TimeOutcome::kDiverged);
  CHECK(row_at("smoothing", "explicit Euler", 64, 3, 15).outcome == TimeOutcome::kOk);
  for (const TimeRow& row : report().rows) {
    CHECK(std::isfinite(row.rel_l2) == (row.outcome != TimeOutcome::kNonFinite));
  }
}

TEST_CASE(
    "methods are more accurate with more steps per frame, but with 64 less accurate than the exact models in float") {
  for (const TimeRow& coarse : report().rows) {
    const bool motion = coarse.model == "motion" && coarse.method != "lerp a frame";
    if (coarse.knob != 1 || !(motion || coarse.model == "filament" || coarse.model == "belt")) continue;
    const bool ours = coarse.method.find("f32") != std::string::npos || coarse.method.find("f64") != std::string::npos;
    if (ours || coarse.method == "hold") continue;
    CAPTURE(coarse.model);
    CAPTURE(coarse.method);
    CAPTURE(coarse.tau_ms);
    CAPTURE(coarse.fps);
    const TimeRow fine = row_at(coarse.model, coarse.method, 64, coarse.tau_ms, coarse.fps);
    CHECK(fine.rel_l2 < coarse.rel_l2);
    if (motion) CHECK(fine.error_max > row_at("motion", "motor f32", 1, coarse.tau_ms, coarse.fps).error_max);
  }
}

TEST_CASE("libraries are more accurate with a finer tolerance and reach a thousandth of a kelvin") {
  for (const std::string method : {"Odeint Rosenbrock-4", "CVODE BDF"}) {
    if (method == "CVODE BDF" && !has_cvode()) continue;
    for (const double tau_ms : small_options().tau_ms) {
      CAPTURE(method);
      CAPTURE(tau_ms);
      CHECK(row_at("filament", method, 1e-9, tau_ms, 44).error_max <
            row_at("filament", method, 1e-5, tau_ms, 44).error_max);
      CHECK(row_at("filament", method, 1e-9, tau_ms, 44).error_max < 1e-3);
    }
  }
}

TEST_CASE("sums in float lose a tenth of a turn in an hour, and sampled strobes a third of a frame's light") {
  CHECK(worst("spin", "float sum") > 0.1);
  CHECK(worst("strobe", "point samples") > 0.3);
}

TEST_CASE("without timing the rows are equal on every run, and another seed gives another show") {
  TimeReportOptions options = small_options();
  options.tau_ms = {34};
  options.fps = {60};
  options.seconds = 2;
  options.spin_s = {10};
  const std::string once = json_lines_of(time_report(options).rows);
  CHECK(once == json_lines_of(time_report(options).rows));
  options.seed = 2;
  CHECK(once != json_lines_of(time_report(options).rows));
}

TEST_CASE("with timing every method has a time") {
  TimeReportOptions options;
  options.tau_ms = {34};
  options.fps = {24};
  options.strobe_hz = {10};
  options.spin_s = {10};
  options.substeps = {1};
  options.tolerances = {1e-3};
  options.seconds = 0.5;
  options.runs = 3;
  for (const TimeRow& row : time_report(options).rows) {
    CAPTURE(row.method);
    CHECK(row.ns_p10 > 0);
    CHECK(row.ns_p10 <= row.ns_p50);
    CHECK(row.ns_p50 <= row.ns_p90);
  }
}

TEST_CASE("values are ok, useless, diverged or non-finite, compared with the judge's") {
  const TimeScene scene{.model = "m", .unit = "K", .judge = {0, 1, 0.5}, .unit_scale = 100};
  const auto row = [&](std::vector<double> values) { return time_row_of(scene, "x", 1, values); };
  CHECK(row({0, 1, 0.5}).error_max == 0);
  CHECK(row({0, 1, 0.5}).outcome == TimeOutcome::kOk);
  CHECK(row({0.05, 1, 0.5}).error_max == doctest::Approx(5));
  CHECK(row({0, 0, 0}).outcome == TimeOutcome::kUseless);
  CHECK(row({0, 1.2, 0.5}).outcome == TimeOutcome::kDiverged);
  CHECK(row({0, 1, std::numeric_limits<double>::quiet_NaN()}).outcome == TimeOutcome::kNonFinite);
  CHECK(row({0, 1, -std::numeric_limits<double>::infinity()}).outcome == TimeOutcome::kNonFinite);
  CHECK(std::isinf(row({0, 1, std::numeric_limits<double>::quiet_NaN()}).error_max));
}

TEST_CASE("differences of float and double are three per model, largest first, and a longer search finds larger ones") {
  const std::vector<Disagreement> some = worst_disagreements(500);
  const std::vector<Disagreement> more = worst_disagreements(5000);
  REQUIRE(some.size() % kWorstCount == 0);
  REQUIRE(some.size() == more.size());
  bool grew = false;
  for (std::size_t i = 0; i < some.size(); ++i) {
    CAPTURE(more[i].model);
    CAPTURE(more[i].input);
    CHECK(more[i].model == some[i - i % kWorstCount].model);
    CHECK(more[i].error == std::abs(more[i].f32 - more[i].f64));
    CHECK(more[i].error >= some[i].error);
    if (i % kWorstCount > 0) CHECK(more[i].error <= more[i - 1].error);
    CHECK(more[i].input.find('=') != std::string::npos);
    grew = grew || more[i].error > some[i].error;
  }
  CHECK(grew);
}

TEST_CASE("float and double agree on every model's step within the resolution of float") {
  const std::map<std::string, double> bounds = {
      {"motor", 1e-4}, {"belt", 1e-4},  {"smoothing", 1e-6}, {"filament", 0.1}, {"filament light", 1e-5},
      {"led", 1e-4},   {"mains", 1e-3}, {"shutter", 1e-3},   {"turns", 1e-15},  {"dimmer law", 1e-6},
  };
  const std::vector<Disagreement> worst_of_all = worst_disagreements(20'000);
  CHECK(worst_of_all.size() == kWorstCount * bounds.size());
  for (const Disagreement& d : worst_of_all) {
    CAPTURE(d.model);
    CAPTURE(d.input);
    CHECK(d.error <= bounds.at(d.model));
  }
}

TEST_CASE("p10 and p90 of eleven runs are the second and the tenth") {
  const NsPerFrame ns = percentiles_of({11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1});
  CHECK(ns.p10 == 2);
  CHECK(ns.p50 == 6);
  CHECK(ns.p90 == 10);
}

TEST_CASE("a failed scene counts as an error of 1 in the mean, and the worst scene is named") {
  TimeRow failed = made_row("a", 3, 1e6, 40);
  failed.outcome = TimeOutcome::kDiverged;
  const std::vector<TimeSummary> summaries = summaries_of({made_row("a", 34, 1e-4, 10), failed});
  REQUIRE(summaries.size() == 1);
  CHECK(summaries[0].rel_l2_mean == doctest::Approx(1e-2));
  CHECK(summaries[0].rel_l2_worst == 1e-4);
  CHECK(summaries[0].error_worst == 1e6);
  CHECK(summaries[0].worst_tau_ms == 3);
  CHECK(summaries[0].failed == 1);
  CHECK(summaries[0].ns_mean == doctest::Approx(20));
  CHECK(table_of(summaries, "K").find("diverged") != std::string::npos);
}

TEST_CASE("time at an error is a mean over the scenes that reach it, with their number") {
  const std::vector<TimeRow> rows = {made_row("ours", 3, 1e-5, 10), made_row("ours", 34, 1e-5, 10),
                                     made_row("rival", 3, 1e-1, 20), made_row("rival", 34, 1e-6, 300)};
  const std::string text = time_at_error_of(rows, "ours");
  CHECK(text.find("300 (1/2)") != std::string::npos);
  CHECK(text.find("30 (1/2)") != std::string::npos);  // relative to `ours`
  const std::string cheapest = cheapest_rivals_of(rows, "ours", 60);
  CHECK(cheapest.find("no other method is as accurate") != std::string::npos);
  CHECK(cheapest.find("rival in 30 times the time") != std::string::npos);
  const std::string never = time_at_error_of({made_row("ours", 3, 1e-5, 10), made_row("rival", 3, 1e-1, 20)}, "ours");
  CHECK(never.find("not reached") != std::string::npos);
}
