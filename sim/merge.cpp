#include "sim/merge.h"

#include <algorithm>
#include <cstring>

#include "sim/core/check.h"

namespace footlight {
namespace {

// Written over whole universes so that the compiler turns it into vector code.
void take_highest(std::uint8_t* __restrict look, const std::uint8_t* __restrict levels) {
  for (int slot = 0; slot < kSlotCountMax; ++slot) look[slot] = std::max(look[slot], levels[slot]);
}

}  // namespace

Merge::Merge(int universe_count, const MergeOptions& options) : options_(options) {
  FL_CHECK_GE(universe_count, 1);
  FL_CHECK_GT(options.timeout_ns, 0);
  const auto count = static_cast<std::size_t>(universe_count);
  universes_.resize(count);
  for (PerUniverse& universe : universes_) universe.mode = options.mode;
  looks_ = std::make_unique<std::uint8_t[]>(count * kSlotCountMax);
  levels_ = std::make_unique_for_overwrite<std::uint8_t[]>(count * kSlotCountMax * kSendersPerUniverseMax);
  changed_.reserve(count);
}

void Merge::set_mode(int index, MergeMode mode) {
  FL_CHECK(index >= 0 && index < count());
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (universe.mode == mode) return;
  universe.mode = mode;
  mark_changed(index);
}

std::uint8_t* Merge::levels_of(int index, int place) const {
  const std::size_t block = static_cast<std::size_t>(place) * universes_.size() + static_cast<std::size_t>(index);
  return levels_.get() + block * kSlotCountMax;
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
  for (int i = 0; i < universe.sender_count; ++i) top = std::max(top, static_cast<int>(universe.senders[i].priority));
  return top;
}

// Whether no sender of the same priority changed later.
bool Merge::changed_last(const PerUniverse& universe, const Sender& sender) {
  for (int i = 0; i < universe.sender_count; ++i) {
    const Sender& other = universe.senders[i];
    if (other.priority == sender.priority && other.changed_at > sender.changed_at) return false;
  }
  return true;
}

int Merge::winner_count(int index) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const int top = highest_priority(universe);
  int winners = 0;
  for (int i = 0; i < universe.sender_count; ++i)
    if (universe.senders[i].priority == top) ++winners;
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

// nullptr: there is no place for a new sender.
Merge::Sender* Merge::add(int index, const FrameView& frame, SourceId source) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (universe.sender_count == kSendersPerUniverseMax) {
    int lowest = 0;
    for (int i = 1; i < kSendersPerUniverseMax; ++i) {
      const Sender& a = universe.senders[i];
      const Sender& b = universe.senders[lowest];
      if (a.priority < b.priority || (a.priority == b.priority && a.heard_at < b.heard_at)) lowest = i;
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
  return &sender;
}

// Forgets a sender. The look changes where it was a winner and others are left; else it stays.
void Merge::remove(int index, int sender) {
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  const int priority = universe.senders[sender].priority;
  if (universe.senders[sender].fresh) ++universe.counters.frames_outranked;
  universe.senders[sender] = universe.senders[universe.sender_count - 1];
  --universe.sender_count;
  if (universe.sender_count != 0 && priority >= highest_priority(universe)) mark_changed(index);
}

void Merge::forget_source(SourceId source) {
  for (int index = 0; index < count(); ++index) {
    PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
    for (int i = universe.sender_count - 1; i >= 0; --i)
      if (universe.senders[i].source == source) remove(index, i);
  }
}

Merge::Received Merge::receive(int index, const FrameView& frame, TimeNs now_ns, SourceId source) {
  FL_CHECK(index >= 0 && index < count());
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (frame.priority > kPriorityMax) {
    ++universe.counters.frames;
    ++universe.counters.refused_priority;
    return Received::kRefusedPriority;
  }
  if (frame.start_code != kStartCodeLevels) {
    ++universe.counters.frames;
    ++universe.counters.frames_priorities;
    return Received::kStored;
  }
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
  if (sender == nullptr) sender = add(index, frame, source);
  if (sender == nullptr) {
    ++universe.counters.refused_full;
    return Received::kRefusedFull;
  }

  // Whether the look depends on this frame: the sender wins now, or won until its priority fell.
  const int top = highest_priority(universe);
  const bool priority_moves = sender->priority != frame.priority;
  const bool wins = frame.priority >= top || sender->priority == top;

  std::uint8_t* const levels = levels_of(index, sender->place);
  ++frame_number_;
  if (!frame.slots.empty()) {
    // Only LTP asks what changed; a sender that has just come counts as changed.
    const bool is_new = sender->heard_at == 0;
    if (universe.mode == MergeMode::kLtp &&
        (is_new || priority_moves || std::memcmp(levels, frame.slots.data(), frame.slots.size()) != 0))
      sender->changed_at = frame_number_;
    std::memcpy(levels, frame.slots.data(), frame.slots.size());
  }
  sender->slot_count = std::max(sender->slot_count, static_cast<std::uint16_t>(frame.slots.size()));
  sender->priority = frame.priority;
  sender->heard_ns = now_ns;
  sender->silence_ns = frame.silence_max_ns > 0 ? frame.silence_max_ns : options_.timeout_ns;
  next_expiry_ns_ = std::min(next_expiry_ns_, now_ns + sender->silence_ns);
  sender->stamp_ns = frame.stamp_ns;
  sender->heard_at = frame_number_;
  sender->sequence = frame.sequence;
  ++sender->frames;
  if (wins && (priority_moves || universe.mode == MergeMode::kHtp || changed_last(universe, *sender))) {
    sender->fresh = true;
    mark_changed(index);
  } else {
    ++universe.counters.frames_outranked;
  }
  return Received::kStored;
}

void Merge::expire(TimeNs now_ns) {
  if (now_ns < next_expiry_ns_) return;
  next_expiry_ns_ = kTimeNever;
  for (int index = 0; index < count(); ++index) {
    PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
    for (int i = universe.sender_count - 1; i >= 0; --i) {
      const TimeNs expiry_ns = universe.senders[i].heard_ns + universe.senders[i].silence_ns;
      if (expiry_ns <= now_ns) {
        ++universe.counters.senders_silent;
        remove(index, i);
      } else {
        next_expiry_ns_ = std::min(next_expiry_ns_, expiry_ns);
      }
    }
  }
}

bool Merge::resolve(int index) {
  FL_CHECK(index >= 0 && index < count());
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  Sender* winners[kSendersPerUniverseMax];
  int winner_count = 0;
  const int top = highest_priority(universe);
  for (int i = 0; i < universe.sender_count; ++i) {
    Sender& sender = universe.senders[i];
    if (sender.priority == top) {
      winners[winner_count++] = &sender;
    } else if (sender.fresh) {
      ++universe.counters.frames_outranked;
      sender.fresh = false;
    }
  }
  if (winner_count == 0) return false;

  // The heard-last winner signs the look; under LTP the one that changed last is the only one.
  const Sender* newest = winners[0];
  for (int i = 1; i < winner_count; ++i) {
    const bool later = universe.mode == MergeMode::kLtp ? winners[i]->changed_at > newest->changed_at
                                                        : winners[i]->heard_at > newest->heard_at;
    if (later) newest = winners[i];
  }
  for (int i = 0; i < winner_count; ++i) {
    if (!winners[i]->fresh) continue;
    winners[i]->fresh = false;
    const bool shown = universe.mode == MergeMode::kHtp || winners[i] == newest;
    ++(shown ? universe.counters.frames_shown : universe.counters.frames_outranked);
  }
  std::uint8_t* const look = looks_.get() + static_cast<std::size_t>(index) * kSlotCountMax;
  if (winner_count == 1 || universe.mode == MergeMode::kLtp) {
    std::memcpy(look, levels_of(index, newest->place), newest->slot_count);
  } else {
    // Levels past the end of a sender's frames are 0 and raise nothing, so all 512 are merged at once.
    std::uint8_t merged[kSlotCountMax];
    std::uint16_t slot_count = winners[0]->slot_count;
    std::memcpy(merged, levels_of(index, winners[0]->place), kSlotCountMax);
    for (int i = 1; i < winner_count; ++i) {
      take_highest(merged, levels_of(index, winners[i]->place));
      slot_count = std::max(slot_count, winners[i]->slot_count);
    }
    std::memcpy(look, merged, slot_count);
  }
  universe.look_stamp_ns = newest->stamp_ns;
  universe.look_sender = newest->id;
  universe.look_sequence = newest->sequence;
  universe.look_priority = newest->priority;
  return true;
}

FrameView Merge::look(int index) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  FrameView frame;
  frame.stamp_ns = universe.look_stamp_ns;
  frame.sender = universe.look_sender;
  frame.sequence = universe.look_sequence;
  frame.priority = universe.look_priority;
  frame.slots = {looks_.get() + static_cast<std::size_t>(index) * kSlotCountMax, kSlotCountMax};
  return frame;
}

void Merge::set_look(int index, const FrameView& frame) {
  FL_CHECK(index >= 0 && index < count());
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  if (!frame.slots.empty())
    std::memcpy(looks_.get() + static_cast<std::size_t>(index) * kSlotCountMax, frame.slots.data(), frame.slots.size());
  universe.look_stamp_ns = frame.stamp_ns;
  universe.look_sender = frame.sender;
  universe.look_sequence = frame.sequence;
  universe.look_priority = frame.priority;
}

MergeSender Merge::sender(int index, int number) const {
  FL_CHECK(index >= 0 && index < count());
  const PerUniverse& universe = universes_[static_cast<std::size_t>(index)];
  FL_CHECK(number >= 0 && number < universe.sender_count);
  const Sender& sender = universe.senders[number];
  MergeSender told;
  told.source = sender.source;
  told.id = sender.id;
  told.heard_ns = sender.heard_ns;
  told.rate_hz = static_cast<double>(sender.rate_hz);
  told.priority = sender.priority;
  told.wins = sender.priority == highest_priority(universe) &&
              (universe.mode == MergeMode::kHtp || changed_last(universe, sender));
  return told;
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
    set_look(index, from.look(from_index[i]));
    for (int k = 0; k < universe.sender_count; ++k) {
      const int place = universe.senders[k].place;
      std::memcpy(levels_of(index, place), from.levels_of(from_index[i], place), kSlotCountMax);
    }
    if (old.changed || old.mode != mode) mark_changed(index);
  }
  frame_number_ = from.frame_number_;
  next_expiry_ns_ = from.next_expiry_ns_;
}

}  // namespace footlight
