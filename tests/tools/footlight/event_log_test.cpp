#include "tools/footlight/bridge/event_log.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "sim/core/clock.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

Event lost() {
  return {{.level = NoticeLevel::kWarning,
           .id = "port-lost",
           .text = "enttec-pro:EN1: lost: un\nplugged",
           .port = "enttec-pro:EN1",
           .universe = 7},
          1'785'175'391'412'345'678};
}

TEST_CASE("times of events are UTC, truncated and not rounded") {
  CHECK(utc_text(0, 0) == "1970-01-01T00:00:00Z");
  CHECK(utc_text(1'785'175'391'412'999'999, 3) == "2026-07-27T18:03:11.412Z");
  CHECK(utc_text(1'785'175'391'412'345'678, 9) == "2026-07-27T18:03:11.412345678Z");
  CHECK(utc_text(-1, 3) == "1969-12-31T23:59:59.999Z");
  CHECK(utc_text(951'782'400 * kNsPerS, 0) == "2000-02-29T00:00:00Z");
}

TEST_CASE("an event is one line of text, whatever its message contains") {
  CHECK(event_text(lost()) == "2026-07-27T18:03:11.412Z warning port-lost: enttec-pro:EN1: lost: un plugged");
}

TEST_CASE("an event as JSON has id, level, port and universe separate from the text") {
  const auto json = nlohmann::json::parse(json_of_event(lost()));
  CHECK(json["event"] == "port-lost");
  CHECK(json["level"] == "warning");
  CHECK(json["time"] == "2026-07-27T18:03:11.412345Z");
  CHECK(json["port"] == "enttec-pro:EN1");
  CHECK(json["universe"] == 7);
  CHECK(json_of_event(lost()).find('\n') == std::string::npos);
  const auto notice = nlohmann::json::parse(json_of_notice(lost()));
  CHECK(notice["event"] == "notice");
  CHECK(notice["id"] == "port-lost");
  const auto plain = nlohmann::json::parse(json_of_event({{.id = "ready", .text = "ready"}, 0}));
  CHECK_FALSE(plain.contains("port"));
  CHECK_FALSE(plain.contains("universe"));
}

TEST_CASE("wrong words for format and level are refused with the expected words") {
  CHECK(event_format_of("xml").error().message.find("text, json or journal") != std::string::npos);
  CHECK(notice_level_of("loud").error().message.find("info, warning or error") != std::string::npos);
  CHECK(event_format_of("json").value() == EventFormat::kJson);
  CHECK(notice_level_of("error").value() == NoticeLevel::kError);
}

// Every "some-id" that follows NoticeLevel::k... in the source, compared with the table of the document.
TEST_CASE("every event of the source is in docs/events.md, and no other") {
  std::set<std::string> ids;
  const std::regex id(R"rx(NoticeLevel::k[A-Z][a-z]+,\s*(?:\.id = )?"([a-z-]+)")rx");
  for (const char* folder : {"sim", "drivers", "tools"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(FOOTLIGHT_SOURCE_DIR "/" + std::string(folder))) {
      if (entry.path().extension() != ".cpp") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      for (auto at = std::sregex_iterator(text.begin(), text.end(), id); at != std::sregex_iterator(); ++at) {
        ids.insert((*at)[1]);
      }
    }
  }
  std::set<std::string> written;
  std::ifstream document(FOOTLIGHT_SOURCE_DIR "/docs/events.md");
  const std::regex row(R"(^\| `([a-z-]+)` \|)");
  for (std::string line; std::getline(document, line);) {
    std::smatch match;
    if (std::regex_search(line, match, row)) written.insert(match[1]);
  }
  CHECK(ids.size() > 5);
  for (const std::string& word : ids) {
    CAPTURE(word);
    CHECK(written.contains(word));
  }
  for (const std::string& word : written) {
    CAPTURE(word);
    CHECK(ids.contains(word));
  }
}

TEST_CASE("--log-format json writes events to standard error, --log-level leaves out lower ones") {
  using testing::footlight;
  const std::vector<std::string> unfed = {"run",   "--in", "mock:enttec-pro", "--out", "mock:enttec-pro=2",
                                          "--for", "0s"};
  auto arguments = unfed;
  arguments.insert(arguments.end(), {"--log-format", "json"});
  const auto outcome = footlight(arguments);
  CHECK(outcome.exit_code == 0);
  CHECK(outcome.err.find(R"("event":"universe-unfed")") != std::string::npos);
  CHECK(outcome.out.empty());
  arguments.insert(arguments.end(), {"--log-level", "error"});
  CHECK(footlight(arguments).err.find("universe-unfed") == std::string::npos);
  CHECK(footlight({"run", "--in", "sacn:1", "--out", "sacn:2", "--log-format", "xml"}).exit_code == 2);
}

}  // namespace
}  // namespace footlight::tools
