#include "sim/merge.h"

#include <algorithm>
#include <cstring>

#include "sim/core/check.h"

namespace footlight {
namespace {

// Whole universes, so that the compiler can vectorise the loop.
void take_highest(std::uint8_t* __restrict snapshot, const std::uint8_t* __restrict levels) {
  for (int slot = 0; slot < kSlotCountMax; ++slot) snapshot[slot] = std::max(snapshot[slot], levels[slot]);
}

// As above: one more than the priority, and 0 for 0.
void rank_priorities(std::uint8_t* __restrict rank, const std::uint8_t* __restrict priorities) {
  for (int slot = 0; slot < kSlotCountMax; ++slot) {
    const std::uint8_t priority = priorities[slot];
    rank[slot] = static_cast<std::uint8_t>(priority + (priority != 0 ? 1 : 0));
  }
}

// The levels of the higher rank; of equal ranks the higher level.
void take_higher_rank(std::uint8_t* __restrict best, std::uint8_t* __restrict merged,
                      const std::uint8_t* __restrict rank, const std::uint8_t* __restrict levels) {
  for (int slot = 0; slot < kSlotCountMax; ++slot) {
    const std::uint8_t mine = rank[slot], other = best[slot], level = levels[slot], so_far = merged[slot];
    const std::uint8_t higher = level > so_far ? level : so_far;
    const std::uint8_t tied = mine == other ? higher : so_far;
    merged[slot] = mine > other ? level : tied;
    best[slot] = mine > other ? mine : other;
  }
}

bool has_best_rank(const std::uint8_t* __restrict best, const std::uint8_t* __restrict rank) {
  std::uint8_t shared = 0;
  for (int slot = 0; slot < kSlotCountMax; ++slot) {
    const std::uint8_t mine = rank[slot], other = best[slot];
    shared = static_cast<std::uint8_t>(shared | (mine == other ? mine : 0));
  }
  return shared != 0;
}

void take_ranked(std::uint8_t* __restrict snapshot, const std::uint8_t* __restrict best,
                 const std::uint8_t* __restrict merged) {
  for (int slot = 0; slot < kSlotCountMax; ++slot) {
    const std::uint8_t from_winners = merged[slot], from_before = snapshot[slot];
    snapshot[slot] = best[slot] != 0 ? from_winners : from_before;
  }
}

}  // namespace

Merge::Merge(int universe_count, const MergeOptions& options) : options_(options) {
  FL_CHECK_GE(universe_count, 1);
  FL_CHECK_GT(options.timeout_ns, 0);
  const auto count = static_cast<std::size_t>(universe_count);
  universes_.resize(count);
  for (PerUniverse& universe : universes_) universe.mode = options.mode;
  snapshots_ = std::make_unique<std::uint8_t[]>(count * kSlotCountMax);
  levels_ = std::make_unique_for_overwrite<std::uint8_t[]>(count * kSlotCountMax * kSendersPerUniverseMax);
  priorities_ = std::make_unique_for_overwrite<std::uint8_t[]>(count * kSlotCountMax * kSendersPerUniverseMax);
  ltp_slots_.resize(count);
  changed_.reserve(count);
}

void Merge::set_mode(int index, MergeMode mode) {
  FL_CHECK(index >= 0 && index < count());
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const auto& ltp = ltp_slots_[static_cast<std::size_t>(index)];
  const bool has_slots = ltp != nullptr && ltp->slots.any();
  if (universe.mode == mode && !has_slots) return;
  universe.mode = mode;
  if (has_slots) ltp->slots.reset();
  set_by_slot(index);
  mark_changed(index);
}

void Merge::set_slot_modes(int index, const SlotSet& ltp) {
  set_mode(index, MergeMode::kHtp);
  if (ltp.none()) return;
  auto& slots = ltp_slots_[static_cast<std::size_t>(index)];
  if (slots == nullptr) slots = std::make_unique<LtpSlots>();
  slots->slots = ltp;
  set_by_slot(index);
  mark_changed(index);
}

// Sets whether the universe is merged slot by slot. Call after a change of priorities or LTP slots.
void Merge::set_by_slot(int index) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const auto& ltp = ltp_slots_[static_cast<std::size_t>(index)];
  const bool by_slot = universe.priorities_count != 0 || (ltp != nullptr && ltp->slots.any());
  if (by_slot && !universe.by_slot)
    for (int i = 0; i < universe.sender_count; ++i) universe.senders[i].wins = true;  // until the next resolve()
  universe.by_slot = by_slot;
  // When no sender with per-address priority is left, new senders are no longer held back.
  for (int i = 0; i < universe.sender_count && universe.priorities_count == 0; ++i) {
    Sender& sender = universe.senders[i];
    if (sender.waits_until_ns == 0) continue;
    sender.waits_until_ns = 0;
    sender.counts = true;
    mark_changed(index);
  }
}

