// The unit of systemd, judged by systemd's own tool where that is installed.
#include <cstdio>
#include <fstream>
#include <regex>
#include <string>

#include <sys/wait.h>

#include <doctest/doctest.h>

#include "drivers/wait/real_time.h"

namespace footlight::testing {
namespace {

struct Said {
  int exit_code = -1;
  std::string text;
};

Said analyze(const std::string& arguments) {
  Said said;
  FILE* const pipe = popen(("systemd-analyze " + arguments + " " FOOTLIGHT_UNIT " 2>&1").c_str(), "r");
  REQUIRE(pipe != nullptr);
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) said.text += buffer;
  said.exit_code = WEXITSTATUS(pclose(pipe));
  if (said.exit_code == 127) MESSAGE("skipped: systemd-analyze is not installed");
  return said;
}

TEST_CASE("systemd finds no fault in the unit") {
  const Said said = analyze("verify");
  if (said.exit_code == 127) return;
  CAPTURE(said.text);
  CHECK(said.exit_code == 0);
  CHECK(said.text.find("footlight.service:") == std::string::npos);  // the line of a warning
}

TEST_CASE("systemd rates the exposure of the service below 2 of 10") {
  const Said said = analyze("security --offline=true --no-pager");
  if (said.exit_code == 127) return;
  std::smatch match;
  REQUIRE(std::regex_search(said.text, match, std::regex(R"(exposure level for footlight\.service: ([0-9.]+))")));
  CAPTURE(match[1].str());
  CHECK(std::stod(match[1]) < 2.0);
}

TEST_CASE("the unit lets the service have the real-time priority that it asks for") {
  std::ifstream file(FOOTLIGHT_UNIT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  CHECK(text.find("\nLimitRTPRIO=" + std::to_string(drivers::kRealTimePriority) + "\n") != std::string::npos);
  CHECK(text.find("\nRestrictRealtime=yes") == std::string::npos);
  CHECK(text.find('@') != std::string::npos);       // filters
  CHECK(text.find("@CMAKE") == std::string::npos);  // filled in
  CHECK(text.find("@FOOTLIGHT") == std::string::npos);
}

TEST_CASE("the unit lets the service open every address family that its ports use") {
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
