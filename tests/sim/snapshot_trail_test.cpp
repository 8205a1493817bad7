// Snapshots on their way from a pump to pictures, with their times.
#include "sim/snapshot_trail.h"

#include <array>
#include <atomic>
#include <random>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "sim/pump.h"
#include "tests/support/fake_clock.h"
#include "tests/support/fake_ports.h"

namespace footlight {
namespace {

using testing::FakeClock;
using testing::FakeSource;
using testing::FakeWaiter;

// A buffer and its trail, written like by a pump.
struct Bed {
  explicit Bed(std::vector<Universe> numbers, std::size_t snapshots_max = 0)
      : universes(numbers), trail(universes, snapshots_max) {}

  void snapshot(Universe universe, std::uint8_t level, TimeNs stamp_ns, TimeNs now_ns = kTimeNever) {
    Slots slots;
    slots.fill(level);
    FrameView frame;
    frame.universe = universe;
    frame.stamp_ns = stamp_ns;
    frame.slots = slots;
    universes.write(universes.index_of(universe), frame);
    REQUIRE(trail.send(now_ns, {&frame, 1}));
  }
  struct Seen {
    TimeNs at_ns;
    int universe;
    int level;
    bool operator==(const Seen&) const = default;
  };
  std::vector<Seen> read() {
    std::vector<Seen> seen;
    LevelChange change;
    while (trail.next(change).value()) {
      CHECK(change.levels[0] == change.levels[511]);
      seen.push_back({change.at_ns, change.universe, change.levels[0]});
    }
    return seen;
  }

  Universes universes;
  SnapshotTrail trail;
};

using Seen = Bed::Seen;

TEST_SUITE_BEGIN("snapshot trail");

TEST_CASE("a snapshot takes effect at its stamp, one from the future at its arrival, and a repeat is not a change") {
  Bed bed({4, 9});
  CHECK(bed.read().empty());
  bed.snapshot(9, 10, 1'000'000, 1'200'000);
  bed.snapshot(9, 10, 2'000'000, 2'000'100);
  bed.snapshot(9, 11, 9'000'000, 3'000'000);
  CHECK(bed.read() == std::vector<Seen>{{1'000'000, 1, 10}, {3'000'000, 1, 11}});
  CHECK(bed.read().empty());
}

TEST_CASE("universes of one round change together, and a flash within it keeps its end") {
  Bed bed({1, 2, 3});
  bed.snapshot(1, 1, 10'000'000);
  bed.snapshot(2, 2, 10'100'000);
  bed.snapshot(3, 3, 10'499'999);  // still of that round
  bed.snapshot(1, 9, 10'499'999);  // again: its own time
  bed.snapshot(2, 8, 10'500'000);  // with that one
  bed.snapshot(3, 7, 10'999'999);  // half a millisecond later: its own time
  CHECK(bed.read() == std::vector<Seen>{{10'000'000, 0, 1},
                                        {10'000'000, 1, 2},
                                        {10'000'000, 2, 3},
                                        {10'499'999, 0, 9},
                                        {10'499'999, 1, 8},
                                        {10'999'999, 2, 7}});
}

TEST_CASE("a reader that paused gets the newest snapshot of every universe and never an older one after it") {
  std::mt19937 random(7);
  for (const int snapshots_max : {1, 2, 5, 16}) {
    CAPTURE(snapshots_max);
    Bed bed({1, 2, 3}, static_cast<std::size_t>(snapshots_max));
    std::array<int, 3> newest{};  // the levels grow, so an older snapshot has a lower level
    std::array<int, 3> shown{};
    TimeNs now_ns = 0;
    for (int round = 0; round < 60; ++round) {
      for (auto count = random() % 9; count > 0; --count) {
        const auto place = random() % 3;
        now_ns += static_cast<TimeNs>(random() % 2'000'000);
        if (random() % 3 != 0) ++newest[place];
        bed.snapshot(static_cast<Universe>(place + 1), static_cast<std::uint8_t>(newest[place]), now_ns);
      }
      if (random() % 3 == 0) continue;
      for (const Seen& seen : bed.read()) {
        int& level = shown[static_cast<std::size_t>(seen.universe)];
        CHECK(seen.level >= level);
        level = seen.level;
      }
      CHECK(shown == newest);
    }
    CHECK((snapshots_max > 8 || bed.trail.lost() > 0));
  }
}

TEST_CASE("a snapshot equal to the last one that was not lost is still delivered") {
  Bed bed({1}, 1);
  bed.snapshot(1, 5, 1);  // waits
  bed.snapshot(1, 6, 2);  // lost
  CHECK(bed.read() == std::vector<Seen>{{1, 0, 5}, {2, 0, 6}});
  bed.snapshot(1, 5, 3'000'000);
  CHECK(bed.read() == std::vector<Seen>{{3'000'000, 0, 5}});
}

TEST_CASE("a pump sends a trail each frame of a burst with its own stamp") {
  FakeClock clock;
  FakeWaiter waiter(clock);
  Universes universes(std::array<Universe, 2>{1, 2});
  Pump pump(universes, clock, waiter);
  FakeSource desk(waiter, "desk", {1, 2});
  SnapshotTrail trail(universes);
  pump.add_source(desk);
  pump.add_sink(trail);
  pump.start();
  const TimeNs begin_ns = clock.now_ns();
  clock.advance_ns(20'000'000);
  desk.give(1, 255, kPriorityDefault, begin_ns + 3'000'000);
  desk.give(1, 0, kPriorityDefault, begin_ns + 4'000'000);
  desk.give(1, 128, kPriorityDefault, begin_ns + 9'000'000);
  REQUIRE(pump.step());
  std::vector<TimeNs> at_ns;
  std::vector<int> levels;
  LevelChange change;
  while (trail.next(change).value()) {
    at_ns.push_back(change.at_ns - begin_ns);
    levels.push_back(change.levels[0]);
  }
  CHECK(at_ns == std::vector<TimeNs>{3'000'000, 4'000'000, 9'000'000});
  CHECK(levels == std::vector<int>{255, 0, 128});
  pump.stop();
}

TEST_CASE("a concurrent reader reads only increasing levels of each universe, and its last snapshot in the end") {
  Bed bed({1, 2}, 8);
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (int i = 1; i <= 20'000; ++i) {
      // The low byte alone would wrap: only both slots together increase.
      Slots slots{};
      slots[0] = static_cast<std::uint8_t>(i >> 8);
      slots[1] = static_cast<std::uint8_t>(i);
      FrameView frame;
      frame.universe = static_cast<Universe>(1 + i % 2);
      frame.stamp_ns = i;
      frame.slots = slots;
      bed.universes.write(i % 2, frame);
      (void)bed.trail.send(i, {&frame, 1});
    }
    done = true;
  });
  std::array<int, 2> shown{};
  int backward = 0;
  const auto read = [&] {
    LevelChange change;
    while (bed.trail.next(change).value()) {
      int& last = shown[static_cast<std::size_t>(change.universe)];
      const int level = change.levels[0] << 8 | change.levels[1];
      backward += level < last;
      last = level;
    }
  };
  while (!done) read();
  writer.join();
  read();
  CHECK(backward == 0);
  CHECK(shown == std::array<int, 2>{20'000, 19'999});
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight
