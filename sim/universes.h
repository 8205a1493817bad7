// The level buffer: N universes of 512 levels, each with the stamp of its newest frame.
//
// The pump writes levels here; sinks, pictures and status output read them. The levels lie in one flat array of N x 512
// bytes, in the order of numbers(); nine universes are 4,608 bytes. Any set of universe numbers is allowed.
//
// Threads: one writer per universe (different universes may have different writers), any number of readers, no lock. A
// reader gets the levels and the stamp of the same write. Each universe is a sequence lock: the writer never waits; a
// reader that meets a write in progress reads that universe again. If the writer was stopped in the middle of a write
// (the reader outranks it on the same core), the reader sleeps 50 us between tries, so that the writer can finish.
// Consistency holds within one universe: snapshot_all() may return universe 1 from before and universe 2 from after a
// write.
//
// Cost: see docs/decisions/0010-buffer-and-pump.md for measured figures; tests/bench/universes_bench.cpp measures them.
// Only the constructor allocates.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight {

// `count` universe numbers: first, first + 1, ...
[[nodiscard]] std::vector<Universe> universe_range(Universe first, int count);

class Universes {
 public:
  // Universes 1 to 9.
  Universes();
  // Any set of numbers from 1 to 63999, in any order, repeats allowed; kept sorted, each once. Aborts if a number is no
  // universe or the set is empty. Use make() for numbers that a user typed.
  explicit Universes(std::span<const Universe> numbers);
  // As the constructor. kBadInput names the number that is no universe.
  [[nodiscard]] static Result<std::unique_ptr<Universes>> make(std::span<const Universe> numbers);

  Universes(const Universes&) = delete;
  Universes& operator=(const Universes&) = delete;

  [[nodiscard]] int count() const { return static_cast<int>(numbers_.size()); }
  // Sorted; index i of every call below is numbers()[i].
  [[nodiscard]] std::span<const Universe> numbers() const { return numbers_; }
  // -1: not in the buffer. Constant time if the numbers are consecutive, else a binary search.
  [[nodiscard]] int index_of(Universe universe) const;

  // Stores the frame's slots, stamp, sender and sequence; slots past the end of the frame stay as they are. Ignores its
  // universe, priority and terminated fields. Only the writer of this universe may call it. Never waits.
  void write(int index, const FrameView& frame);

  // Levels and stamp of the newest write, from the same write.
  void snapshot(int index, std::span<std::uint8_t, kSlotCountMax> levels, FrameStamp& stamp) const;
  // Every universe: `levels` holds count() x 512 bytes, `stamps` holds count().
  void snapshot_all(std::span<std::uint8_t> levels, std::span<FrameStamp> stamps) const;
  // As snapshot_all(), into buffers that an earlier call has filled (zeros and default stamps at first). Copies only
  // universes written since and returns their number. For a reader that runs once a picture.
  int snapshot_changed(std::span<std::uint8_t> levels, std::span<FrameStamp> stamps) const;

  // Increases with every write of any universe. If it is unchanged since before the reader's last snapshot, the reader
  // has missed nothing. One atomic load.
  [[nodiscard]] std::uint64_t revision() const { return revision_.load(std::memory_order_acquire); }

 private:
  static constexpr int kWordsPerUniverse = kSlotCountMax / 8;

  // One cache line each, so that writers of two universes do not share one.
  struct alignas(64) Head {
    std::atomic<std::uint64_t> lock{0};  // odd while a write is in progress
    std::atomic<std::int64_t> stamp_ns{0};
    std::atomic<std::uint64_t> sender{0};
    std::atomic<std::uint32_t> sequence{0};
    std::atomic<std::uint32_t> revision{0};
  };

  void read(int index, std::uint8_t* levels, FrameStamp& stamp) const;

  std::vector<Universe> numbers_;
  std::unique_ptr<Head[]> heads_;
  std::unique_ptr<std::atomic<std::uint64_t>[]> words_;  // count() x 64
  std::atomic<std::uint64_t> revision_{0};
};

}  // namespace footlight
