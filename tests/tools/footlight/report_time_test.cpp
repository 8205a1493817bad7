// footlight report --time, as users run it.
#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_CASE("the report of time prints a JSON row for every method, and writes the same rows and a plot per model") {
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

TEST_CASE("rows of a report are printed as they are measured, Ctrl-C keeps them, in complete files, with exit code 0") {
  const TempFolder folder;
  Footlight report(
      {"report", "--time", "--quick", "--json", "--csv", folder.file("r.csv"), "--svg", folder.file("r.svg")});
  report.wait_for(R"("model":"motion")");  // all rows of filament are printed
  report.signal(SIGINT);
  const Outcome outcome = report.wait();
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 0);
  CHECK(outcome.err.find("ended by a signal") != std::string::npos);
  std::size_t rows = 0;
  std::set<std::string> models;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line); ++rows) {
    const auto row = nlohmann::json::parse(line, nullptr, false);
    REQUIRE(row.is_object());
    models.insert(row["model"]);
  }
  CHECK(models.contains("filament"));
  CHECK_FALSE(models.contains("jerk"));
  const std::string csv = text_of(folder.file("r-time.csv"));
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) == rows + 1);
  CHECK(csv.ends_with("\n"));
  CHECK(text_of(folder.file("r-time-filament.svg")).find("</svg>") != std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(folder.file(""))) {
    CHECK(entry.path().extension() != ".part");
  }
}

TEST_CASE("on a terminal a report shows its progress and the remaining time") {
  int terminal = -1, other = -1;
  REQUIRE(openpty(&terminal, &other, nullptr, nullptr, nullptr) == 0);
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) {
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(other, STDERR_FILENO);
    close(terminal);
    close(other);
    execl(FOOTLIGHT_BINARY, FOOTLIGHT_BINARY, "report", "--time", "--quick", nullptr);
    _exit(127);
  }
  close(other);
  std::string shown;
  char buffer[1024];
  for (ssize_t count = 0; shown.find(" left") == std::string::npos; shown.append(buffer, std::size_t(count))) {
    pollfd ready{terminal, POLLIN, 0};
    REQUIRE(poll(&ready, 1, 60'000) == 1);
    count = read(terminal, buffer, sizeof buffer);
    REQUIRE_MESSAGE(count > 0, shown);
  }
  CHECK(shown.find("footlight: models of time behaviour: 0 of 12") != std::string::npos);
  CHECK(shown.find(" of 12, about ") != std::string::npos);
  CHECK(kill(pid, SIGTERM) == 0);
  int status = 0;
  REQUIRE(waitpid(pid, &status, 0) == pid);
  close(terminal);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

TEST_CASE("the largest differences of float and double are printed with the input that causes them") {
  const Outcome outcome = footlight({"report", "--time", "--worst", "--quick"});
  CHECK(outcome.exit_code == 0);
  for (const char* word : {"motor", "filament", "shutter", "dt_s=", "rate_hz=", "double"}) {
    CAPTURE(word);
    CHECK(outcome.out.find(word) != std::string::npos);
  }
}

TEST_CASE("a missing folder ends the report with its name before a row is measured") {
  const Outcome outcome = footlight({"report", "--time", "--quick", "--json", "--csv", "/no/such/folder/r.csv"});
  CHECK(outcome.exit_code == 1);
  CHECK(outcome.out.empty());
  CHECK(outcome.err.find("/no/such/folder/r.csv: cannot be written") != std::string::npos);
}

}  // namespace
}  // namespace footlight::testing
