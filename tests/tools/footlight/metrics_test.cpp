// The page is parsed by an independent parser of the exposition format, and by promtool if it is installed.
#include "tools/footlight/status/metrics.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include <doctest/doctest.h>

#include "sim/core/histogram.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/status/http_server.h"

namespace footlight::tools {
namespace {

struct Sample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0.0;
};

struct Page {
  std::map<std::string, std::string> types;  // of families
  std::vector<Sample> samples;

  [[nodiscard]] std::optional<double> find(const std::string& name,
                                           const std::map<std::string, std::string>& labels) const {
    for (const Sample& sample : samples)
      if (sample.name == name && sample.labels == labels) return sample.value;
    return std::nullopt;
  }
};

// The labels between the braces; fails the test if their syntax is wrong.
std::map<std::string, std::string> parse_labels(const std::string& text) {
  std::map<std::string, std::string> labels;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t equals = text.find("=\"", at);
    REQUIRE(equals != std::string::npos);
    const std::string name = text.substr(at, equals - at);
    CHECK(std::regex_match(name, std::regex("[a-zA-Z_][a-zA-Z0-9_]*")));
    std::string value;
    at = equals + 2;
    for (; at < text.size() && text[at] != '"'; ++at) {
      if (text[at] == '\\') ++at;
      REQUIRE(at < text.size());
      value += text[at];
    }
    REQUIRE(at < text.size());
    CHECK(labels.emplace(name, value).second);
    ++at;
    if (at < text.size()) REQUIRE(text[at++] == ',');
  }
  return labels;
}

Page parse(const std::string& text) {
  Page page;
  std::set<std::string> series;
  std::string family;
  std::istringstream lines(text);
  REQUIRE(text.back() == '\n');
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    std::smatch match;
    if (std::regex_match(line, match, std::regex(R"(# HELP ([a-z_]+) .+)"))) {
      family = match[1];
      CHECK_FALSE(page.types.contains(family));  // the lines of a family are together
      page.types[family] = "";
    } else if (std::regex_match(line, match, std::regex(R"(# TYPE ([a-z_]+) (counter|gauge|histogram))"))) {
      CHECK(match[1] == family);
      page.types[family] = match[2];
      CHECK((match[2] == "counter") == (family.size() > 6 && family.substr(family.size() - 6) == "_total"));
    } else {
      const std::size_t name_end = line.find_first_of("{ ");
      REQUIRE(name_end != std::string::npos);
      const std::size_t labels_end = line[name_end] == '{' ? line.rfind('}') : name_end - 1;
      REQUIRE(labels_end != std::string::npos);
      Sample sample;
      sample.name = line.substr(0, name_end);
      if (line[name_end] == '{') sample.labels = parse_labels(line.substr(name_end + 1, labels_end - name_end - 1));
      char* end = nullptr;
      sample.value = std::strtod(line.c_str() + labels_end + 1, &end);
      CHECK(*end == '\0');
      CHECK(series.insert(line.substr(0, labels_end + 1)).second);  // no series twice
      const bool histogram = page.types[family] == "histogram";
      CHECK(std::regex_match(sample.name, std::regex(family + (histogram ? "_(bucket|sum|count)" : ""))));
      page.samples.push_back(std::move(sample));
    }
  }
  return page;
}

