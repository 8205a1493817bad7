// footlight trace: values of heads over time, compared with closed forms and the walker.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "fixtures/simulate/walker.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/trace/head_trace.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<nlohmann::json> json_lines(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

// Rows of CSV without quoted cells, by the names of the first line.
std::vector<std::map<std::string, std::string>> csv_rows(const std::string& text) {
  std::vector<std::map<std::string, std::string>> rows;
  std::vector<std::string> names;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    if (names.empty()) {
      names = cells;
      continue;
    }
    REQUIRE(cells.size() == names.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[names[i]] = cells[i];
    }
  }
  return rows;
}

// A moving head over the middle of the stage and a par beside it.
constexpr const char* kRig = R"([rig]
name = "A head"
[[fixture]]
name = "Spot"
type = "generic/profile"
mode = "16 bit"
universe = 1
address = 1
position = [0, 0, 5]
[[fixture]]
name = "Par"
type = "generic/par"
universe = 1
address = 101
position = [1, 0, 5]
)";

// The levels of the head's 14 slots as the text of an OLA Show: pan (16 bit), shutter.
std::string levels_of(int pan, int shutter) {
  return fmt::format("1 {},{},128,0,255,255,{},255,255,255,101,144,0,128\n", pan / 256, pan % 256, shutter);
}

TEST_CASE("a traced pan accelerates, coasts and brakes by the closed form of its limits") {
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kRig;
  // At 1 s from 0 to 270 degrees, at 240 degrees/s and 700 degrees/s^2.
  std::ofstream(folder.file("move.show")) << "OLA Show\n"
                                          << levels_of(32768, 255) << "1000\n"
                                          << levels_of(65535, 255) << "2000\n"
                                          << levels_of(65535, 255);
  const Outcome outcome = footlight({"trace", folder.file("rig.toml"), "--log", folder.file("move.show"), "--every",
                                     "10ms", "--fixture", "Spot", "--csv"});
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const auto rows = csv_rows(outcome.out);
  REQUIRE(rows.size() == 301);
  constexpr double kSpeed = 240;
  constexpr double kAcceleration = 700;
  const double from = 32768.0 / 65535 * 540 - 270;
  const double way = 270 - from;
  const double ramp_s = kSpeed / kAcceleration;
  const double whole_s = way / kSpeed + ramp_s;
  for (const auto& row : rows) {
    const double t = std::stod(row.at("time_s"));
    const double since = std::clamp(t - 1, 0.0, whole_s);
    const double left = whole_s - since;
    const double at = since < ramp_s  ? from + kAcceleration * since * since / 2
                      : left < ramp_s ? 270 - kAcceleration * left * left / 2
                                      : from + kSpeed * (since - ramp_s / 2);
    CAPTURE(t);
    CHECK(std::stod(row.at("pan_deg")) == doctest::Approx(at).epsilon(1e-6).scale(270));
  }
  CHECK(rows[0].at("time_s") == "0");
  CHECK(rows[1].at("time_s") == "0.01");
  // At half of its time it has covered half of its distance.
  const Outcome middle = footlight({"trace", folder.file("rig.toml"), "--log", folder.file("move.show"), "--at",
                                    fmt::format("{}us", std::lround(1e6 * (1 + whole_s / 2))), "--json"});
  REQUIRE(middle.exit_code == 0);
  CHECK(json_lines(middle.out)[0]["pan_deg"].get<double>() == doctest::Approx(from + way / 2).epsilon(1e-5));
}

TEST_CASE("a traced strobe is open for its duty over whole periods, and light is dimmer, shutter and colour") {
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kRig;
  std::ofstream(folder.file("strobe.show")) << "OLA Show\n"
                                            << levels_of(32768, 223) << "1000\n"
                                            << levels_of(32768, 223);
  const std::vector<std::string> words = {
      "trace", folder.file("rig.toml"), "--log", folder.file("strobe.show"), "--fixture", "Spot", "--json"};
  const auto traced = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    const Outcome outcome = footlight(more);
    CAPTURE(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return json_lines(outcome.out);
  };
  // 25 Hz: 40 ms are one period, and the shutter is open for 0.4 of it.
  const auto periods = traced({"--every", "40ms", "--from", "40ms"});
  REQUIRE(periods.size() == 25);
  for (const auto& row : periods) {
    CHECK(row["strobe_hz"] == 25);
    CHECK(row["shutter"].get<double>() == doctest::Approx(0.4).epsilon(1e-5));
    CHECK(row["light"].get<double>() == doctest::Approx(0.4).epsilon(1e-4));
    CHECK(row["light_lm"].get<double>() == doctest::Approx(0.4 * 16000).epsilon(1e-4));
  }
  // In steps of a millisecond it is open or closed; the mean over the same 40 ms is equal.
  const auto short_ones = traced({"--every", "1ms", "--from", "40ms", "--until", "79ms"});
  REQUIRE(short_ones.size() == 40);
  double sum = 0;
  for (const auto& row : short_ones) sum += row["shutter"].get<double>() / 40;
  CHECK(sum == doctest::Approx(0.4).epsilon(1e-4));
}

