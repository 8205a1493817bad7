#include "sim/universes.h"

#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <cstring>
#include <latch>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

using namespace footlight;

namespace {

Slots filled(std::uint8_t level) {
  Slots slots;
  slots.fill(level);
  return slots;
}

FrameView frame_of(std::span<const std::uint8_t> slots, TimeNs stamp_ns = 1) {
  FrameView frame;
  frame.stamp_ns = stamp_ns;
  frame.slots = slots;
  return frame;
}

}  // namespace

TEST_CASE("by default the buffer has universes 1 to 9") {
  const Universes universes;
  REQUIRE(universes.count() == 9);
  for (int i = 0; i < 9; ++i) CHECK(universes.index_of(i + 1) == i);
  CHECK(universes.index_of(0) == -1);
  CHECK(universes.index_of(10) == -1);
  CHECK(universes.index_of(-3) == -1);
}

TEST_CASE("any set of universe numbers has an index each, and every other number has none") {
  const std::vector<Universe> numbers = {63'999, 1, 7, 8, 300, 7};
  const Universes universes(numbers);
  CHECK(std::vector<Universe>(universes.numbers().begin(), universes.numbers().end()) ==
        std::vector<Universe>{1, 7, 8, 300, 63'999});
  int found = 0;
  for (Universe universe = -2; universe <= 64'010; ++universe) {
    const int index = universes.index_of(universe);
    if (index < 0) continue;
    ++found;
    CHECK(universes.numbers()[static_cast<std::size_t>(index)] == universe);
  }
  CHECK(found == 5);
}

TEST_CASE("the error for an invalid universe number names it") {
  for (const Universe wrong : {0, -1, 64'000}) {
    const std::array<Universe, 2> numbers = {1, wrong};
    const auto made = Universes::make(numbers);
    REQUIRE_FALSE(made);
    CHECK(made.error().code == ErrorCode::kBadInput);
    CHECK(made.error().message.find("universe " + std::to_string(wrong) + ":") != std::string::npos);
  }
  CHECK_FALSE(Universes::make({}));
  CHECK(Universes::make(universe_range(1, 63'999)));
}

TEST_CASE("a snapshot returns the levels and the stamp of the newest write") {
  Universes universes(universe_range(5, 3));
  std::array<std::uint8_t, kSlotCountMax> levels = filled(99);
  FrameStamp stamp;
  universes.snapshot(1, levels, stamp);
  CHECK(levels == filled(0));
  CHECK(stamp.revision == 0);

  Slots slots;
  std::iota(slots.begin(), slots.end(), std::uint8_t{0});
  FrameView frame = frame_of(slots, 123);
  frame.sender = 0xFFFF'FFFF'FFFF'FFFEu;
  frame.sequence = 0xFFFF'FFFFu;
  universes.write(1, frame);
  universes.snapshot(1, levels, stamp);
  CHECK(levels == slots);
  CHECK(stamp.stamp_ns == 123);
  CHECK(stamp.sender == 0xFFFF'FFFF'FFFF'FFFEu);
  CHECK(stamp.sequence == 0xFFFF'FFFFu);
  CHECK(stamp.revision == 1);
  universes.snapshot(0, levels, stamp);  // the neighbours are unchanged
  CHECK(levels == filled(0));
  universes.snapshot(2, levels, stamp);
  CHECK(levels == filled(0));
}

TEST_CASE("slots past the end of a frame of any length stay as they are") {
  Universes universes;
  std::array<std::uint8_t, kSlotCountMax> levels;
  FrameStamp stamp;
  for (std::size_t size = 0; size <= kSlotCountMax; ++size) {
    const Slots before = filled(200), after = filled(17);
    universes.write(3, frame_of(before));
    universes.write(3, frame_of(std::span(after).first(size)));
    universes.snapshot(3, levels, stamp);
    Slots expected = before;
    std::fill_n(expected.begin(), size, std::uint8_t{17});
    REQUIRE(levels == expected);
  }
}

TEST_CASE("snapshot_changed copies exactly the universes written since, and ends equal to snapshot_all") {
  Universes universes(universe_range(1, 20));
  std::vector<std::uint8_t> levels(20 * kSlotCountMax), all(20 * kSlotCountMax);
  std::vector<FrameStamp> stamps(20), all_stamps(20);
  CHECK(universes.snapshot_changed(levels, stamps) == 0);
  const std::uint64_t revision = universes.revision();
  for (const int index : {3, 11, 11, 19})
    universes.write(index, frame_of(filled(static_cast<std::uint8_t>(index + 1))));
  CHECK(universes.revision() == revision + 4);
  CHECK(universes.snapshot_changed(levels, stamps) == 3);
  CHECK(universes.snapshot_changed(levels, stamps) == 0);
  universes.snapshot_all(all, all_stamps);
  CHECK(levels == all);
  CHECK(stamps[11].revision == 2);
  CHECK(all_stamps[11].revision == 2);
}

// Every write fills a universe with one level and uses the same number for stamp, sender and sequence, so that a torn
// copy is detected. Bounded by the number of writes; nothing depends on the threads' speed.
TEST_CASE("no snapshot under concurrent writes mixes two writes") {
  constexpr int kUniverses = 4;
  constexpr std::uint32_t kWrites = 400'000;
  constexpr int kReaders = 3;
  std::latch everybody(kReaders + 2);  // else the writers would be done before a reader runs
  Universes universes(universe_range(1, kUniverses));
  std::atomic<int> writers_left{2};

  // Two writers with two universes each: one writer per universe.
  const auto write = [&](int first) {
    everybody.arrive_and_wait();
    for (std::uint32_t n = 1; n <= kWrites; ++n)
      for (int index = first; index < first + 2; ++index) {
        const Slots slots = filled(static_cast<std::uint8_t>(n));
        FrameView frame = frame_of(slots, n);
        frame.sender = n;
        frame.sequence = n;
        universes.write(index, frame);
      }
    --writers_left;
  };

  std::array<std::uint64_t, kReaders> torn{}, backwards{}, seen{};
  const auto read = [&](std::size_t reader) {
    std::vector<std::uint8_t> levels(kUniverses * kSlotCountMax);
    std::vector<FrameStamp> stamps(kUniverses), before(kUniverses);
    everybody.arrive_and_wait();
    bool last_round = false;
    while (!last_round) {
      last_round = writers_left.load() == 0;  // one more round after the last write
      switch (reader) {
        case 0: universes.snapshot_all(levels, stamps); break;
        case 1: universes.snapshot_changed(levels, stamps); break;
        default:
          for (int i = 0; i < kUniverses; ++i)
            universes.snapshot(i,
                               std::span<std::uint8_t, kSlotCountMax>(levels.data() + i * kSlotCountMax, kSlotCountMax),
                               stamps[static_cast<std::size_t>(i)]);
      }
      for (std::size_t i = 0; i < kUniverses; ++i) {
        const FrameStamp& stamp = stamps[i];
        bool whole =
            stamp.stamp_ns == stamp.revision && stamp.sender == stamp.revision && stamp.sequence == stamp.revision;
        const std::uint8_t* const first = levels.data() + i * kSlotCountMax;
        whole = whole && *first == static_cast<std::uint8_t>(stamp.revision);
        whole = whole && std::memcmp(first, first + 1, kSlotCountMax - 1) == 0;  // all alike
        torn[reader] += whole ? 0u : 1u;
        backwards[reader] += stamp.revision < before[i].revision ? 1u : 0u;
        before[i] = stamp;
        ++seen[reader];
      }
    }
    for (const FrameStamp& stamp : stamps)
      backwards[reader] += stamp.revision == kWrites ? 0u : 1u;  // the last write is read
  };

  {
    std::vector<std::jthread> threads;
    for (std::size_t reader = 0; reader < kReaders; ++reader) threads.emplace_back(read, reader);
    threads.emplace_back(write, 0);
    threads.emplace_back(write, 2);
  }
  for (std::size_t reader = 0; reader < kReaders; ++reader) {
    CHECK(torn[reader] == 0);
    CHECK(backwards[reader] == 0);
    CHECK(seen[reader] > 0);
  }
  CHECK(universes.revision() == 4u * kWrites);
}

TEST_CASE("a reader that finds the revision unchanged has missed no write") {
  Universes universes;
  constexpr std::uint32_t kWrites = 20'000;
  std::atomic<bool> done{false};
  std::uint64_t missed = 0;
  std::jthread writer([&] {
    const Slots slots = filled(1);
    for (std::uint32_t n = 1; n <= kWrites; ++n) {
      FrameView frame = frame_of(slots, n);
      universes.write(0, frame);
    }
    done = true;
  });
  std::array<std::uint8_t, kSlotCountMax> levels;
  FrameStamp stamp, again;
  for (bool last_round = false; !last_round;) {
    last_round = done.load();
    const std::uint64_t before = universes.revision();
    universes.snapshot(0, levels, stamp);
    if (stamp.revision < before) ++missed;  // revision() counts finished writes, so the snapshot has at least those
    if (last_round) {
      universes.snapshot(0, levels, again);
      CHECK(again.revision == stamp.revision);
      CHECK(universes.revision() == before);
    }
  }
  CHECK(missed == 0);
}
