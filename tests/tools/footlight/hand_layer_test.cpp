// Levels by hand in the window, without a window: over a log or faders, and in the merge of live inputs.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "sim/pattern.h"
#include "sim/system_clock.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/bridge/bridge_sockets.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/preview/hand_layer.h"

namespace footlight::tools {
namespace {

using testing::TempFolder;

const std::vector<Universe> kRig{1, 3};

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// Until the condition holds, for at most 30 s.
template <class Condition>
bool eventually(Condition condition) {
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
  while (clock.now_ns() < end_ns) {
    if (condition()) return true;
    std::this_thread::yield();
  }
  return false;
}

// A window with a rig of two universes, whose log or faders give every slot the level `base`.
struct WindowOf {
  explicit WindowOf(std::uint8_t level = 100)
      : base(level), layer(HandLayer::open({.socket = folder.file("s"), .rig = ""}, clock).value()) {
    CHECK(layer->rest_on("faders", kRig).has_value());
  }

  // What the fixtures get of a slot, with a panel that has taken over slot 5 of universe 1 at 77.
  int level(Universe universe, Address address) {
    std::vector<std::uint8_t> levels(kRig.size() * kSlotCountMax, base);
    layer->follow(kRig, levels);
    layer->overlay(kRig, levels);
    levels[5] = 77;
    layer->darken(kRig, levels);
    return levels[(universe == 1 ? 0u : kSlotCountMax) + static_cast<std::size_t>(address) - 1];
  }
  bool shows(Universe universe, Address address, int wanted) {
    return eventually([&] { return level(universe, address) == wanted; });
  }
  int post(const std::string& command) const {
    return http_request(folder.file("s"), "POST", "/hand", 30 * kNsPerS, "footlight-hand 1\n" + command)->status;
  }
  std::string page(const std::string& path) const {
    return http_request(folder.file("s"), "GET", path, 30 * kNsPerS)->body;
  }
  std::unique_ptr<LiveLevels> inputs() {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<PatternSource>("mock:full", Pattern::kFull, every_slot(kRig)));
    return LiveLevels::start(kRig, std::move(sources), clock).value();
  }