std::uint8_t* Merge::levels_of(int index, int place) const {
  const std::size_t block = static_cast<std::size_t>(place) * universes_.size() + static_cast<std::size_t>(index);
  return levels_.get() + block * kSlotCountMax;
}

std::uint8_t* Merge::priorities_of(int index, int place) const {
  const std::size_t block = static_cast<std::size_t>(place) * universes_.size() + static_cast<std::size_t>(index);
  return priorities_.get() + block * kSlotCountMax;
}

DurationNs Merge::silence_of(const FrameView& frame) const {
  return frame.silence_max_ns > 0 ? frame.silence_max_ns : options_.timeout_ns;
}

void Merge::mark_changed(int index) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (universe.changed) return;
  universe.changed = true;
  changed_.push_back(index);
}

void Merge::clear_changed() {
  for (int index : changed_) universes_[static_cast<std::size_t>(index)].changed = false;
  changed_.clear();
}

int Merge::highest_priority(const PerUniverse& universe) {
  int top = -1;
  for (int i = 0; i < universe.sender_count; ++i)
    if (universe.senders[i].counts) top = std::max(top, static_cast<int>(universe.senders[i].priority));
  return top;
}

// True if no sender of the same priority changed later.
bool Merge::changed_last(const PerUniverse& universe, const Sender& sender) {
  for (int i = 0; i < universe.sender_count; ++i) {
    const Sender& other = universe.senders[i];
    if (other.counts && other.priority == sender.priority && other.changed_at > sender.changed_at) return false;
  }
  return true;
}

int Merge::winner_count(int index) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const int top = highest_priority(universe);
  int winners = 0;
  for (int i = 0; i < universe.sender_count; ++i) {
    const Sender& sender = universe.senders[i];
    if (sender.counts && (universe.by_slot ? sender.wins : sender.priority == top)) ++winners;
  }
  return winners;
}

int Merge::sender_count(int index) const {
  FL_CHECK(index >= 0 && index < count());
  return universes_[static_cast<std::size_t>(index)].sender_count;
}

const MergeCounters& Merge::counters(int index) const {
  FL_CHECK(index >= 0 && index < count());
  return universes_[static_cast<std::size_t>(index)].counters;
}

Merge::Sender* Merge::find(PerUniverse& universe, SourceId source, SenderId sender) {
  for (int i = 0; i < universe.sender_count; ++i)
    if (universe.senders[i].id == sender && universe.senders[i].source == source) return &universe.senders[i];
  return nullptr;
}

// nullptr: no place for a new sender.
Merge::Sender* Merge::add(int index, const FrameView& frame, SourceId source) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (universe.sender_count == kSendersPerUniverseMax) {
    int lowest = 0;
    for (int i = 1; i < kSendersPerUniverseMax; ++i) {
      const Sender& a = universe.senders[i];
      const Sender& b = universe.senders[lowest];
      if (a.priority < b.priority || (a.priority == b.priority && a.received_at < b.received_at)) lowest = i;
    }
    if (universe.senders[lowest].priority >= frame.priority) return nullptr;
    ++universe.counters.senders_displaced;
    remove(index, lowest);
  }
  unsigned places_taken = 0;
  for (int i = 0; i < universe.sender_count; ++i) places_taken |= 1u << universe.senders[i].place;
  Sender& sender = universe.senders[universe.sender_count++];
  sender = Sender{};
  sender.id = frame.sender;
  sender.source = source;
  sender.priority = frame.priority;
  while ((places_taken >> sender.place & 1u) != 0) ++sender.place;
  std::memset(levels_of(index, sender.place), 0, kSlotCountMax);
  if (const auto& ltp = ltp_slots_[static_cast<std::size_t>(index)]; ltp != nullptr)
    std::memset(ltp->changed_at[sender.place], 0, sizeof ltp->changed_at[sender.place]);
  return &sender;
}

// Removes a sender. The snapshot changes if the sender was a winner and others are left.
void Merge::remove(int index, int number) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const Sender sender = universe.senders[number];
  if (sender.fresh) ++universe.counters.frames_outranked;
  const bool by_slot = universe.by_slot;
  universe.senders[number] = universe.senders[universe.sender_count - 1];
  --universe.sender_count;
  if (sender.has_priorities) {
    --universe.priorities_count;
    set_by_slot(index);
  }
  if (universe.sender_count == 0 || !sender.counts) return;
  if (by_slot ? sender.wins : sender.priority >= highest_priority(universe)) mark_changed(index);
}

void Merge::forget_source(SourceId source) {
  for (int index = 0; index < count(); ++index) {
    PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
    for (int i = universe.sender_count - 1; i >= 0; --i)
      if (universe.senders[i].source == source) remove(index, i);
  }
}

Merge::Received Merge::receive(int index, const FrameView& frame, TimeNs now_ns, SourceId source,
                               std::uint8_t priority_max) {
  FL_CHECK(index >= 0 && index < count());
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (frame.priority > priority_max) {
    ++universe.counters.frames;
    ++universe.counters.refused_priority;
    return Received::kRefusedPriority;
  }
  if (frame.start_code == kStartCodePriorities && !frame.terminated)
    return receive_priorities(index, frame, now_ns, source, priority_max);
  Sender* sender = find(universe, source, frame.sender);
  if (sender != nullptr && sender->fresh) return Received::kResolveFirst;
  ++universe.counters.frames;
  if (frame.terminated) {
    ++universe.counters.frames_ended;
    if (sender != nullptr) {
      ++universe.counters.senders_ended;
      remove(index, static_cast<int>(sender - universe.senders));
    }
    return Received::kStored;
  }
  if (sender == nullptr) {
    sender = add(index, frame, source);
    if (sender == nullptr) {
      ++universe.counters.refused_full;
      return Received::kRefusedFull;
    }
    for (int i = 0; i < universe.sender_count && universe.priorities_count != 0; ++i)
      if (universe.senders[i].has_priorities && universe.senders[i].source == source)
        sender->waits_until_ns = now_ns + kPrioritiesWaitNs;
    if (sender->waits_until_ns != 0) next_expiry_ns_ = std::min(next_expiry_ns_, sender->waits_until_ns);
  }

  // Whether the snapshot depends on this frame: the sender wins now, or won until its priority fell.
  const bool is_new = sender->received_at == 0;
  const bool priority_moves = sender->priority != frame.priority;
  const bool grows = frame.slots.size() > sender->slot_count;
  bool matters = false;
  if (universe.by_slot) {
    matters = sender->wins || is_new || priority_moves || grows;
  } else {
    const int top = highest_priority(universe);
    matters = frame.priority >= top || sender->priority == top;
  }

  std::uint8_t* const levels = levels_of(index, sender->place);
  ++frame_number_;
  if (!frame.slots.empty()) {
    // Only LTP uses the time of the change; a new sender counts as changed.
    if (universe.mode == MergeMode::kLtp &&
        (is_new || priority_moves || std::memcmp(levels, frame.slots.data(), frame.slots.size()) != 0))
      sender->changed_at = frame_number_;
    if (const auto& ltp = ltp_slots_[static_cast<std::size_t>(index)]; ltp != nullptr) {
      std::uint64_t* const changed_at = ltp->changed_at[sender->place];
      for (std::size_t slot = 0; slot < frame.slots.size(); ++slot)
        if (is_new || priority_moves || slot >= sender->slot_count || levels[slot] != frame.slots[slot])
          changed_at[slot] = frame_number_;
    }
    std::memcpy(levels, frame.slots.data(), frame.slots.size());
  }
  sender->slot_count = std::max(sender->slot_count, static_cast<std::uint16_t>(frame.slots.size()));
  sender->priority = frame.priority;
  sender->received_ns = now_ns;
  sender->silence_ns = silence_of(frame);
  next_expiry_ns_ = std::min(next_expiry_ns_, now_ns + sender->silence_ns);
  sender->stamp_ns = frame.stamp_ns;
  sender->received_at = frame_number_;
  sender->sequence = frame.sequence;
  ++sender->frames;
  if (sender->waits_until_ns != 0) {
    ++universe.counters.frames_early;
    return Received::kStored;
  }
  sender->counts = true;
  if (matters &&
      (universe.by_slot || priority_moves || universe.mode == MergeMode::kHtp || changed_last(universe, *sender))) {
    sender->fresh = true;
    mark_changed(index);
  } else {
    ++universe.counters.frames_outranked;
  }
  return Received::kStored;
}