PumpStatus full_status() {
  PumpStatus status;
  status.stamp_ns = 10 * kNsPerS;
  status.ticks = 77;
  PortStatus in;
  in.name = "sacn:1-2";
  in.state = PortState::kWorking;
  in.universes = {{.universe = 1, .frames = 10}, {.universe = 2, .frames = 20}};
  in.port.rejected = 3;
  in.unrouted = 4;
  PortStatus out;
  out.is_sink = true;
  out.name = "log:a \"b\"\\c\n\xFF.dmxlog";
  out.state = PortState::kGone;
  out.figures = {{.name = "break_us_p50", .value = 176.5}, {.name = "rate_hz", .value = 33.0}};
  out.universes = {{.universe = 1, .frames = 9}, {.universe = 1, .frames = 1}};
  Histogram histogram;
  for (const DurationNs latency_ns : {10'000, 20'000, 20'000'000, 2'000'000'000}) histogram.record(latency_ns);
  out.latency.count = histogram.count();
  out.latency.sum_ns = histogram.sum_ns();
  for (int k = 0; k < kTimingPowerCount; ++k)
    out.latency.below[static_cast<std::size_t>(k)] = histogram.count_below_power(kTimingPowerFirst + k);
  status.ports = {in, in, out};
  UniverseStatus universe;
  universe.universe = 1;
  universe.newest.revision = 1;
  universe.newest.stamp_ns = 8 * kNsPerS;
  universe.merge.senders_silent = 5;
  universe.senders = {{.name = "FOH \"1\"", .id = 7, .losses = {.lost = 12, .late = 2}},
                      {.name = "FOH \"1\"", .id = 8, .losses = {.lost = 0, .late = 1}}};
  UniverseStatus silent;
  silent.universe = 2;
  status.universes = {universe, silent};
  return status;
}

TEST_CASE("a metrics page has every series once, with its type and the pump's values") {
  const Page page = parse(metrics_text(full_status(), {.start_unix_ns = 5 * kNsPerS, .reloads = 2}));
  const std::map<std::string, std::string> in = {{"port", "sacn:1-2"}, {"direction", "in"}};
  auto of = [](std::map<std::string, std::string> labels, const char* name, const char* value) {
    labels[name] = value;
    return labels;
  };
  CHECK(page.find("footlight_ticks_total", {}) == 77);
  CHECK(page.find("footlight_frames_total", of(in, "universe", "2")) == 20);
  CHECK(page.find("footlight_port_rejected_total", in) == 3);
  CHECK(page.find("footlight_port_unrouted_total", in) == 4);
  CHECK(page.find("footlight_port_up", in) == 1);
  CHECK(page.find("footlight_port_up", {{"port", "sacn:1-2 #2"}, {"direction", "in"}}) == 1);
  const std::map<std::string, std::string> out = {{"port", "log:a \"b\"\\c\xEF\xBF\xBD\xEF\xBF\xBD.dmxlog"},
                                                  {"direction", "out"}};
  CHECK(page.find("footlight_port_up", out) == 0);
  CHECK(page.find("footlight_port_state", of(out, "state", "gone")) == 1);
  CHECK(page.find("footlight_port_figure", of(out, "figure", "break_us_p50")) == 176.5);
  CHECK(page.find("footlight_port_figure", of(out, "figure", "rate_hz")) == 33.0);
  CHECK(page.find("footlight_frames_total", of(out, "universe", "1")) == 10);
  CHECK(page.find("footlight_universe_age_seconds", {{"universe", "1"}}) == 2);
  CHECK_FALSE(page.find("footlight_universe_age_seconds", {{"universe", "2"}}).has_value());
  CHECK(page.find("footlight_senders_lost_total", {{"universe", "1"}, {"reason", "silent"}}) == 5);
  CHECK(page.find("footlight_sender_lost_frames", {{"universe", "1"}, {"sender", "FOH \"1\""}}) == 12);
  CHECK(page.find("footlight_sender_late_frames", {{"universe", "1"}, {"sender", "FOH \"1\""}}) == 2);
  CHECK(page.find("footlight_sender_lost_frames", {{"universe", "1"}, {"sender", "FOH \"1\" #2"}}) == 0);
  CHECK(page.find("footlight_reloads_total", {{"result", "taken"}}) == 2);
  CHECK(page.find("footlight_start_time_seconds", {}) == 5);
}

TEST_CASE("buckets of a histogram grow with their edge and end in the count") {
  const Page page = parse(metrics_text(full_status(), {}));
  double before = 0.0;
  double edge_before = 0.0;
  int buckets = 0;
  for (const Sample& sample : page.samples) {
    if (sample.name != "footlight_latency_seconds_bucket") continue;
    const double edge = std::strtod(sample.labels.at("le").c_str(), nullptr);
    CHECK(edge > edge_before);
    CHECK(sample.value >= before);
    // 10 and 20 us, 20 ms, 2 s
    CHECK(sample.value == (edge > 2.0 ? 4 : edge > 20e-3 ? 3 : edge > 20e-6 ? 2 : edge > 10e-6 ? 1 : 0));
    edge_before = edge;
    before = sample.value;
    ++buckets;
  }
  CHECK(buckets == kTimingPowerCount + 1);
  CHECK(before == 4);
}

TEST_CASE("every family of a metrics page is in docs/metrics.md, and no other") {
  std::ifstream document(FOOTLIGHT_SOURCE_DIR "/docs/metrics.md");
  std::map<std::string, std::string> written;
  const std::regex row(R"(^\| `(footlight_[a-z_]+)` \| ([a-z]+) \|)");
  for (std::string line; std::getline(document, line);) {
    std::smatch match;
    if (std::regex_search(line, match, row)) written[match[1]] = match[2];
  }
  ServiceFacts facts;
  facts.flashes = FlashFacts{2, 3};
  const Page page = parse(metrics_text(full_status(), facts));
  CHECK(written == page.types);
  CHECK(page.find("footlight_flashes_held_total", {}) == 3);
  CHECK_FALSE(parse(metrics_text(full_status(), {})).find("footlight_flashes_held_total", {}).has_value());
}

TEST_CASE("promtool accepts a metrics page") {
  const testing::TempFolder folder;
  std::ofstream(folder.file("page")) << metrics_text(full_status(), {});
  const int code = std::system(("promtool check metrics < " + folder.file("page") + " > " + folder.file("output") +
                                " 2>&1; code=$?; test $code = 127 && exit 77; exit $code")
                                   .c_str());
  std::ifstream output(folder.file("output"));
  CAPTURE(std::string(std::istreambuf_iterator<char>(output), {}));
  if (WEXITSTATUS(code) == 77) {
    MESSAGE("skipped: promtool is not installed");
    return;
  }
  CHECK(WEXITSTATUS(code) == 0);
}

TEST_CASE("a running bridge serves its metrics at the given address, and nothing else there") {
  const testing::TempFolder folder;
  const std::string place = folder.file("metrics.sock");
  testing::Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json", "--socket", "none",
                             "--metrics", "unix:" + place});
  bridge.wait_for(R"("event":"ready")");
  auto answer = http_request(place, "GET", "/metrics");
  while (answer && answer->status == 503) answer = http_request(place, "GET", "/metrics");  // still starting
  REQUIRE_MESSAGE(answer.has_value(), (answer ? "" : answer.error().message));
  CHECK(answer->status == 200);
  const Page page = parse(answer->body);
  CHECK(page.find("footlight_port_up", {{"port", "mock:enttec-pro"}, {"direction", "out"}}).has_value());
  CHECK(http_request(place, "GET", "/status")->status == 404);
  CHECK(http_request(place, "POST", "/metrics")->status == 405);
  CHECK(http_request(place, "POST", "/reload")->status == 404);
}

}  // namespace
}  // namespace footlight::tools
