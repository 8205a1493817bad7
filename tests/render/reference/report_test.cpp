#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "render/reference/report.h"

namespace {

using namespace footlight;
using namespace footlight::render;

std::vector<PictureRow> picture_rows() {
  PictureRow row;
  row.scene = "demo, \"quoted\"";
  row.method = "gauss";
  row.knob = 3;
  row.hits_per_px = 2.5;
  row.ms_p10 = 0.9;
  row.ms_p50 = 1;
  row.ms_p90 = 1.1;
  row.rel_l2 = 1e-3;
  row.rel_l2_low = 9e-4;
  row.rel_l2_high = 1.1e-3;
  row.rel_mse = 2e-6;
  row.p999 = 0.01;
  row.max = 0.2;
  row.flip = 0.001;
  row.nonfinite = 0;
  row.bytes = 123456789012;
  PictureRow other = row;
  other.method = "march";
  other.knob = 64;
  other.ms_p50 = 12;
  other.rel_l2 = std::numeric_limits<double>::quiet_NaN();
  return {row, other};
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Curve power_law(double order) {
  Curve curve{"power", {}};
  for (const double cost : {8.0, 1.0, 2.0, 4.0}) curve.points.push_back({cost, 0.1 * std::pow(cost, -order), ""});
  return curve;
}

}  // namespace

TEST_CASE("rows printed one by one align with the names of their columns") {
  const auto rows = picture_rows();
  const std::string names = table_names_of(rows[0]);
  const auto place_of = [](const std::string& text, std::string_view word) { return text.find(word) + word.size(); };
  for (const PictureRow& row : rows) {
    const std::string line = table_line_of(row);
    CHECK(line.size() == names.size());
    CHECK(line.ends_with("\n"));
    CHECK(place_of(line, row.method) <= names.find("knob"));
    CHECK(place_of(line, "  2.5") == place_of(names, "hits_per_px"));
    CHECK(place_of(line, "123456789012") == place_of(names, "bytes"));
  }
}

TEST_CASE("a table's columns align with their names") {
  const std::vector<std::string> lines = lines_of(table_of(picture_rows()));
  REQUIRE(lines.size() == 3);
  for (const char* name : {"knob", "rel_l2", "bytes"}) {  // numbers are right-aligned with their names
    const std::size_t end = lines[0].find(name) + std::string(name).size();
    CAPTURE(name);
    CHECK(lines[1][end - 1] != ' ');
    if (end < lines[1].size()) CHECK(lines[1][end] == ' ');
  }
  CHECK(lines[1].find("gauss") == lines[0].find("method"));
  CHECK(lines[2].find("  -  ") != std::string::npos);
}

TEST_CASE("a row states how it ended, and whether its times are stable") {
  TimeRow row;
  row.model = "motion";
  row.outcome = TimeOutcome::kDiverged;
  CHECK(table_of(std::vector<TimeRow>{row}).find("diverged") != std::string::npos);
  row.outcome = TimeOutcome::kNonFinite;
  CHECK(table_of(std::vector<TimeRow>{row}).find("non-finite") != std::string::npos);
  row.outcome = TimeOutcome::kOk;
  CHECK(table_of(std::vector<TimeRow>{row}).find("diverged") == std::string::npos);
  CHECK_FALSE(is_unstable(row));
  row.ns_p10 = 100;
  row.ns_p50 = 105;
  row.ns_p90 = 114;
  CHECK_FALSE(is_unstable(row));
  CHECK(table_of(std::vector<TimeRow>{row}).find("unstable") == std::string::npos);
  row.ns_p90 = 116;
  CHECK(is_unstable(row));
  CHECK(csv_of(std::vector<TimeRow>{row}).find("unstable") != std::string::npos);
}

TEST_CASE("JSON lines have exactly the names of the row, and are read back unchanged") {
  const std::string text = json_lines_of(picture_rows());
  const std::vector<std::string> lines = lines_of(text);
  REQUIRE(lines.size() == 2);
  const auto object = nlohmann::json::parse(lines[0]);
  std::vector<std::string> names;
  for (const auto& item : object.items()) names.push_back(item.key());
  std::sort(names.begin(), names.end());
  CHECK(names == std::vector<std::string>{"bytes", "flip", "hits_per_px", "knob", "max", "method", "ms_p10", "ms_p50",
                                          "ms_p90", "nonfinite", "own_ms", "p999", "rel_l2", "rel_l2_high",
                                          "rel_l2_low", "rel_mse", "scene"});
  CHECK(nlohmann::json::parse(lines[1])["rel_l2"].is_null());

  const auto rows = picture_rows_from_json_lines(text, "report.jsonl");
  REQUIRE(rows.has_value());
  REQUIRE(rows->size() == 2);
  CHECK((*rows)[0].scene == "demo, \"quoted\"");
  CHECK((*rows)[0].bytes == 123456789012);
  CHECK((*rows)[0].rel_l2_low == 9e-4);
  CHECK((*rows)[0].rel_l2_high == 1.1e-3);
  CHECK((*rows)[0].rel_mse == 2e-6);
  CHECK(std::isnan((*rows)[1].rel_l2));

  const auto time = nlohmann::json::parse(json_lines_of(std::vector<TimeRow>{TimeRow{}}));
  CHECK(time.size() == 14);
  CHECK(time["outcome"] == "ok");
  CHECK(time["clock"] == "-");
  CHECK(time.contains("ns_p50"));
}

TEST_CASE("an invalid line of JSON is reported with its number and the missing value") {
  const auto broken = picture_rows_from_json_lines("\n{\"scene\": ", "old.jsonl");
  REQUIRE_FALSE(broken.has_value());
  CHECK(broken.error().message.find("old.jsonl:2: expected one JSON object") != std::string::npos);
  std::string text = json_lines_of(picture_rows());
  text.replace(text.find("\"knob\""), 6, "\"knot\"");
  const auto missing = picture_rows_from_json_lines(text, "old.jsonl");
  REQUIRE_FALSE(missing.has_value());
  CHECK(missing.error().message.find("old.jsonl:1: expected a number \"knob\"") != std::string::npos);
  for (const char* bad : {"[1,2]", "3", "\"x\"", "null", "{}", "{\"scene\":1}", "\xff\xfe"}) {
    CHECK_FALSE(picture_rows_from_json_lines(bad, "x").has_value());
  }
  CHECK(picture_rows_from_json_lines("", "x")->empty());
}

TEST_CASE("CSV quotes texts with separators and keeps every digit") {
  std::vector<PictureRow> rows = picture_rows();
  rows[0].rel_l2 = 0.1234567890123456;
  const std::string text = csv_of(rows);
  CHECK(text.substr(0, 13) == "scene,method,");
  CHECK(text.find("\r\n\"demo, \"\"quoted\"\"\",gauss,3,") != std::string::npos);
  CHECK(text.find("0.1234567890123456") != std::string::npos);
  CHECK(std::count(text.begin(), text.end(), '\n') == 3);
}

TEST_CASE("CSV has an empty cell where nothing was measured") {
  std::vector<PictureRow> rows = picture_rows();
  rows[0].flip = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::string> lines = lines_of(csv_of(rows));
  REQUIRE(lines.size() == 3);
  CHECK(lines[1].find(",0.2,,0,123456789012") != std::string::npos);  // max, flip, nonfinite, bytes
  CHECK(lines[2].find(",12,1.1,0,,0.0009,") != std::string::npos);    // ms_p50 to rel_l2_low
  CHECK(lines[1].find("nan") == std::string::npos);
  CHECK(lines[2].find("nan") == std::string::npos);
}

TEST_CASE("cost at an error is interpolated in logarithms, in order of cost") {
  const Curve curve = power_law(2);
  CHECK(*cost_at_error(curve, 1e-2) == doctest::Approx(std::sqrt(10)));
  CHECK(*cost_at_error(curve, 0.5) == 1);  // the cheapest point is good enough
  CHECK_FALSE(cost_at_error(curve, 1e-4));
  CHECK_FALSE(cost_at_error(Curve{}, 1));
}

TEST_CASE("error at a cost is interpolated in logarithms and never worse than a cheaper point") {
  Curve curve = power_law(2);
  CHECK(*error_at_cost(curve, 2.5) == doctest::Approx(0.1 / 6.25));
  CHECK(*error_at_cost(curve, 1000) == doctest::Approx(0.1 / 64));
  CHECK_FALSE(error_at_cost(curve, 0.9));
  curve.points.push_back({16, 1, ""});  // a larger error
  CHECK(*error_at_cost(curve, 20) == doctest::Approx(0.1 / 64));
}

TEST_CASE("the order of a power law is its exponent, and one point has no order") {
  CHECK(*order_of(power_law(2)) == doctest::Approx(2));
  CHECK(*order_of(power_law(0)) == doctest::Approx(0));
  CHECK_FALSE(order_of(Curve{"one", {{1, 1, ""}}}));
  CHECK_FALSE(order_of(Curve{"same cost", {{1, 1, ""}, {1, 2, ""}}}));
  CHECK_FALSE(order_of(Curve{"nearly the same", {{1, 1e-3, ""}, {1.01, 1e-6, ""}}}));
}

TEST_CASE("points without a logarithm are left out") {
  Curve curve = power_law(1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    curve.points.push_back({bad, 1e-9, "bad"});
    curve.points.push_back({1, bad, "bad"});
  }
  CHECK(*order_of(curve) == doctest::Approx(1));
  const std::string svg = svg_plot({"t", "s", "x", "y"}, std::vector<Curve>{curve});
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg.find("inf") == std::string::npos);
  CHECK(svg.find("bad") == std::string::npos);
}

