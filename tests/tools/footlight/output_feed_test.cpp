// The levels of the picture on their way to real lamps, with a clock that is moved.
#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "sim/pump.h"
#include "sim/universes.h"
#include "tests/support/fake_clock.h"
#include "tests/support/fake_ports.h"
#include "tools/footlight/preview/output_feed.h"

namespace footlight::tools {
namespace {

using footlight::testing::FakeClock;
using footlight::testing::FakeSink;
using footlight::testing::FakeWaiter;

// A rig with universes 1 to 3, of which real lamps have 1 and 2, and an output that carries all of them.
struct Lamps {
  explicit Lamps(double rate_hz_max = 0) : sink(waiter, "lamps", {1, 2, 3}, rate_hz_max) {
    pump.add_source(feed);
    pump.add_sink(sink);
    pump.start();
  }
  ~Lamps() { pump.stop(); }

  void give(std::uint8_t first, std::uint8_t second, std::vector<Universe> sendable = {1, 2}) {
    std::vector<std::uint8_t> levels(3 * kSlotCountMax, 99);  // 99: of the made-up universe
    std::fill_n(levels.begin(), kSlotCountMax, first);
    std::fill_n(levels.begin() + kSlotCountMax, kSlotCountMax, second);
    feed.give(clock.now_ns(), rig, levels, sendable);
  }
  void run_for(DurationNs time_ns) {
    const TimeNs end_ns = clock.now_ns() + time_ns;
    waiter.at(end_ns, [this] { waiter.interrupt(); });
    while (clock.now_ns() < end_ns) pump.step();
  }
  // What the lamps of a universe got last; -1: nothing yet.
  int level(Universe universe) const {
    int last = -1;
    for (const FakeSink::Sent& sent : sink.sent) {
      for (std::size_t i = 0; i < sent.universes.size(); ++i) {
        if (sent.universes[i] == universe) last = sent.levels[i];
      }
    }
    return last;
  }

  FakeClock clock;
  FakeWaiter waiter{clock};
  std::array<Universe, 3> rig{1, 2, 3};
  Universes universes{rig};
  OutputFeed feed{rig};
  FakeSink sink;
  Pump pump{universes, clock, waiter};
};

TEST_CASE("no level of the picture goes on before an output is armed") {
  Lamps lamps;
  for (int i = 0; i < 10; ++i) {
    lamps.give(200, 100);
    lamps.run_for(100 * kNsPerMs);
  }
  CHECK(lamps.sink.sent.empty());
  lamps.feed.count_armed(1);
  lamps.run_for(kNsPerMs);
  CHECK(lamps.level(1) == 200);
  CHECK(lamps.level(2) == 100);
  lamps.feed.count_armed(-1);
  const std::size_t sent = lamps.sink.sent.size();
  lamps.give(1, 1);
  lamps.run_for(kNsPerS);
  CHECK(lamps.sink.sent.size() == sent);
}

TEST_CASE("levels go on 44 times a second however long a picture takes") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.give(10, 20);
  lamps.run_for(2 * kNsPerS);  // one picture
  CHECK(lamps.sink.sent.size() >= 87);
  CHECK(lamps.sink.sent.size() <= 89);
  lamps.give(11, 20);
  lamps.run_for(kNsPerS / OutputFeed::kOutputRateHz);
  CHECK(lamps.level(1) == 11);
}

TEST_CASE("universes without an address of the rig are never sent, and one that loses its addresses gets zeros") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.give(10, 20);
  lamps.run_for(100 * kNsPerMs);
  CHECK(lamps.level(3) == -1);
  lamps.give(10, 20, {1});
  lamps.run_for(100 * kNsPerMs);
  CHECK(lamps.level(1) == 10);
  CHECK(lamps.level(2) == 0);
  CHECK(lamps.level(3) == -1);
  lamps.feed.black_out();
  lamps.run_for(100 * kNsPerMs);
  CHECK(lamps.level(3) == -1);
}

TEST_CASE("with a dead man's switch lamps are lit only while the key is held") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  // Turns of 16 ms, in which the key is held or not.
  const auto turns = [&](int count, bool held) {
    for (int i = 0; i < count; ++i) {
      lamps.give(200, 100);
      lamps.feed.hold(lamps.clock.now_ns(), held);
      lamps.run_for(16 * kNsPerMs);
    }
  };
  turns(5, true);
  CHECK(lamps.level(1) == 200);  // it is not asked for
  lamps.feed.need_hold(true);
  CHECK(lamps.feed.darkness() == Darkness::kNotHeld);
  turns(5, true);  // since before it was asked for: somebody may have left something on the key
  CHECK(lamps.level(1) == 0);
  turns(5, false);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.level(2) == 0);
  turns(5, true);
  CHECK(lamps.level(1) == 200);
  CHECK(lamps.level(2) == 100);
  CHECK(lamps.feed.darkness() == Darkness::kNone);
  turns(2, false);
  CHECK(lamps.level(1) == 0);
  turns(2, true);
  CHECK(lamps.level(1) == 200);
  // A blackout is above the key.
  lamps.feed.black_out();
  turns(5, true);
  CHECK(lamps.level(1) == 0);
  lamps.feed.lift(lamps.clock.now_ns());
  turns(5, true);
  CHECK(lamps.level(1) == 200);
}

TEST_CASE("a window that hangs with its key held darkens lamps after half a second, until the key is pressed anew") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.feed.need_hold(true);
  lamps.give(200, 100);
  lamps.feed.hold(lamps.clock.now_ns(), false);
  lamps.feed.hold(lamps.clock.now_ns(), true);
  lamps.run_for(OutputFeed::kHeldMaxNs - 50 * kNsPerMs);
  CHECK(lamps.level(1) == 200);
  lamps.run_for(100 * kNsPerMs);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.feed.darkness() == Darkness::kNotHeld);
  for (int i = 0; i < 20; ++i) {
    lamps.give(200, 100);
    lamps.feed.hold(lamps.clock.now_ns(), true);
    lamps.run_for(16 * kNsPerMs);
  }
  CHECK(lamps.level(1) == 0);
  lamps.feed.hold(lamps.clock.now_ns(), false);
  lamps.feed.hold(lamps.clock.now_ns(), true);
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 200);
}

