// The looks that a pump makes, with the times from which they hold, for one reader that comes once a picture: so that a
// flash shorter than a picture, or an edge in the midst of one, is shown as long as it was.
//
// A look counts from its frame's stamp (a strobe input's: the stamp that the kernel gave the edge), or from when it was
// handed over where the stamp lies later. A change of another universe that comes within kTogetherNs of a first one
// counts from that one's time, so that the universes of one round of a desk make one step: it is shown up to that much
// early. Everything else is exact.
//
// Threads: a sink of a pump, on its thread; next() on one other thread. Neither waits for the other. Where the reader
// stays away for longer than the trail holds, looks are lost to it; it gets the newest of every universe then.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/core/ports.h"
#include "sim/level_changes.h"
#include "sim/universes.h"

namespace footlight {

class SnapshotTrail final : public Sink, public LevelChanges {
 public:
  static constexpr DurationNs kTogetherNs = 500 * kNsPerUs;

  // universes: those of the rig and of the pump; it outlives the trail. snapshots_max: how many looks wait for the
  // reader;
  // 0: 1,024, or 8 a universe where that is more (about 0.5 KiB each).
  explicit SnapshotTrail(const Universes& universes, std::size_t snapshots_max = 0);

  // For the reader.
  Result<bool> next(LevelChange& change) override;
  // How often it came too late.
  [[nodiscard]] std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

  // For the pump.
  [[nodiscard]] std::string name() const override { return "picture"; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {}; }
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs /*now_ns*/) override { return {}; }
  [[nodiscard]] std::span<const Universe> universes() const override { return universes_.numbers(); }
  void close(TimeNs /*now_ns*/) override {}

 private:
  const Universes& universes_;
  std::vector<LevelChange> ring_;
  std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> read_{0};
  std::atomic<std::uint64_t> lost_{0};

  // The pump's.
  std::vector<Slots> last_;          // of each universe, as given to the reader
  std::vector<std::uint8_t> stale_;  // it is not what the reader has: a look was lost

  // The reader's.
  std::uint64_t lost_seen_ = 0;
  int repair_;                         // the universe that is read from the buffer next; universes_.count(): none
  std::vector<TimeNs> repaired_ns_;    // of each universe: older looks are in what was read from the buffer
  TimeNs round_ns_ = 0;                // when the first change of this round came
  std::uint64_t round_ = 0;            // counts rounds
  std::vector<std::uint64_t> rounds_;  // of each universe: the one in which it changed last
};

}  // namespace footlight
