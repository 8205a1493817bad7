// Passes the snapshots of a pump, with their times, to one reader that runs once a picture. A flash shorter than a
// picture, or an edge within one, is so shown for its true length.
//
// A snapshot takes effect at its frame's stamp (for a strobe input, the kernel's stamp of the edge), or when it was
// sent here if that is earlier. A change of another universe within kTogetherNs of a first one takes effect at the time
// of the first. So the universes of one round of a desk make one step, shown early by at most that much. All other
// times are exact.
//
// Threads: a sink of a pump, on its thread; next() on one other thread. Neither waits for the other. If the reader
// pauses for longer than the trail holds, it misses snapshots and then gets the newest one of every universe.
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

  // universes: those of the rig and of the pump; it outlives the trail. snapshots_max: how many snapshots wait for the
  // reader; 0: 1,024, or 8 per universe if that is more (about 0.5 KiB each).
  explicit SnapshotTrail(const Universes& universes, std::size_t snapshots_max = 0);

  // For the reader.
  Result<bool> next(LevelChange& change) override;
  // How many snapshots the reader missed.
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

  // Used by the pump's thread.
  std::vector<Slots> last_;          // of each universe, as written for the reader
  std::vector<std::uint8_t> stale_;  // a snapshot was lost, so the reader has older levels

  // Used by the reader's thread.
  std::uint64_t lost_seen_ = 0;
  int repair_;                         // the universe that is read from the buffer next; universes_.count(): none
  std::vector<TimeNs> repaired_ns_;    // of each universe: earlier snapshots are included in what was read from the
                                       // buffer
  TimeNs round_ns_ = 0;                // when the first change of this round came
  std::uint64_t round_ = 0;            // counts rounds
  std::vector<std::uint64_t> rounds_;  // of each universe: the round in which it changed last
};

}  // namespace footlight