TEST_CASE("a dead man's switch that is left without its key held leaves a blackout, and with it lamps that are lit") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.feed.need_hold(true);
  lamps.give(200, 100);
  lamps.feed.need_hold(false);
  CHECK(lamps.feed.darkness() == Darkness::kAsked);
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 0);
  lamps.feed.lift(lamps.clock.now_ns());
  lamps.feed.need_hold(true);
  lamps.feed.hold(lamps.clock.now_ns(), false);
  lamps.feed.hold(lamps.clock.now_ns(), true);
  lamps.feed.need_hold(false);
  CHECK(lamps.feed.darkness() == Darkness::kNone);
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 200);
}

TEST_CASE("levels that are missing change nothing") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.give(10, 20);
  const std::array<Universe, 2> sendable{1, 2};
  lamps.feed.give(lamps.clock.now_ns(), lamps.rig, {}, sendable);
  lamps.feed.give(lamps.clock.now_ns(), {}, {}, sendable);
  lamps.run_for(100 * kNsPerMs);
  CHECK(lamps.level(1) == 10);
  CHECK(lamps.level(2) == 20);
}

TEST_CASE("a blackout sends zeros whatever the window gives, until it is ended") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.give(10, 20);
  lamps.run_for(100 * kNsPerMs);
  REQUIRE(lamps.level(1) == 10);
  lamps.feed.black_out();
  lamps.feed.hurry();
  lamps.run_for(kNsPerMs);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.level(2) == 0);
  for (int i = 0; i < 50; ++i) {  // what is taken over comes with these
    lamps.give(255, 255);
    lamps.run_for(20 * kNsPerMs);
    CHECK(lamps.level(1) == 0);
    CHECK(lamps.level(2) == 0);
  }
  lamps.feed.black_out();  // again: it does not end it
  lamps.run_for(kNsPerS / 20);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.feed.darkness() == Darkness::kAsked);
  lamps.feed.lift(lamps.clock.now_ns());
  lamps.run_for(kNsPerS / 20);
  CHECK(lamps.level(1) == 255);
  CHECK(lamps.feed.darkness() == Darkness::kNone);
}

TEST_CASE("lamps go dark 2.5 s after the last levels of the window and stay so until the user ends it") {
  Lamps lamps;
  lamps.feed.count_armed(1);
  lamps.give(10, 20);
  lamps.run_for(2'490 * kNsPerMs);
  CHECK(lamps.level(1) == 10);
  CHECK(lamps.feed.darkness() == Darkness::kNone);
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.level(2) == 0);
  CHECK(lamps.feed.darkness() == Darkness::kSilence);
  lamps.give(30, 40);
  lamps.run_for(kNsPerS);
  CHECK(lamps.level(1) == 0);
  lamps.feed.lift(lamps.clock.now_ns());
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 30);
}

TEST_CASE("a window that is silent while nothing is armed starts no blackout, but arming it then sends zeros") {
  Lamps lamps;
  lamps.give(10, 20);
  lamps.run_for(10 * kNsPerS);
  CHECK(lamps.feed.darkness() == Darkness::kNone);
  lamps.feed.count_armed(1);
  lamps.run_for(50 * kNsPerMs);
  CHECK(lamps.level(1) == 0);
  CHECK(lamps.feed.darkness() == Darkness::kSilence);
}

TEST_CASE("an output that is closed ends with zeros, also after levels that its rate held back") {
  FakeClock clock;
  FakeWaiter waiter(clock);
  const std::array<Universe, 1> rig{1};
  Universes universes{rig};
  OutputFeed feed(rig);
  auto owned = std::make_unique<FakeSink>(waiter, "inner", std::vector<Universe>{1}, 10.0);
  FakeSink& inner = *owned;
  const auto sink = ending_dark(std::move(owned), "lamp");
  CHECK(sink->name() == "lamp");
  Pump pump(universes, clock, waiter);
  pump.add_source(feed);
  pump.add_sink(*sink);
  pump.start();
  feed.count_armed(1);
  feed.give(clock.now_ns(), rig, std::vector<std::uint8_t>(kSlotCountMax, 200), rig);
  pump.tick(clock.now_ns());
  REQUIRE(inner.sent.size() == 1);
  clock.advance_ns(30 * kNsPerMs);
  feed.give(clock.now_ns(), rig, std::vector<std::uint8_t>(kSlotCountMax, 201), rig);
  pump.tick(clock.now_ns());
  REQUIRE(inner.sent.size() == 1);  // held back
  pump.remove_sink(*sink);
  CHECK(inner.close_count == 1);
  REQUIRE(inner.sent.size() > 4);
  for (std::size_t i = inner.sent.size() - 4; i < inner.sent.size(); ++i) CHECK(inner.sent[i].levels == std::vector{0});
  pump.stop();
}

TEST_CASE("an output that has sent nothing is closed without a frame") {
  FakeClock clock;
  FakeWaiter waiter(clock);
  auto owned = std::make_unique<FakeSink>(waiter, "inner", std::vector<Universe>{1});
  FakeSink& inner = *owned;
  const auto sink = ending_dark(std::move(owned), "lamp");
  sink->close(clock.now_ns());
  CHECK(inner.close_count == 1);
  CHECK(inner.sent.empty());
}

}  // namespace
}  // namespace footlight::tools
