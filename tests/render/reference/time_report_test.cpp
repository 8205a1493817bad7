#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/reference/time_report.h"

namespace {

using namespace footlight::render;

const std::vector<TimeRow>& rows() {
  static const std::vector<TimeRow> kRows = [] {
    TimeReportOptions options;
    options.measure_time = false;
    return time_rows(options);
  }();
  return kRows;
}

double worst(const std::string& model, const std::string& method) {
  double error = -1;
  for (const TimeRow& row : rows()) {
    if (row.model == model && row.method == method) error = std::max(error, row.error_max);
  }
  REQUIRE(error >= 0);
  return error;
}

}  // namespace

TEST_CASE("the axis judge agrees with itself at coarser bisection") {
  CHECK(axis_judge_own_error() < 1e-11);
}

// Measured worst over all rows: 4.8e-14 in double, 9.3e-6 in float; times three for other compilers' rounding.
TEST_CASE("the closed form of the axis equals the event-by-event judge to rounding at every stiffness and frame rate") {
  CHECK(worst("axis", "closed form f64") < 1.5e-13);
  CHECK(worst("axis", "closed form f32") < 2.8e-5);
}

TEST_CASE("rivals come nearer with more substeps, and with 64 none is as near as the closed form in float") {
  const auto error = [](const TimeRow& like, const std::string& method, double knob) {
    for (const TimeRow& row : rows()) {
      if (row.method == method && row.stiffness == like.stiffness && row.fps == like.fps && row.knob == knob) {
        return row.error_max;
      }
    }
    return -1.0;
  };
  for (const char* method : {"explicit Euler", "semi-implicit Euler", "RK4"}) {
    for (const TimeRow& coarse : rows()) {
      if (coarse.method != method || coarse.knob != 1) continue;
      CAPTURE(coarse.method);
      CAPTURE(coarse.stiffness);
      CAPTURE(coarse.fps);
      CHECK(error(coarse, method, 64) < coarse.error_max);
      CHECK(error(coarse, method, 64) > error(coarse, "closed form f32", 1));
    }
  }
}

TEST_CASE("smoothing is no model of a motor: off by more than a tenth of the range in every row") {
  for (const TimeRow& row : rows()) {
    if (row.method == "exponential smoothing") CHECK(row.error_max > 0.1);
  }
}

// The phase keeps 24 bits when it becomes a fraction, and a short exposure divides by the turns that it lasts.
TEST_CASE("the exposure integral is right within 2^-24 turn over the turns of the exposure") {
  for (const TimeRow& row : rows()) {
    if (row.model != "strobe" || row.method.find("exposure integral") != 0) continue;
    CAPTURE(row.method);
    CAPTURE(row.stiffness);
    CAPTURE(row.fps);
    const double turns = row.stiffness / row.fps;
    CHECK(row.error_max < 8 * 0x1p-24 * std::max(1.0, 1 / turns));
    CHECK_FALSE(row.failed);
  }
}

TEST_CASE("point sampling of a strobe is wrong by a large part of full light") {
  double error = 0;
  for (const TimeRow& row : rows()) {
    if (row.method == "point samples" && row.knob == 1) error = std::max(error, row.error_max);
  }
  CHECK(error > 0.3);
}

TEST_CASE("every row of both models is finite and the sweep is complete") {
  const TimeReportOptions options;
  const std::size_t axis = options.stiffness_per_s.size() * options.fps.size() * (3 + 3 * options.substeps.size() + 4);
  const std::size_t strobe = options.strobe_hz.size() * options.fps.size() * (2 + options.substeps.size() + 1);
  CHECK(rows().size() == axis + strobe);
  for (const TimeRow& row : rows()) {
    CHECK(std::isfinite(row.error_max));
    CHECK(row.ns_per_step == 0);
  }
}

TEST_CASE("without timing the rows are the same on every run, and another seed gives another show") {
  TimeReportOptions options;
  options.measure_time = false;
  options.stiffness_per_s = {20};
  options.fps = {60};
  options.seconds = 5;
  const std::string once = json_lines_of(time_rows(options));
  CHECK(once == json_lines_of(time_rows(options)));
  options.seed = 2;
  CHECK(once != json_lines_of(time_rows(options)));
}

TEST_CASE("timing gives every method a time") {
  TimeReportOptions options;
  options.stiffness_per_s = {20};
  options.fps = {60};
  options.strobe_hz = {10};
  options.seconds = 2;
  for (const TimeRow& row : time_rows(options)) CHECK(row.ns_per_step > 0);
}
