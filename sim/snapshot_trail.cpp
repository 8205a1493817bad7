#include "sim/snapshot_trail.h"

#include <algorithm>

namespace footlight {

SnapshotTrail::SnapshotTrail(const Universes& universes, std::size_t snapshots_max)
    : universes_(universes), repair_(universes.count()) {
  const auto count = static_cast<std::size_t>(universes.count());
  ring_.resize(snapshots_max > 0 ? snapshots_max : std::max<std::size_t>(1024, 8 * count));
  last_.resize(count);
  stale_.resize(count);
  repaired_ns_.resize(count, INT64_MIN);
  rounds_.resize(count);
}

Status SnapshotTrail::send(TimeNs now_ns, std::span<const FrameView> frames) {
  for (const FrameView& frame : frames) {
    const int index = universes_.index_of(frame.universe);
    if (index < 0) continue;
    const auto place = static_cast<std::size_t>(index);
    const auto slots = frame.slots.first(std::min<std::size_t>(frame.slots.size(), kSlotCountMax));
    Slots& last = last_[place];
    if (stale_[place] == 0 && std::equal(slots.begin(), slots.end(), last.begin())) continue;
    std::copy(slots.begin(), slots.end(), last.begin());
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    stale_[place] = written - read_.load(std::memory_order_acquire) >= ring_.size();
    if (stale_[place] != 0) {
      lost_.fetch_add(1, std::memory_order_release);
      continue;
    }
    LevelChange& change = ring_[written % ring_.size()];
    change.at_ns = std::min(frame.stamp_ns, now_ns);
    change.universe = index;
    change.levels = last;
    written_.store(written + 1, std::memory_order_release);
  }
  return {};
}

Result<bool> SnapshotTrail::next(LevelChange& change) {
  while (true) {
    const std::uint64_t read = read_.load(std::memory_order_relaxed);
    if (repair_ < universes_.count()) {
      FrameStamp stamp;
      universes_.snapshot(repair_, change.levels, stamp);
      change.at_ns = stamp.stamp_ns;
      change.universe = repair_++;
      if (stamp.revision == 0) continue;
      repaired_ns_[static_cast<std::size_t>(change.universe)] = stamp.stamp_ns;
    } else if (read != written_.load(std::memory_order_acquire)) {
      change = ring_[read % ring_.size()];
      read_.store(read + 1, std::memory_order_release);
      if (change.at_ns < repaired_ns_[static_cast<std::size_t>(change.universe)]) continue;
    } else {
      const std::uint64_t lost = lost_.load(std::memory_order_acquire);
      if (lost == lost_seen_) return false;
      lost_seen_ = lost;
      repair_ = 0;
      continue;
    }
    std::uint64_t& changed_in = rounds_[static_cast<std::size_t>(change.universe)];
    const bool together = changed_in != round_ && change.at_ns >= round_ns_ && change.at_ns - round_ns_ < kTogetherNs;
    if (together) {
      change.at_ns = round_ns_;
    } else {
      ++round_;
      round_ns_ = change.at_ns;
    }
    changed_in = round_;
    return true;
  }
}

}  // namespace footlight
