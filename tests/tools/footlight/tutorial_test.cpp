// docs/tutorial.md, done step by step in the window with a mouse and a keyboard of xdotool, under Xvfb.
//
// The places of buttons are those of a window of 960 x 540 with the panels where they open. A panel that looks
// different moves them: make the pictures (tools/tutorial_pictures), look at them, and change the places here. With
// FOOTLIGHT_TUTORIAL_PICTURES=FOLDER the pictures of the page are kept there.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
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

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kPage = FOOTLIGHT_SOURCE_DIR "/docs/tutorial.md";
constexpr int kWidth = 960;
constexpr int kHeight = 540;
constexpr std::chrono::seconds kPatience(300);  // for one effect; a picture of lavapipe takes seconds on a busy machine
constexpr std::chrono::milliseconds kPause(100);

struct Place {
  int x = 0;
  int y = 0;
};

// The words of a line of the page, without the program's name.
Words words_of(const std::string& line) {
  Words words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  words.erase(words.begin());
  return words;
}

class Desk {
 public:
  Desk(const Display& display, const TempFolder& folder, const std::string& line)
      : display_(display.name()), window_(with_size(line), environment(display, folder)) {
    wait("a picture", [](const Json&) { return true; });
  }

  void key(const char* name) const { xdotool(fmt::format("key {}", name)); }
  // A panel is there for clicks from the picture after the key on.
  void panel(const char* name) {
    key(name);
    settle();
  }
  // Into the field at a place. Letters that come before the field has the keyboard would be keys of the window.
  void type(Place field, const char* text) {
    click(field);
    settle();
    xdotool(fmt::format("type --delay 30 '{}'", text));
    settle();
  }
  void click(Place at) const {
    xdotool(fmt::format("mousemove {} {}", at.x, at.y));
    xdotool("click 1");
  }
  void click_with_ctrl(Place at) const {
    xdotool("keydown ctrl");
    click(at);
    xdotool("keyup ctrl");
  }
  void drag(Place from, Place to) const {
    xdotool(fmt::format("mousemove {} {}", from.x, from.y));
    xdotool("mousedown 1");
    std::this_thread::sleep_for(10 * kPause);
    xdotool(fmt::format("mousemove {} {}", to.x, to.y));
    xdotool("mouseup 1");
  }
  // The mouse beside all panels and lamps: nothing has its colours of a mouse over it.
  void rest() const { xdotool(fmt::format("mousemove 2 {}", kHeight / 2)); }

  // Until a line of figures says so.
  Json wait(const std::string& what, const std::function<bool(const Json&)>& is) {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    Json figures;
    while (std::chrono::steady_clock::now() < until) {
      figures = Json::parse(window_.last_line(), nullptr, false);
      if (figures.is_object() && figures["event"] == "frames" && is(figures)) return figures;
      std::this_thread::sleep_for(kPause);
    }
    INFO("waited for ", what, "; the last line is ", figures.dump());
    REQUIRE(false);
    return figures;
  }
  // Two more lines: what was asked before is done, and shown.
  void settle() {
    const std::uint64_t frames = wait("a line", [](const Json&) { return true; })["frames"];
    wait("two more pictures", [&](const Json& line) { return line["frames"].get<std::uint64_t>() >= frames + 3; });
  }

  // F12, and the picture under its name of the page.
  void picture(int number) {
    rest();
    settle();
    key("F12");
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!fs::exists("footlight_0001.png") || fs::file_size("footlight_0001.png") < 1000) {
      REQUIRE(std::chrono::steady_clock::now() < until);
      std::this_thread::sleep_for(kPause);
    }
    settle();                                                         // it is written
    const char* folder = std::getenv("FOOTLIGHT_TUTORIAL_PICTURES");  // NOLINT(concurrency-mt-unsafe): one thread
    if (folder != nullptr) {
      fs::copy_file("footlight_0001.png", fs::path(folder) / fmt::format("tutorial_{}.png", number),
                    fs::copy_options::overwrite_existing);
    }
    fs::remove("footlight_0001.png");
  }

  Outcome close() {
    window_.signal(SIGTERM);
    return window_.wait();
  }

 private:
  static Words with_size(const std::string& line) {
    Words words = words_of(line);
    words.insert(words.end(), {"--size", fmt::format("{}x{}", kWidth, kHeight), "--json", "--period", "200ms"});
    return words;
  }
  static std::map<std::string, std::string> environment(const Display& display, const TempFolder& folder) {
    return {{"DISPLAY", display.name()},
            {"WAYLAND_DISPLAY", ""},
            {"XDG_STATE_HOME", folder.file("state")},
            {"GALLIVM_PERF", ""},                 // lavapipe optimises its code, which draws hundreds of pictures
            {"ASAN_OPTIONS", "detect_leaks=0"}};  // drivers of GPUs leak (tests/support/headless_vulkan.cpp)
  }
  void xdotool(const std::string& what) const {
    const std::string line = fmt::format("DISPLAY={} xdotool {}", display_, what);
    REQUIRE(std::system(line.c_str()) == 0);  // NOLINT: words of this file only
    std::this_thread::sleep_for(kPause);
  }

  std::string display_;
  Footlight window_;
};

bool can_do_it() {
  const bool has = std::system("command -v Xvfb > /dev/null && command -v xdotool > /dev/null") == 0;  // NOLINT: fixed
  if (!has) MESSAGE("skipped: needs Xvfb and xdotool; 'sudo apt-get install xvfb xdotool'");
  return has;
}

bool is_in(const Json& list, const char* text) { return std::find(list.begin(), list.end(), text) != list.end(); }