Merge::Received Merge::receive_priorities(int index, const FrameView& frame, TimeNs now_ns, SourceId source,
                                          std::uint8_t priority_max) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  ++universe.counters.frames;
  if (std::any_of(frame.slots.begin(), frame.slots.end(), [&](std::uint8_t p) { return p > priority_max; })) {
    ++universe.counters.refused_priority;
    return Received::kRefusedPriority;
  }
  Sender* sender = find(universe, source, frame.sender);
  if (sender == nullptr) sender = add(index, frame, source);
  if (sender == nullptr) {
    ++universe.counters.refused_full;
    return Received::kRefusedFull;
  }
  ++universe.counters.frames_priorities;
  std::uint8_t* const priorities = priorities_of(index, sender->place);
  bool changes = !sender->has_priorities;
  if (!sender->has_priorities) {
    std::memset(priorities, 0, kSlotCountMax);
    sender->has_priorities = true;
    ++universe.priorities_count;
    set_by_slot(index);
  }
  std::uint8_t wanted[kSlotCountMax] = {};
  std::copy(frame.slots.begin(), frame.slots.end(), wanted);
  changes = changes || std::memcmp(priorities, wanted, kSlotCountMax) != 0;
  std::memcpy(priorities, wanted, kSlotCountMax);
  sender->priorities_ns = now_ns;
  sender->priorities_silence_ns = silence_of(frame);
  next_expiry_ns_ = std::min(next_expiry_ns_, now_ns + sender->priorities_silence_ns);
  if (sender->waits_until_ns != 0) {
    sender->waits_until_ns = 0;
    sender->counts = true;
  }
  if (changes && sender->counts) {
    sender->wins = true;  // until the next resolve()
    mark_changed(index);
  }
  return Received::kStored;
}

// Removes the sender's per-address priorities; its levels continue with the priority of its packets.
void Merge::drop_priorities(int index, Sender& sender) {
  sender.has_priorities = false;
  --universes_[static_cast<std::size_t>(index)].priorities_count;
  set_by_slot(index);
  sender.wins = true;  // until the next resolve()
  if (sender.counts) mark_changed(index);
}

void Merge::expire(TimeNs now_ns) {
  if (now_ns < next_expiry_ns_) return;
  next_expiry_ns_ = kTimeNever;
  for (int index = 0; index < count(); ++index) {
    PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
    for (int i = universe.sender_count - 1; i >= 0; --i) {
      Sender& sender = universe.senders[i];
      TimeNs expiry_ns = sender.received_ns + sender.silence_ns;
      if (sender.received_at == 0) expiry_ns = sender.priorities_ns + sender.priorities_silence_ns;  // no levels yet
      if (expiry_ns <= now_ns) {
        ++universe.counters.senders_silent;
        remove(index, i);
        continue;
      }
      if (sender.has_priorities) {
        const TimeNs priorities_expiry_ns = sender.priorities_ns + sender.priorities_silence_ns;
        if (priorities_expiry_ns <= now_ns) {
          drop_priorities(index, sender);
        } else {
          expiry_ns = std::min(expiry_ns, priorities_expiry_ns);
        }
      }
      if (sender.waits_until_ns != 0) {
        if (sender.waits_until_ns <= now_ns) {
          sender.waits_until_ns = 0;
          sender.counts = sender.wins = true;
          mark_changed(index);
        } else {
          expiry_ns = std::min(expiry_ns, sender.waits_until_ns);
        }
      }
      next_expiry_ns_ = std::min(next_expiry_ns_, expiry_ns);
    }
  }
}

