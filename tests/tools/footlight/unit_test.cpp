// The systemd unit, checked by systemd-analyze if that is installed.
#include <cstdio>
#include <fstream>
#include <regex>
#include <string>

#include <sys/wait.h>

#include <doctest/doctest.h>

#include "drivers/wait/real_time.h"

namespace footlight::testing {
namespace {

struct Output {
  int exit_code = -1;
  std::string text;
};

Output analyze(const std::string& arguments) {
  Output output;
  FILE* const pipe = popen(("systemd-analyze " + arguments + " " FOOTLIGHT_UNIT " 2>&1").c_str(), "r");
  REQUIRE(pipe != nullptr);
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) output.text += buffer;
  output.exit_code = WEXITSTATUS(pclose(pipe));
  if (output.exit_code == 127) MESSAGE("skipped: systemd-analyze is not installed");
  return output;
}

TEST_CASE("systemd-analyze finds no fault in the unit") {
  const Output output = analyze("verify");
  if (output.exit_code == 127) return;
  CAPTURE(output.text);
  CHECK(output.exit_code == 0);
  CHECK(output.text.find("footlight.service:") == std::string::npos);  // the line of a warning
}

TEST_CASE("systemd-analyze rates the exposure of the service below 2 of 10") {
  const Output output = analyze("security --offline=true --no-pager");
  if (output.exit_code == 127) return;
  std::smatch match;
  REQUIRE(std::regex_search(output.text, match, std::regex(R"(exposure level for footlight\.service: ([0-9.]+))")));
  CAPTURE(match[1].str());
  CHECK(std::stod(match[1]) < 2.0);
}

TEST_CASE("the unit allows the real-time priority that the service requests") {
  std::ifstream file(FOOTLIGHT_UNIT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  CHECK(text.find("\nLimitRTPRIO=" + std::to_string(drivers::kRealTimePriority) + "\n") != std::string::npos);
  CHECK(text.find("\nRestrictRealtime=yes") == std::string::npos);
  CHECK(text.find('@') != std::string::npos);       // filters
  CHECK(text.find("@CMAKE") == std::string::npos);  // filled in
  CHECK(text.find("@FOOTLIGHT") == std::string::npos);
}

TEST_CASE("the unit keeps a remembered blackout while it is stopped, and lets MIDI devices be read") {
  std::ifstream file(FOOTLIGHT_UNIT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  CHECK(text.find("\nRuntimeDirectoryPreserve=yes\n") != std::string::npos);
  CHECK(text.find("\nDeviceAllow=/dev/snd/seq rw\n") != std::string::npos);
  CHECK(std::regex_search(text, std::regex(R"(\nSupplementaryGroups=[^\n]*\baudio\b)")));
}

TEST_CASE("the unit allows every address family that the ports use") {
  std::ifstream file(FOOTLIGHT_UNIT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::smatch match;
  REQUIRE(std::regex_search(text, match, std::regex(R"(\nRestrictAddressFamilies=([^\n]*)\n)")));
  const std::string families = " " + match[1].str() + " ";
  for (const char* const family : {"AF_INET", "AF_INET6", "AF_UNIX", "AF_NETLINK"}) {
    CAPTURE(family);
    CHECK(families.find(" " + std::string(family) + " ") != std::string::npos);
  }
}

}  // namespace
}  // namespace footlight::testing
