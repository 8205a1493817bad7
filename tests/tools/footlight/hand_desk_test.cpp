// The hand of a bridge in this process: what is remembered of a blackout, whatever happens at the same time.
#include "tools/footlight/hand/hand_desk.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/fake_ports.h"
#include "tests/support/temp_folder.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using testing::FakeClock;
using testing::FakeWaiter;
using testing::TempFolder;

// A pump whose thread is that of the test, and a desk. The desk ends what it began when it is destroyed.
struct Bridge {
  explicit Bridge(const std::string& memory) {
    desk = std::make_unique<HandDesk>(pump, clock, [this](const Notice& notice) {
      const std::lock_guard lock(mutex);
      notices.emplace_back(notice.text);
    });
    starts_dark = desk->remember_in(memory);
    pump.start();
  }
  ~Bridge() { end(); }
  void end() {
    if (desk == nullptr) return;
    pump.stop();
    desk.reset();
  }
  void take(HandAction action, DurationNs over_ns = 0) {
    CHECK(desk->take({.action = action, .over_ns = over_ns, .levels = {}}, clock.now_ns()).has_value());
    waiter.interrupt();
    pump.step();
  }

  FakeClock clock;
  FakeWaiter waiter{clock};
  std::shared_ptr<Universes> universes = std::make_shared<Universes>();
  Pump pump{universes, clock, waiter};
  std::mutex mutex;
  std::vector<std::string> notices;
  std::unique_ptr<HandDesk> desk;
  bool starts_dark = false;
};

TEST_CASE("a blackout is remembered while many scenes wait to be read") {
  const TempFolder folder;
  const std::string memory = folder.file("s.blackout");
  Bridge bridge(memory);
  bridge.take(HandAction::kReleaseAll);
  for (int i = 0; i < 200; ++i) bridge.desk->recall({.name = "x", .file = folder.file("none"), .rig = ""});
  bridge.take(HandAction::kBlackout);
  for (int i = 0; i < 200; ++i) bridge.desk->recall({.name = "x", .file = folder.file("none"), .rig = ""});
  bridge.end();
  CHECK(fs::exists(memory));
  CHECK((fs::status(memory).permissions() & fs::perms::mask) == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("what is remembered is the last state, however often it changed") {
  const TempFolder folder;
  const std::string memory = folder.file("s.blackout");
  for (const bool dark : {false, true}) {
    Bridge bridge(memory);
    for (int i = 0; i < 50; ++i) {
      bridge.take(HandAction::kBlackout);
      bridge.take(HandAction::kLift);
    }
    if (dark) bridge.take(HandAction::kHold, kNsPerS);
    bridge.end();
    CHECK(fs::exists(memory) == dark);
  }
  const Bridge again(memory);
  CHECK(again.starts_dark);
  CHECK(again.desk->blacked_out());
}

TEST_CASE("remembering a blackout does not write through a link") {
  const TempFolder folder;
  const std::string memory = folder.file("s.blackout"), other = folder.file("other");
  std::ofstream(other) << "keep";
  Bridge bridge(memory);
  fs::create_symlink(other, memory);  // after the start: a bridge that finds a link starts dark
  bridge.take(HandAction::kBlackout);
  bridge.end();
  std::ifstream file(other);
  CHECK(std::string(std::istreambuf_iterator<char>(file), {}) == "keep");
  REQUIRE(bridge.notices.size() == 1);
  CHECK(bridge.notices[0].find("cannot be written") != std::string::npos);
}

TEST_CASE("taps of a control and of a command are those of one tempo, and need no pump") {
  Bridge bridge("");
  const auto tempo = std::make_shared<Tempo>();
  bridge.desk->share_tempo(tempo);
  bridge.clock.advance_ns(9 * kNsPerS);
  CHECK(bridge.desk->apply({.action = HandAction::kTempo, .levels = {}}).has_value());
  CHECK(bridge.desk->take({.action = HandAction::kTempo, .levels = {}}, 10'600 * kNsPerMs).has_value());
  CHECK(tempo->beats_a_minute() == doctest::Approx(100));
  CHECK(bridge.desk->apply({.action = HandAction::kTempo, .levels = {}, .beats_a_minute = 90}).has_value());
  CHECK(tempo->beats_a_minute() == doctest::Approx(90));
  CHECK(!bridge.desk->apply({.action = HandAction::kTempo, .levels = {}, .beats_a_minute = 500}).has_value());
  CHECK(tempo->beats_a_minute() == doctest::Approx(90));
}

}  // namespace
}  // namespace footlight::tools