TEST_CASE("a trace of the demo equals the walker's states at the same times, to the bit") {
  const Outcome outcome =
      footlight({"trace", "--demo", "--every", "250ms", "--from", "8s", "--until", "20s", "--json"});
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const auto rows = json_lines(outcome.out);

  fixtures::Rig rig = fixtures::demo_rig();
  const auto bytes = demo::demo_log_bytes();
  auto log = LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show");
  REQUIRE(log);
  auto driven = tools::compile_driven(rig, std::move(*log));
  REQUIRE(driven);
  fixtures::f32::Walker walker(driven->compiled);
  const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    walker.step(levels, dt_ns, new_exposure);
  };
  std::size_t at = 0;
  std::size_t moving = 0;
  for (DurationNs time_ns = 8 * kNsPerS; time_ns <= 20 * kNsPerS; time_ns += 250 * kNsPerMs) {
    REQUIRE(driven->timeline->advance(time_ns, 250 * kNsPerMs, step));
    for (std::size_t head = 0; head < walker.states.size(); ++head, ++at) {
      REQUIRE(at < rows.size());
      const auto& state = walker.states[head];
      const nlohmann::json& row = rows[at];
      CAPTURE(row.dump());
      CHECK(row["time_s"].get<double>() == doctest::Approx(static_cast<double>(time_ns) * 1e-9).epsilon(1e-15));
      CHECK(row["fixture"] == rig.fixtures[driven->compiled.heads[head].fixture].name);
      CHECK(row["red"].get<float>() == state.red);
      CHECK(row["green"].get<float>() == state.green);
      CHECK(row["blue"].get<float>() == state.blue);
      const auto degrees = [](double rad) { return static_cast<float>(rad * 180 / std::numbers::pi); };
      CHECK(row["zoom_deg"].get<float>() == degrees(2.0 * static_cast<double>(state.zoom)));
      if (!row["pan_deg"].is_null()) {
        CHECK(row["pan_deg"].get<float>() == degrees(static_cast<double>(state.pan)));
        moving += state.pan != 0;
      }
      // The mean of a product against the product of means: equal if the light is constant, or nearly so.
      CHECK(row["shutter"].get<double>() >= 0);
      CHECK(row["shutter"].get<double>() <= 1);
    }
  }
  CHECK(at == rows.size());
  CHECK(moving > 100);
}

TEST_CASE("parts that a head lacks are empty cells, and a beam points where its pan and tilt turn it") {
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kRig;
  const Outcome outcome = footlight({"trace", folder.file("rig.toml"), "--set", "Tilt=90", "--set", "Spot:Pan=90",
                                     "--set", "Spot:Gobo1=3", "--at", "0s"});
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const auto rows = csv_rows(outcome.out);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].at("fixture") == "Spot");
  CHECK(std::stod(rows[0].at("pan_deg")) == doctest::Approx(90).epsilon(1e-4));
  CHECK(std::stod(rows[0].at("tilt_deg")) == doctest::Approx(90).epsilon(1e-4));
  CHECK(rows[0].at("gobo1") == "3");
  CHECK(rows[0].at("gobo2").empty());
  // Straight down, turned by 90 degrees about X and then about Z, the beam points along -X.
  CHECK(std::abs(std::stod(rows[0].at("beam_x"))) == doctest::Approx(1).epsilon(1e-4));
  CHECK(std::stod(rows[0].at("beam_z")) == doctest::Approx(0).epsilon(1e-4));
  for (const char* name : {"pan_deg", "tilt_deg", "gobo1", "iris"}) CHECK(rows[1].at(name).empty());
  CHECK(std::stod(rows[1].at("beam_z")) == doctest::Approx(-1));
}

TEST_CASE("a trace in a file equals that on standard output, and a name with a comma is quoted") {
  const TempFolder folder;
  std::string rig = kRig;
  rig.replace(rig.find("\"Spot\""), 6, "\"Spot, \\\"big\\\"\"");
  std::ofstream(folder.file("rig.toml")) << rig;
  const std::vector<std::string> words = {"trace", folder.file("rig.toml"), "--lit", "--every", "1s", "--until", "2s"};
  const Outcome printed = footlight(words);
  REQUIRE(printed.exit_code == 0);
  CHECK(contains(printed.out, "\n0,\"Spot, \"\"big\"\"\",1,"));
  auto with_file = words;
  with_file.insert(with_file.end(), {"-o", folder.file("heads.csv")});
  const Outcome written = footlight(with_file);
  REQUIRE(written.exit_code == 0);
  CHECK(contains(written.out, "heads.csv: 2 heads at 3 moments"));
  CHECK(read(folder.file("heads.csv")) == printed.out);
  CHECK(!std::filesystem::exists(folder.file("heads.csv.part")));
}