// As resolve(), with winners per slot.
bool Merge::resolve_by_slot(int index) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const LtpSlots* const ltp = ltp_slots_[static_cast<std::size_t>(index)].get();
  const bool any_ltp = universe.mode == MergeMode::kLtp || (ltp != nullptr && ltp->slots.any());
  const int top = highest_priority(universe);
  bool any_priorities = false;
  for (int i = 0; i < universe.sender_count; ++i)
    any_priorities = any_priorities || (universe.senders[i].counts && universe.senders[i].has_priorities);
  // Rank: one more than the priority; 0: does not claim the slot. Without per-address priorities only the universe's
  // highest priority wins, as in resolve().
  std::uint8_t ranks[kSendersPerUniverseMax][kSlotCountMax];
  std::uint8_t best[kSlotCountMax] = {};
  std::uint8_t merged[kSlotCountMax] = {};
  std::uint64_t changed_at[kSlotCountMax];
  for (int i = 0; i < universe.sender_count; ++i) {
    const Sender& sender = universe.senders[i];
    std::uint8_t* const rank = ranks[i];
    const bool may_win = sender.counts && (any_priorities || sender.priority == top);
    const std::size_t slot_count = may_win ? sender.slot_count : 0;
    std::memset(rank + slot_count, 0, kSlotCountMax - slot_count);
    if (!may_win) continue;
    if (sender.has_priorities) {
      rank_priorities(rank, priorities_of(index, sender.place));
      std::memset(rank + slot_count, 0, kSlotCountMax - slot_count);
    } else {
      std::memset(rank, sender.priority + 1, slot_count);
    }
    const std::uint8_t* const levels = levels_of(index, sender.place);
    if (!any_ltp) {
      take_higher_rank(best, merged, rank, levels);
      continue;
    }
    for (std::size_t slot = 0; slot < slot_count; ++slot) {
      if (rank[slot] == 0 || rank[slot] < best[slot]) continue;
      const bool is_ltp = universe.mode == MergeMode::kLtp || (ltp != nullptr && ltp->slots[slot]);
      const std::uint64_t at = universe.mode == MergeMode::kLtp ? sender.changed_at
                               : ltp != nullptr                 ? ltp->changed_at[sender.place][slot]
                                                                : 0;
      if (rank[slot] > best[slot]) {
        merged[slot] = levels[slot];
        changed_at[slot] = at;
      } else if (!is_ltp || at == changed_at[slot]) {  // equal: both 0, no known change
        merged[slot] = std::max(merged[slot], levels[slot]);
      } else if (at > changed_at[slot]) {
        merged[slot] = levels[slot];
        changed_at[slot] = at;
      }
      best[slot] = rank[slot];
    }
  }

  const Sender* newest = nullptr;
  for (int i = 0; i < universe.sender_count; ++i) {
    Sender& sender = universe.senders[i];
    // A sender without slots may still outrank those of lower priority.
    sender.wins = has_best_rank(best, ranks[i]) || (!any_priorities && sender.counts && sender.priority == top);
    if (sender.fresh) ++(sender.wins ? universe.counters.frames_shown : universe.counters.frames_outranked);
    sender.fresh = false;
    if (sender.wins && (newest == nullptr || sender.received_at > newest->received_at)) newest = &sender;
  }
  if (newest == nullptr) return false;
  std::uint8_t* const snapshot = snapshots_.get() + static_cast<std::size_t>(index) * kSlotCountMax;
  take_ranked(snapshot, best, merged);
  universe.snapshot_stamp_ns = newest->stamp_ns;
  universe.snapshot_sender = newest->id;
  universe.snapshot_sequence = newest->sequence;
  const std::uint8_t highest = *std::max_element(best, best + kSlotCountMax);
  universe.snapshot_priority = highest != 0 ? static_cast<std::uint8_t>(highest - 1) : newest->priority;
  return true;
}