// Steps 1 to 3: faders, a chase, the network.
void light_it(Desk& desk) {
  desk.wait("all fixtures lit by faders", [](const Json& line) { return line["live"] == 8; });
  desk.picture(1);

  desk.panel("F6");
  desk.click({418, 400});  // add chase
  desk.wait("a chase", [](const Json& line) { return is_in(line["inputs"], "mock:chase") && line["dark"] == 6; });
  desk.key("F6");
  desk.picture(2);
  desk.panel("F6");
  desk.click({638, 306});  // remove
  desk.wait("the faders", [](const Json& line) { return line["inputs"].empty() && line["live"] == 8; });

  desk.type({100, 400}, "sacn:1-2%lo");  // the field for an input
  desk.key("Return");
  std::set<int> lit;
  desk.wait("a show from the network", [&](const Json& line) {
    if (is_in(line["inputs"], "sacn:1-2%lo")) lit.insert(line["live"].get<int>());
    return lit.size() >= 2;
  });
  desk.key("F6");
  desk.wait("most fixtures lit", [](const Json& line) { return line["live"] >= 6; });
  desk.picture(3);
}

// Steps 4 to 7: select, aim, add, undo, save.
void edit_it(Desk& desk) {
  desk.panel("F3");
  desk.click({41, 109});  // Spot 2
  desk.wait("one fixture selected", [](const Json& line) { return line["selected"] == 1; });
  desk.click_with_ctrl({41, 127});  // Spot 3
  desk.wait("two fixtures selected", [](const Json& line) { return line["selected"] == 2; });
  desk.key("F3");
  desk.key("l");
  desk.picture(4);

  desk.key("l");
  desk.panel("F4");
  desk.drag({430, 280}, {400, 280});  // pan
  desk.wait("pan of both taken over", [](const Json& line) { return line["taken_over"] == 2; });
  desk.picture(5);

  desk.key("F4");
  desk.panel("F7");
  desk.type({100, 96}, "generic wash");  // its field
  desk.click({60, 136});                 // the row that is left
  desk.settle();
  desk.click({425, 308});  // Add
  desk.wait("a ninth fixture",
            [](const Json& line) { return line["fixtures"] == 9 && line["unsaved"] == true && line["selected"] == 1; });
  desk.key("F7");
  desk.picture(6);

  desk.key("ctrl+z");
  desk.wait("eight fixtures", [](const Json& line) { return line["fixtures"] == 8 && line["unsaved"] == false; });
  desk.key("ctrl+y");
  desk.wait("the ninth again", [](const Json& line) { return line["fixtures"] == 9 && line["unsaved"] == true; });
  desk.key("ctrl+s");
  desk.wait("the rig saved", [](const Json& line) { return line["unsaved"] == false; });
  desk.picture(7);
  CHECK(fs::exists("stage.toml~"));
  std::ifstream file("stage.toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  CHECK(text.find("Wash 1") != std::string::npos);
}

// Steps 8 to 10, in the window with the log.
void arm_it(Desk& desk) {
  desk.click({200, 470});  // in the timeline
  desk.key("space");
  const Json there = desk.wait("a pause where it was clicked", [](const Json& line) {
    return line["stands"] == true && line["time_ns"] >= 4 * std::int64_t{1'000'000'000} &&
           line["time_ns"] <= 15 * std::int64_t{1'000'000'000};
  });
  desk.key("m");
  desk.settle();
  CHECK(fs::exists("mine.dmxlog.markers.toml"));
  desk.picture(8);
  CHECK(desk.wait("the same moment", [](const Json&) { return true; })["time_ns"] == there["time_ns"]);

  desk.key("F5");
  desk.panel("F6");
  desk.click({384, 242});  // add a made-up interface
  desk.settle();
  desk.click({574, 166});  // arm ...
  desk.settle();
  desk.wait("nothing sent before the tick", [](const Json& line) { return line["outputs_live"] == 0; });
  desk.click({311, 309});  // the tick
  desk.settle();
  desk.click({319, 332});  // Arm
  desk.wait("a live output", [](const Json& line) { return line["outputs_live"] == 1; });
  desk.key("F6");
  desk.picture(9);
  desk.key("b");
  desk.wait("a blackout", [](const Json& line) { return line["blackout"] == true; });
  desk.picture(10);
  desk.key("shift+b");
  desk.wait("its end", [](const Json& line) { return line["blackout"] == false && line["outputs_live"] == 1; });
  desk.key("ctrl+d");
  desk.wait("no live output", [](const Json& line) { return line["outputs_live"] == 0; });
}

TEST_CASE("the ten steps of the tutorial do what the page says, by mouse and keyboard") {
  if (!can_do_it() || !enter_private_network()) return;
  {
    const HeadlessVulkan vulkan;
    if (!vulkan) return;
  }
  const TempFolder folder;
  const WorkingFolder in(folder.file(""));
  for (const auto& [name, text] : doc_files(kPage)) folder.write(name, text);
  REQUIRE(fs::exists("stage.toml"));
  const Words lines = doc_lines(kPage);
  REQUIRE(lines.size() == 4);
  const Display display(kWidth, kHeight);
  REQUIRE(!display.name().empty());
  {
    Footlight sender(words_of(lines[1]));
    Desk desk(display, folder, lines[0]);
    light_it(desk);
    edit_it(desk);
    const Outcome recorded = footlight(words_of(lines[2]));
    INFO(recorded.err);
    REQUIRE(recorded.exit_code == 0);
    CHECK(desk.close().exit_code == 0);
    sender.signal(SIGTERM);
    CHECK(sender.wait().exit_code == 0);
  }
  Desk desk(display, folder, lines[3]);
  arm_it(desk);
  CHECK(desk.close().exit_code == 0);
}

}  // namespace
}  // namespace footlight::testing