TEST_CASE("invalid arguments of trace are reported, and no file is left") {
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kRig;
  const std::string rig = folder.file("rig.toml");
  struct Wrong {
    std::vector<std::string> words;
    int exit_code;
    const char* named;
  };
  const std::string out = folder.file("x.csv");
  for (const Wrong& wrong : std::vector<Wrong>{
           {{}, 2, "--at TIME"},
           {{"--at", "1s"}, 2, "--log FILE"},
           {{"--at", "1s", "--every", "1s", "--lit"}, 2, "--at TIME"},
           {{"--every", "1s", "--lit"}, 2, "--until"},
           {{"--every", "1s", "--from", "2s", "--until", "1s", "--lit"}, 2, "--until 1.00 s"},
           {{"--at", "1s", "--until", "1s", "--lit"}, 2, "--every"},
           {{"--at", "1s", "--lit", "--csv", "--json"}, 2, "--json"},
           {{"--at", "1s", "--lit", "--fixture", "Spott"}, 3, "Spott"},
           {{"--at", "1s", "--lit", "--head", "7"}, 3, "--head 7"},
           {{"--at", "1s", "--set", "Pann=3"}, 3, "Pann"},
           {{"--at", "1s", "--set", "Pan=300"}, 2, "--set Pan=300: expected -270 to 270 for Pan, got 300"},
           {{"--at", "1s", "--set", "Gobo1=99"}, 2, "--set Gobo1=99: expected 1 to "},
           {{"--at", "1s", "--set", "Pan"}, 2, "--set Pan: expected ATTRIBUTE=NUMBER or FIXTURE:ATTRIBUTE=NUMBER, for"},
           {{"--at", "1s", "--set", "Pan="}, 2, "--set Pan=: expected a number behind =, got nothing, for example"},
           {{"--at", "1s", "--set", "Pan=nan"}, 2, "--set Pan=nan: expected a finite number behind =, got nan, for"},
           {{"--at", "1s", "--set", "Pan=-inf"}, 2, "expected a finite number behind =, got -inf"},
           {{"--at", "1s", "--set", "Pan=3x"}, 2, "expected a finite number behind =, got 3x"},
           {{"--at", "1s", "--set", "=1"}, 2, "--set =1: expected the name of an attribute before =, got nothing"},
           {{"--at", "1s", "--set", "Spot:=1"}, 2, "expected the name of an attribute before =, got nothing"},
           {{"--at", "1s", "--set", ":Pan=1"}, 2, "expected the name of a fixture before the colon, got nothing"},
           {{"--at", "soon", "--lit"}, 2, "soon"},
           {{"--at", "0s", "--log", folder.file("none.dmxlog")}, 3, "none.dmxlog"},
       }) {
    std::vector<std::string> words = {"trace", rig, "-o", out};
    words.insert(words.end(), wrong.words.begin(), wrong.words.end());
    const Outcome outcome = footlight(words);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == wrong.exit_code);
    CHECK(contains(outcome.err, wrong.named));
    CHECK(!std::filesystem::exists(out));
    CHECK(!std::filesystem::exists(out + ".part"));
  }
  const Outcome nowhere = footlight({"trace", rig, "--lit", "--at", "0s", "-o", folder.file("no/x.csv")});
  CHECK(nowhere.exit_code == 1);
  CHECK(contains(nowhere.err, "no/x.csv: cannot be written"));
  CHECK(contains(footlight({"trace", "--at", "1s", "--demo", rig}).err, "not both"));
}

TEST_CASE("one warning says what of a damaged log is left out, and none that of a whole one") {
  const TempFolder folder;
  const std::string rig = folder.file("rig.toml");
  const std::string log = folder.file("show.dmxlog");
  std::ofstream(rig) << kRig;
  const auto bytes = demo::demo_log_bytes();
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::ofstream(log, std::ios::binary) << text;
  const Outcome whole = footlight({"trace", rig, "--log", log, "--every", "20s"});
  REQUIRE(whole.exit_code == 0);
  CHECK(whole.err.empty());
  const std::size_t middle = text.size() / 2;
  for (std::size_t i = 0; i < 16; ++i) text[middle + i] = static_cast<char>(~text[middle + i]);
  std::ofstream(log, std::ios::binary) << text;
  const Outcome damaged = footlight({"trace", rig, "--log", log, "--every", "20s"});
  CAPTURE(damaged.err);
  CHECK(damaged.exit_code == 0);
  CHECK(contains(damaged.err, log + ": damaged at byte "));
  CHECK(contains(damaged.err, ": 1 part of "));
  CHECK(contains(damaged.err, "'footlight log info"));
  CHECK(std::count(damaged.err.begin(), damaged.err.end(), '\n') == 1);
}

}  // namespace
}  // namespace footlight::testing