bool Merge::resolve(int index) {
  FL_CHECK(index >= 0 && index < count());
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (universe.by_slot) return resolve_by_slot(index);
  Sender* winners[kSendersPerUniverseMax];
  int winner_count = 0;
  const int top = highest_priority(universe);
  for (int i = 0; i < universe.sender_count; ++i) {
    Sender& sender = universe.senders[i];
    if (sender.counts && sender.priority == top) {
      winners[winner_count++] = &sender;
    } else if (sender.fresh) {
      ++universe.counters.frames_outranked;
      sender.fresh = false;
    }
  }
  if (winner_count == 0) return false;

  // The snapshot carries the stamp of the winner received last; under LTP of the winner that changed last.
  const Sender* newest = winners[0];
  for (int i = 1; i < winner_count; ++i) {
    const bool later = universe.mode == MergeMode::kLtp ? winners[i]->changed_at > newest->changed_at
                                                        : winners[i]->received_at > newest->received_at;
    if (later) newest = winners[i];
  }
  for (int i = 0; i < winner_count; ++i) {
    if (!winners[i]->fresh) continue;
    winners[i]->fresh = false;
    const bool shown = universe.mode == MergeMode::kHtp || winners[i] == newest;
    ++(shown ? universe.counters.frames_shown : universe.counters.frames_outranked);
  }
  std::uint8_t* const snapshot = snapshots_.get() + static_cast<std::size_t>(index) * kSlotCountMax;
  if (winner_count == 1 || universe.mode == MergeMode::kLtp) {
    std::memcpy(snapshot, levels_of(index, newest->place), newest->slot_count);
  } else {
    // Levels past the end of a sender's frames are 0 and never the highest, so all 512 are merged at once.
    std::uint8_t merged[kSlotCountMax];
    std::uint16_t slot_count = winners[0]->slot_count;
    std::memcpy(merged, levels_of(index, winners[0]->place), kSlotCountMax);
    for (int i = 1; i < winner_count; ++i) {
      take_highest(merged, levels_of(index, winners[i]->place));
      slot_count = std::max(slot_count, winners[i]->slot_count);
    }
    std::memcpy(snapshot, merged, slot_count);
  }
  universe.snapshot_stamp_ns = newest->stamp_ns;
  universe.snapshot_sender = newest->id;
  universe.snapshot_sequence = newest->sequence;
  universe.snapshot_priority = newest->priority;
  return true;
}

FrameView Merge::snapshot(int index) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  FrameView frame;
  frame.stamp_ns = universe.snapshot_stamp_ns;
  frame.sender = universe.snapshot_sender;
  frame.sequence = universe.snapshot_sequence;
  frame.priority = std::min(universe.snapshot_priority, kPriorityMax);  // logs of snapshots are read again
  frame.slots = {snapshots_.get() + static_cast<std::size_t>(index) * kSlotCountMax, kSlotCountMax};
  return frame;
}

void Merge::set_snapshot(int index, const FrameView& frame) {
  FL_CHECK(index >= 0 && index < count());
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (!frame.slots.empty())
    std::memcpy(snapshots_.get() + static_cast<std::size_t>(index) * kSlotCountMax, frame.slots.data(),
                frame.slots.size());
  universe.snapshot_stamp_ns = frame.stamp_ns;
  universe.snapshot_sender = frame.sender;
  universe.snapshot_sequence = frame.sequence;
  universe.snapshot_priority = frame.priority;
}

