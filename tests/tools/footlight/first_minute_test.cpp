// From the README to a moving picture: its commands and the console of docs/tutorial.md, in a small window under Xvfb.
// With FOOTLIGHT_PRINT_COSTS=1 it prints how long that took.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/drivers/net/private_network.h"
#include "tests/support/headless_vulkan.h"
#include "tests/tools/footlight/display.h"
#include "tests/tools/footlight/doc_lines.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience(300);  // a picture of lavapipe takes seconds on a busy machine
constexpr std::chrono::milliseconds kPause(20);

// A line of a page, which must be there, without the program's name. `from` in it becomes `to`.
Words line_of(const char* page, const std::string& line, const std::string& from = "", const std::string& to = "") {
  const Words lines = doc_lines(std::string(FOOTLIGHT_SOURCE_DIR) + "/" + page);
  INFO(line);
  REQUIRE(std::find(lines.begin(), lines.end(), line) != lines.end());
  Words words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word == from ? to : word);
  words.erase(words.begin());
  return words;
}

// The window, until pictures have had three different numbers of lit beams. Returns seconds since `begun`.
double seconds_until_it_moves(const Display& display, const TempFolder& folder, Words words, Clock::time_point begun) {
  words.insert(words.end(), {"--size", "320x180", "--json"});
  Footlight window(words, {{"DISPLAY", display.name()},
                           {"WAYLAND_DISPLAY", ""},
                           {"XDG_STATE_HOME", folder.file("state")},
                           {"ASAN_OPTIONS", "detect_leaks=0"}});  // drivers of GPUs leak
  std::set<int> lit;
  std::string last;
  while (lit.size() < 3 && Clock::now() - begun < kPatience) {
    std::this_thread::sleep_for(kPause);
    last = window.last_line();
    const auto figures = nlohmann::json::parse(last, nullptr, false);
    if (figures.is_object() && figures["event"] == "frames") lit.insert(figures["live"].get<int>());
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  INFO("the last line is ", last);
  CHECK(lit.size() == 3);
  window.signal(SIGTERM);
  CHECK(window.wait().exit_code == 0);
  return seconds;
}

TEST_CASE("the commands of the README show a console and a model of a dongle as a moving picture") {
  if (std::system("command -v Xvfb > /dev/null") != 0) {  // NOLINT: fixed words
    MESSAGE("skipped: needs Xvfb; 'sudo apt-get install xvfb'");
    return;
  }
  if (!enter_private_network()) return;
  {
    const HeadlessVulkan vulkan;
    if (!vulkan) return;
  }
  const TempFolder folder;
  const WorkingFolder in(folder.file(""));
  const Display display(320, 180);
  REQUIRE(!display.name().empty());
  const auto begun = Clock::now();
  REQUIRE(footlight(line_of("README.md", "footlight samples samples")).exit_code == 0);
  std::filesystem::current_path("samples");
  const std::string preview = "footlight preview rig.toml --in sacn:1-9";
  Footlight console(line_of("docs/tutorial.md", "footlight replay --demo --loop --out sacn:1-2%lo"));
  const double console_s =
      seconds_until_it_moves(display, folder, line_of("README.md", preview, "sacn:1-9", "sacn:1-9%lo"), begun);
  console.signal(SIGTERM);
  CHECK(console.wait().exit_code == 0);
  const auto begun_again = Clock::now();
  const double dongle_s = seconds_until_it_moves(
      display, folder, line_of("README.md", preview, "sacn:1-9", "mock:enttec-pro"), begun_again);
  const char* prints = std::getenv("FOOTLIGHT_PRINT_COSTS");  // NOLINT(concurrency-mt-unsafe): one thread
  if (prints == nullptr) return;
  fmt::print("a moving picture: {:.1f} s with a console and the samples, {:.1f} s with a model of a dongle\n",
             console_s, dongle_s);
}

}  // namespace
}  // namespace footlight::testing
