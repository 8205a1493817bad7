// footlight report --time, as a user runs it.
#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_CASE("the report of time prints a row of JSON for every method, and writes the same rows and a plot a model") {
  const TempFolder folder;
  const Outcome outcome = footlight(
      {"report", "--time", "--quick", "--json", "--csv", folder.file("r.csv"), "--svg", folder.file("r.svg")});
  REQUIRE(outcome.exit_code == 0);
  std::set<std::string> models;
  std::set<std::string> outcomes;
  std::size_t rows = 0;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line); ++rows) {
    const auto row = nlohmann::json::parse(line, nullptr, false);
    REQUIRE(row.is_object());
    models.insert(row["model"]);
    outcomes.insert(row["outcome"]);
    CHECK(row["ns_p50"] > 0);
  }
  CHECK(models == std::set<std::string>{"filament", "motion", "strobe", "spin", "smoothing", "belt", "led", "mains",
                                        "dimmer", "pulse", "random-pulse", "discharge", "jerk"});
  CHECK(outcomes.contains("diverged"));
  CHECK(outcomes.contains("ok"));
  const std::string csv = text_of(folder.file("r-time.csv"));
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) == rows + 1);
  for (const std::string& model : models) {
    CAPTURE(model);
    CHECK(text_of(folder.file("r-time-" + model + ".svg")).find("</svg>") != std::string::npos);
  }
}

TEST_CASE("the worst disagreements of float and double are printed with the input that causes them") {
  const Outcome outcome = footlight({"report", "--time", "--worst", "--quick"});
  CHECK(outcome.exit_code == 0);
  for (const char* word : {"motor", "filament", "shutter", "dt_s=", "rate_hz=", "double"}) {
    CAPTURE(word);
    CHECK(outcome.out.find(word) != std::string::npos);
  }
}

TEST_CASE("a folder that is not there ends the report with its name before a row is measured") {
  const Outcome outcome = footlight({"report", "--time", "--quick", "--json", "--csv", "/no/such/folder/r.csv"});
  CHECK(outcome.exit_code == 1);
  CHECK(outcome.out.empty());
  CHECK(outcome.err.find("/no/such/folder/r.csv: cannot be written") != std::string::npos);
}

}  // namespace
}  // namespace footlight::testing