MergeSender Merge::sender(int index, int number) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  FL_CHECK(number >= 0 && number < universe.sender_count);
  const Sender& sender = universe.senders[number];
  MergeSender status;
  status.source = sender.source;
  status.id = sender.id;
  status.received_ns = sender.received_ns;
  status.rate_hz = static_cast<double>(sender.rate_hz);
  status.priority = sender.priority;
  status.per_address = sender.has_priorities;
  status.wins =
      sender.counts && (universe.by_slot ? sender.wins
                                         : sender.priority == highest_priority(universe) &&
                                               (universe.mode == MergeMode::kHtp || changed_last(universe, sender)));
  return status;
}

// In a slot that is LTP, a sender whose change was overruled and that has the same level counts as well.
void Merge::slot_senders(int index, SlotSenders& into) const {
  FL_CHECK(index >= 0 && index < count());
  static_assert(kSendersPerUniverseMax <= 8);
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const std::uint8_t* const snapshot = snapshots_.get() + static_cast<std::size_t>(index) * kSlotCountMax;
  into.fill(0);
  SlotSenders best{};
  for (int k = 0; k < universe.sender_count; ++k) {
    const Sender& sender_k = universe.senders[k];
    if (!sender(index, k).wins) continue;
    const std::uint8_t* const levels = levels_of(index, sender_k.place);
    const std::uint8_t* const priorities = sender_k.has_priorities ? priorities_of(index, sender_k.place) : nullptr;
    for (std::size_t slot = 0; slot < sender_k.slot_count; ++slot) {
      // As in resolve_by_slot(): one more than the priority; 0: does not claim the slot.
      const int priority = priorities != nullptr ? priorities[slot] : sender_k.priority + 1;
      const auto rank = static_cast<std::uint8_t>(priorities != nullptr && priority > 0 ? priority + 1 : priority);
      if (rank == 0 || rank < best[slot]) continue;
      if (rank > best[slot]) into[slot] = 0;
      best[slot] = rank;
      if (levels[slot] == snapshot[slot]) into[slot] = static_cast<std::uint8_t>(into[slot] | 1u << k);
    }
  }
}

void Merge::count_rates(double period_s) {
  FL_CHECK_GT(period_s, 0.0);
  for (PerUniverse& universe : universes_)
    for (int i = 0; i < universe.sender_count; ++i) {
      Sender& sender = universe.senders[i];
      sender.rate_hz = static_cast<float>(static_cast<double>(sender.frames) / period_s);
      sender.frames = 0;
    }
}

void Merge::adopt(const Merge& from, std::span<const int> from_index) {
  FL_CHECK_EQ(from_index.size(), universes_.size());
  FL_CHECK_EQ(frame_number_, 0u);
  for (std::size_t i = 0; i < universes_.size(); ++i) {
    if (from_index[i] < 0) continue;
    const int index = static_cast<int>(i);
    const PerUniverse& old = from.universes_[static_cast<std::size_t>(from_index[i])];
    PerUniverse& universe = universes_[i];
    const MergeMode mode = universe.mode;
    const bool changed = universe.changed;
    universe = old;
    universe.mode = mode;
    universe.changed = changed;
    set_snapshot(index, from.snapshot(from_index[i]));
    for (int k = 0; k < universe.sender_count; ++k) {
      const int place = universe.senders[k].place;
      std::memcpy(levels_of(index, place), from.levels_of(from_index[i], place), kSlotCountMax);
      if (universe.senders[k].has_priorities)
        std::memcpy(priorities_of(index, place), from.priorities_of(from_index[i], place), kSlotCountMax);
    }
    // Keeps which sender changed each slot last, for a following set_slot_modes().
    const auto& ltp = from.ltp_slots_[static_cast<std::size_t>(from_index[i])];
    const bool had_ltp_slots = ltp != nullptr && ltp->slots.any();
    if (had_ltp_slots) {
      ltp_slots_[i] = std::make_unique<LtpSlots>(*ltp);
      ltp_slots_[i]->slots.reset();
    }
    set_by_slot(index);
    if (old.changed || old.mode != mode || had_ltp_slots) mark_changed(index);
  }
  frame_number_ = from.frame_number_;
  next_expiry_ns_ = from.next_expiry_ns_;
}

}  // namespace footlight
