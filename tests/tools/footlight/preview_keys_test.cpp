// The window with a keyboard and a mouse of xdotool, under Xvfb: full screen, what keys say, and what is left after the
// program is killed. Skipped with a message where one of them is not installed.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <system_error>
#include <thread>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/support/headless_vulkan.h"
#include "tests/tools/footlight/display.h"
#include "tests/tools/footlight/one_par.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kKeyPatience(120);  // for one effect, on a busy machine
constexpr std::chrono::milliseconds kKeyPause(50);

bool can_press_keys() {
  const HeadlessVulkan vulkan;
  if (!vulkan) return false;
  const bool has = std::system("command -v Xvfb > /dev/null && command -v xdotool > /dev/null") == 0;  // NOLINT: fixed
  if (!has) MESSAGE("skipped: needs Xvfb and xdotool; 'sudo apt-get install xvfb xdotool'");
  return has;
}

bool until(const std::function<bool()>& is) {
  const auto end = std::chrono::steady_clock::now() + kKeyPatience;
  while (!is()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kKeyPause);
  }
  return true;
}

// Whether a folder, to which another process writes, or one of its folders has a file.
bool has_file(const std::string& folder, const std::string& name) {
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().filename() == name) return true;
  }
  return false;
}

// A window over a rig of one par, in a display of its own.
class KeyWindow {
 public:
  KeyWindow(const TempFolder& folder, const Display& display, std::vector<std::string> more)
      : display_(display.name()), window_(words(folder, std::move(more)), environment(folder, display)) {
    window_.wait_for("\"event\":\"frames\"");
  }
  // The mouse is over the window, since without a window manager that one has the keyboard.
  void key(const char* name) const { xdotool(fmt::format("mousemove 160 150 key {}", name)); }
  void click(int x, int y) const { xdotool(fmt::format("mousemove {} {} click 1", x, y)); }
  // "320x180+0+0".
  [[nodiscard]] std::string geometry(const TempFolder& folder) const {
    const std::string file = folder.file("geometry");
    xdotool(fmt::format("search --name Footlight getwindowgeometry --shell > {}", file));
    std::map<std::string, std::string> values;
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) {
      if (const std::size_t at = line.find('='); at != std::string::npos)
        values[line.substr(0, at)] = line.substr(at + 1);
    }
    return fmt::format("{}x{}+{}+{}", values["WIDTH"], values["HEIGHT"], values["X"], values["Y"]);
  }
  bool prints(const std::string& text, int times = 1) {
    return until([&] { return window_.has_printed(text, times); });
  }
  Footlight& program() { return window_; }

 private:
  static std::vector<std::string> words(const TempFolder& folder, std::vector<std::string> more) {
    std::vector<std::string> all{"preview", folder.file("rig.toml"), "--json", "--shadows", "off", "--bounce", "off"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static std::map<std::string, std::string> environment(const TempFolder& folder, const Display& display) {
    return {{"DISPLAY", display.name()},
            {"WAYLAND_DISPLAY", ""},
            {"LANGUAGE", "en"},
            {"XDG_STATE_HOME", folder.file("state")},
            {"ASAN_OPTIONS", "detect_leaks=0"}};  // drivers of GPUs leak (tests/support/headless_vulkan.cpp)
  }
  void xdotool(const std::string& what) const {
    const std::string line = fmt::format("DISPLAY={} xdotool {}", display_, what);
    REQUIRE(std::system(line.c_str()) == 0);  // NOLINT: words of this file only
  }

  std::string display_;
  Footlight window_;
};

TEST_CASE("F11 makes the window as large as the screen, and again as it was, and keys that do nothing say why") {
  if (!can_press_keys()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  const Display display(640, 400);
  REQUIRE(!display.name().empty());
  KeyWindow window(folder, display, {"--size", "320x180"});
  const std::string before = window.geometry(folder);
  CHECK(before.starts_with("320x180+"));
  window.key("F11");
  CHECK(until([&] { return window.geometry(folder) == "640x400+0+0"; }));
  window.key("F11");
  CHECK(until([&] { return window.geometry(folder) == before; }));

  window.key("l");
  CHECK(window.prints(R"({"event":"message","text":"select a fixture first","wrong":false})"));
  window.key("ctrl+a");
  CHECK(window.prints(R"({"event":"command","how":"run","text":"select Par"})"));
  window.key("ctrl+z");
  CHECK(window.prints(R"({"event":"command","how":"undo","text":"select Par"})"));
  window.key("space");
  CHECK(window.prints("no log plays"));
  window.program().signal(SIGTERM);
  CHECK(window.program().wait().exit_code == 0);
}

TEST_CASE("a window that is killed with unsaved edits and a recording leaves both, and a click recovers the edits") {
  if (!can_press_keys()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  const Display display(640, 200);
  REQUIRE(!display.name().empty());
  const std::string recording = folder.file("kept.dmxlog");
  {
    KeyWindow window(folder, display, {"--size", "640x180", "--record", recording});
    window.key("ctrl+a");
    window.key("ctrl+Right");
    CHECK(window.prints("\"unsaved\":true"));
    CHECK(until([&] { return has_file(folder.file("state"), "rig.toml"); }));  // the last one of an automatic copy
    window.program().signal(SIGKILL);
    CHECK(window.program().wait().exit_code == -1);
  }
  CHECK(!fs::exists(recording));
  const Outcome converted = footlight({"log", "convert", recording + ".part", recording});
  INFO(converted.err);
  CHECK(converted.exit_code == 0);
  const Outcome log = footlight({"log", "info", recording});
  INFO(log.err);
  CHECK(log.exit_code == 0);

  KeyWindow window(folder, display, {"--size", "640x180"});
  // Along the line at the top, and below it, where the buttons are if they do not fit: the first one is Recover.
  for (const int y : {22, 42}) {
    for (int x = 12; x < 620 && !window.program().has_printed("\"event\":\"loading\"", 2); x += 8) {
      window.click(x, y);
      std::this_thread::sleep_for(kKeyPause);
    }
  }
  REQUIRE(window.prints("\"event\":\"loading\"", 2));
  REQUIRE(window.prints("\"unsaved\":true"));
  window.key("ctrl+s");
  CHECK(window.prints("\"text\":\"saved "));
  window.program().signal(SIGTERM);
  CHECK(window.program().wait().exit_code == 0);
  std::ifstream saved(folder.file("rig.toml"));
  const std::string text{std::istreambuf_iterator<char>(saved), {}};
  INFO(text);
  CHECK(text.find("0.1") != std::string::npos);
}

}  // namespace
}  // namespace footlight::testing