  SystemClock clock;
  TempFolder folder;
  std::uint8_t base;
  std::unique_ptr<HandLayer> layer;
};

TEST_CASE("a command on the window's socket sets slots over the faders, and a release gives them back") {
  WindowOf window;
  CHECK(!window.layer->overlays());
  CHECK(window.post("set\n3.7=9") == 200);
  CHECK(window.shows(3, 7, 9));
  CHECK(window.layer->overlays());
  CHECK(window.level(3, 8) == 100);
  CHECK(window.level(1, 7) == 100);
  CHECK(window.layer->held().held_count() == 1);
  CHECK(contains(window.page("/hand"), "3.7=9"));
  window.base = 30;  // the log goes on
  CHECK(window.level(3, 8) == 30);
  CHECK(window.level(3, 7) == 9);
  CHECK(window.post("release\n3.7") == 200);
  CHECK(window.shows(3, 7, 30));
  CHECK(eventually([&] { return window.level(3, 7) == 30 && !window.layer->overlays(); }));
}

TEST_CASE("what is set by hand has one state in the window and for the monitor: it works, also when it holds nothing") {
  WindowOf window;
  CHECK(window.post("set\n3.7=9") == 200);
  CHECK(window.shows(3, 7, 9));
  const auto state_of = [](const std::string& status) {
    const std::size_t port = status.find("\"by hand\"");
    const std::size_t state = status.find("\"state\":\"", port);
    return port == std::string::npos ? "" : status.substr(state + 9, status.find('"', state + 9) - state - 9);
  };
  const auto seen = [&] {  // in each status from the first one that has it on
    const PumpStatus status = window.layer->shown()->status();
    for (const PortStatus& port : status.ports) {
      if (port.name != "by hand") continue;
      CHECK(port.state == PortState::kWorking);
      return true;
    }
    return false;
  };
  CHECK(eventually(seen));
  CHECK(eventually([&] { return state_of(window.page("/status")) == "working"; }));
  CHECK(window.post("set\n3.8=0") == 200);
  CHECK(window.post("release\n3.7-8") == 200);
  window.layer->command(HandAction::kReleaseAll);
  for (int i = 0; i < 100; ++i) CHECK(state_of(window.page("/status")) == "working");
}

TEST_CASE("a log counts as a sender of priority 100: below it a slot that is set loses, at it the higher level wins") {
  WindowOf window;
  CHECK(window.post("set\npriority 99\n1.1=200") == 200);
  CHECK(window.post("set\npriority 100\n1.2=200\n1.3=50") == 200);
  CHECK(window.shows(1, 2, 200));
  CHECK(window.level(1, 1) == 100);
  CHECK(window.level(1, 3) == 100);
  CHECK(window.post("set\npriority 101\n1.3=50") == 200);
  CHECK(window.shows(1, 3, 50));
}

TEST_CASE("a fade begins at the level of the log, and other pages show the levels of the log") {
  WindowOf window;
  CHECK(window.level(1, 1) == 100);
  CHECK(eventually([&] { return contains(window.page("/levels"), "\"levels\":\"6464"); }));
  CHECK(window.post("set\nover 3600000000000\n1.1=255") == 200);
  CHECK(eventually([&] { return window.level(1, 1) == 100 && window.layer->held().held_count() == 1; }));
}

TEST_CASE("a fade that begins before the first turn of the window begins at the levels of the faders") {
  WindowOf window;
  const std::vector<Universe> edited{1, 2};
  const std::vector<std::uint8_t> base(edited.size() * kSlotCountMax, 100);
  CHECK(window.layer->rest_on("faders", edited, base).has_value());
  CHECK(window.post("set\nover 3600000000000\n1.1=255") == 200);
  std::vector<std::uint8_t> levels = base;
  CHECK(eventually([&] {
    levels = base;
    window.layer->follow(edited, levels);
    window.layer->overlay(edited, levels);
    return window.layer->held().held_count() == 1;
  }));
  CHECK(levels[0] == 100);
}

TEST_CASE("a panel's value is over what is set by hand, and a blackout by hand is over the panel's value") {
  WindowOf window;
  CHECK(window.post("set\n1.6=9\n1.7=9") == 200);
  CHECK(window.shows(1, 7, 9));
  CHECK(window.level(1, 6) == 77);
  CHECK(window.post("blackout") == 200);
  CHECK(window.shows(1, 6, 0));
  CHECK(window.level(3, 100) == 0);
  CHECK(window.layer->held().dark());
  window.layer->command(HandAction::kLift);
  CHECK(window.shows(1, 6, 77));
  CHECK(window.level(1, 7) == 9);
  CHECK(window.level(3, 100) == 100);
  window.layer->command(HandAction::kReleaseAll);
  CHECK(window.shows(1, 7, 100));
}

TEST_CASE("with live inputs the hand is a sender in their merge, and what it holds stays when they come and go") {
  WindowOf window;
  CHECK(window.post("set\n1.1=9") == 200);
  CHECK(window.shows(1, 1, 9));
  auto live = window.inputs();
  window.layer->join(*live);
  const auto merged = [&](std::size_t slot) {
    window.level(1, 1);
    live->take();
    return static_cast<int>(live->levels()[slot]);
  };
  CHECK(eventually([&] { return merged(0) == 9 && merged(1) == 255; }));
  CHECK(!window.layer->overlays());  // the merge has it
  CHECK(window.level(1, 1) == 100);
  CHECK(window.post("set\n1.2=8") == 200);
  CHECK(eventually([&] { return merged(1) == 8; }));
  CHECK(window.post("blackout") == 200);
  CHECK(eventually([&] { return merged(2) == 0 && window.level(1, 6) == 0; }));
  CHECK(window.post("blackout-off") == 200);
  CHECK(eventually([&] { return merged(2) == 255; }));
  window.layer->leave();
  CHECK(window.post("set\n1.3=7") == 503);
  live.reset();
  CHECK(window.layer->rest_on("faders", kRig).has_value());
  CHECK(window.shows(1, 1, 9));
  CHECK(window.level(1, 2) == 8);
  CHECK(window.level(1, 3) == 100);
}

TEST_CASE("what is set stays in the universes that an edit of the rig leaves, and is refused in others") {
  WindowOf window;
  CHECK(window.post("set\n1.1=9\n3.1=8") == 200);
  CHECK(window.shows(3, 1, 8));
  const std::vector<Universe> edited{1, 2};
  CHECK(window.layer->rest_on("faders", edited).has_value());
  std::vector<std::uint8_t> levels;
  CHECK(eventually([&] {
    levels.assign(edited.size() * kSlotCountMax, 100);
    window.layer->follow(edited, levels);
    window.layer->overlay(edited, levels);
    return levels[0] == 9 && window.layer->held().held_count() == 1;
  }));
  CHECK(levels[kSlotCountMax] == 100);
  CHECK(window.post("set\n3.1=8") == 422);
  CHECK(window.post("set\n2.1=8") == 200);
  CHECK(window.layer->rest_on("faders", {}).has_value());  // a rig without an address
  CHECK(window.post("set\n1.1=8") == 503);
}

TEST_CASE("a control sets levels over a log, over live inputs and over a log again") {
  WindowOf window;
  PortOpener opener(window.clock);
  opener.hand_link = window.layer->link();
  auto port = opener.open_source(*parse_port("midi:mock=3.1"));  // its controller 7 moves by itself
  REQUIRE(port.has_value());
  window.layer->add_control(std::move(*port));
  CHECK(window.layer->shown() != nullptr);
  CHECK(eventually([&] { return window.level(3, 8) != 100; }));
  auto live = window.inputs();
  window.layer->join(*live);
  const auto moves = [&] {
    const auto slots = http_request(window.folder.file("s"), "GET", "/hand", 30 * kNsPerS)->body;
    return eventually([&] { return window.page("/hand") != slots; });
  };
  CHECK(moves());
  window.layer->leave();
  live.reset();
  CHECK(window.layer->rest_on("log:show.dmxlog", kRig).has_value());
  CHECK(moves());
  window.layer->remove_control("midi:mock=3.1");
  CHECK(window.post("release-all") == 200);
  CHECK(eventually([&] { return window.level(3, 8) == 100 && window.layer->shown() == nullptr; }));
}

TEST_CASE("a line taps the tempo beside a log: the model closes twice a second") {
  CHECK(is_control("gpio:mock/2=tempo").value());
  CHECK(!is_control("gpio:mock/2=1.25").value());
  WindowOf window;
  PortOpener opener(window.clock);
  REQUIRE(opener.tempo->set(60, 0));
  auto port = opener.open_source(*parse_port("gpio:mock/2=tempo"));
  REQUIRE(port.has_value());
  CHECK((*port)->universes().empty());
  window.layer->add_control(std::move(*port));
  CHECK(eventually([&] { return std::abs(opener.tempo->beats_a_minute() - 120) < 1; }));
  CHECK(window.level(1, 1) == 100);
}

TEST_CASE("a second window on a socket that is named is refused, and a socket that is not named is another one") {
  const WindowOf window;
  SystemClock clock;
  const auto second = HandLayer::open({.socket = window.folder.file("s"), .rig = ""}, clock);
  REQUIRE(!second.has_value());
  CHECK(contains(second.error().message, "--socket"));
  CHECK(contains(second.error().message, window.folder.file("s")));
  CHECK(HandLayer::open({.socket = "none", .rig = ""}, clock).value()->socket().empty());
}

TEST_CASE("a command without --socket is for the bridge, without one for the window") {
  const TempFolder folder;
  const std::string here = folder.file("");
  setenv("XDG_RUNTIME_DIR", here.c_str(), 1);
  setenv("RUNTIME_DIRECTORY", "", 1);
  SystemClock clock;
  const auto none = find_bridge("set");
  CHECK((none || contains(none.error().message, "and no 'footlight preview'")));
  auto first = HandLayer::open({.socket = "auto", .rig = ""}, clock).value();
  CHECK(first->rest_on("faders", kRig).has_value());
  CHECK(contains(first->socket(), "footlight/preview.sock"));
  CHECK(find_bridge("set").value() == first->socket());
  CHECK(!find_bridge("reload", {}, false));
  {
    const auto second = HandLayer::open({.socket = "auto", .rig = ""}, clock).value();
    CHECK(contains(second->socket(), "footlight/preview-"));
    const auto both = find_bridge("set");
    REQUIRE(!both);
    CHECK(contains(both.error().message, "2 windows run on this machine"));
    CHECK(contains(both.error().message, "footlight set --socket " + second->socket()));
  }
  const std::string bridge = here + "/footlight/run.sock";
  const auto server = HttpServer::listen("--socket", "unix:" + bridge, [](const HttpRequest&) { return HttpAnswer{}; });
  REQUIRE(server.has_value());
  CHECK(find_bridge("set").value() == bridge);
}

}  // namespace
}  // namespace footlight::tools