TEST_CASE("a summary prints not reached for curves that do not reach an error") {
  const std::vector<double> costs{1, 4, 16};
  const std::string text = summary_of(std::vector<Curve>{power_law(2)}, "ms", costs);
  const std::vector<std::string> lines = lines_of(text);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].find("ms at 1e-02") != std::string::npos);
  CHECK(lines[0].find("error at 16 ms") != std::string::npos);
  CHECK(lines[1].find("not reached") != std::string::npos);
  CHECK(lines[1].find("2.0") != std::string::npos);
  CHECK(lines[0].size() == lines[1].size());
}

TEST_CASE("rows become one curve per method without failed points, and an exact method has a point") {
  std::vector<TimeRow> rows(4);
  rows[0].method = "a";
  rows[0].ns_p50 = 5;
  rows[0].rel_l2 = 0;
  rows[1].method = "b";
  rows[1].ns_p50 = 6;
  rows[1].rel_l2 = 1e-3;
  rows[2] = rows[1];
  rows[2].outcome = TimeOutcome::kDiverged;
  rows[3] = rows[1];
  rows[3].knob = 4;
  const std::vector<Curve> curves = curves_of(rows);
  REQUIRE(curves.size() == 2);
  REQUIRE(curves[0].points.size() == 1);
  CHECK(curves[0].points[0].error == kLeastError);
  CHECK(curves[1].points.size() == 2);
  CHECK(curves[1].points[1].label == "4");
}

TEST_CASE("a plot escapes its texts, and a plot without points is valid") {
  const std::string svg = svg_plot({"a < b & c", "", "x", "y"}, std::vector<Curve>{power_law(2)});
  CHECK(svg.find("a &lt; b &amp; c") != std::string::npos);
  CHECK(svg.substr(0, 4) == "<svg");
  CHECK(svg.find("</svg>") != std::string::npos);
  const std::string empty = svg_plot({"t", "", "x", "y"}, std::vector<Curve>{});
  CHECK(empty.find("nothing was measured") != std::string::npos);
}
