// Merges the frames of several senders into one snapshot of each universe.
//
// Rules, per universe (E1.31-2018 sections 6.2.3 and 6.7.1 for priority and loss):
// - The senders with the highest priority win. Senders of equal priority are merged by HTP or LTP. HTP takes the
//   highest level of each slot. LTP takes the levels of the sender that changed last. A repeat of unchanged levels is
//   not a change, because two consoles would otherwise flicker.
// - Senders that lose are kept up to date, so that a failover shows their newest levels at once.
// - A silent sender keeps its last levels for the silence_max_ns of its last frame, or for timeout_ns (2.5 s by
//   default) if that is 0. It is then removed. A frame marked `terminated` removes the sender at once.
// - The snapshot stays as it is when the last sender is removed.
// - Slots that no winner ever sent stay as they are. Slots past the end of a short frame keep the sender's earlier
//   levels.
// - A priority above 200 violates the protocol: the frame is ignored and counted. Only a source that the caller allows
//   it to may have kPriorityOverride, which wins over every sender (a blackout). Snapshots have at most 200.
// - Single slots may be LTP in a universe that is otherwise HTP. Such a slot has the level of the winner that changed
//   it last.
//
// Per-address priority (start code 0xDD, ETC's extension of sACN; ETCLabs/sACN, docs/pages/per_address_priority.md):
// - A sender of 0xDD frames has their priority in each slot, instead of the priority of its packets. With 0 it does not
//   claim the slot. Slots past the end of a short 0xDD frame have 0. A sender without 0xDD has the priority of its
//   packets in each slot that it sends. The highest priority wins each slot; equal ones merge as above. A slot that no
//   sender claims keeps its level.
// - A sender whose 0xDD frames stop while its levels continue returns to the priority of its packets after the silence
//   time. A sender whose levels stop is removed, even if its 0xDD frames continue. Levels and 0xDD frames may arrive in
//   either order.
// - A new sender is held back for up to 1.5 s until its 0xDD frame arrives, if another sender of its source sends 0xDD
//   in this universe. Otherwise a desk that claims a few slots would take all of them with its first frames. Without
//   such a sender there is no delay.
// - A packet priority of 0 still claims a slot, below all others. A 0xDD frame with a value above 200 is refused.
// - A universe without 0xDD frames costs no extra time.
//
// Senders:
// - A sender is identified by its source and its SenderId, so two ports may use the same ids.
// - A universe has at most eight senders. A ninth is refused and counted, unless its priority is above the lowest one,
//   which cannot win beside it. Then it replaces a sender of the lowest priority (the one silent for longest), which is
//   counted too.
// - A source that sends only when something changes must repeat itself within the silence time, or it loses its
//   universe to other senders.
//
// No frame of a winner is skipped: receive() refuses a second frame of a sender until resolve() has used the first. So
// each frame is counted in exactly one of the counters of MergeCounters.
//
// Time is passed in. Silence is counted from the `now_ns` of receive(), not from the frame's stamp. So frames that
// waited in a socket while the machine was stopped count as received when they are read.
//
// Threads: none of its own; not safe to share (the pump's thread owns it). Only the constructor, set_slot_modes() and
// adopt() allocate: 512 bytes per universe for the snapshot, and address space for the levels and priorities of 8
// senders per universe. That memory is used only as senders appear.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/core/dmx.h"

namespace footlight {

inline constexpr int kSendersPerUniverseMax = 8;
inline constexpr DurationNs kSenderTimeoutDefaultNs = 2'500 * kNsPerMs;  // E1.31-2018 section 6.7.1
inline constexpr std::uint8_t kPriorityOverride = kPriorityMax + 1;      // no protocol can carry it
inline constexpr DurationNs kPrioritiesWaitNs = 1'500 * kNsPerMs;        // ETC's rule 13

using SlotSet = std::bitset<kSlotCountMax>;  // bit 0 = address 1

enum class MergeMode : std::uint8_t { kHtp, kLtp };

struct MergeOptions {
  DurationNs timeout_ns = kSenderTimeoutDefaultNs;  // > 0
  MergeMode mode = MergeMode::kHtp;                 // of every universe; set_mode() changes single ones
  friend bool operator==(const MergeOptions&, const MergeOptions&) = default;
};

// Identifies the source of a frame; assigned by the caller of receive().
using SourceId = std::uint32_t;

// What happened to the frames of one universe. `frames` is the sum of the seven counters after it and of the frames
// that wait for resolve().
struct MergeCounters {
  std::uint64_t frames = 0;             // accepted or refused by receive()
  std::uint64_t frames_shown = 0;       // are in a snapshot, alone or merged with others
  std::uint64_t frames_outranked = 0;   // lost to a higher priority or, under LTP, to a later change
  std::uint64_t frames_priorities = 0;  // carried per-address priorities, not levels
  std::uint64_t frames_early = 0;       // of a new sender that is held back until its priorities arrive
  std::uint64_t frames_ended = 0;       // marked `terminated`
  std::uint64_t refused_priority = 0;   // ignored: a priority above 200
  std::uint64_t refused_full = 0;       // ignored: the universe has eight other senders
  std::uint64_t senders_displaced = 0;  // senders replaced by one of higher priority
  std::uint64_t senders_silent = 0;     // senders removed because they were silent
  std::uint64_t senders_ended = 0;      // senders that marked a frame `terminated`
};

// One sender of a universe, for status output.
struct MergeSender {
  SourceId source = 0;
  SenderId id = 0;
  TimeNs received_ns = 0;                    // when its last levels were received; 0: none yet
  double rate_hz = 0.0;                      // of frames with levels, at the last count_rates()
  std::uint8_t priority = kPriorityDefault;  // of its last frame
  bool wins = false;                         // some of its levels are in the snapshot
  bool per_address = false;                  // its per-address priorities apply, not `priority`
};

class Merge {
 public:
  explicit Merge(int universe_count, const MergeOptions& options = {});

  [[nodiscard]] int count() const { return static_cast<int>(universes_.size()); }
  void set_mode(int index, MergeMode mode);
  // HTP except for these slots, which are LTP. An LTP slot without a known change has its highest level until a sender
  // changes it. May allocate.
  void set_slot_modes(int index, const SlotSet& ltp);

  enum class Received {
    kStored,           // accepted; changed() lists the universe if its snapshot may change
    kRefusedPriority,  // see MergeCounters
    kRefusedFull,
    kResolveFirst,  // not accepted and not counted: the sender's last frame is not resolved yet; resolve, then pass it
                    // again
  };
  // Takes one frame. Frames of one sender come oldest first. `now_ns` never decreases between calls. `priority_max`:
  // kPriorityMax or kPriorityOverride, of the source.
  Received receive(int index, const FrameView& frame, TimeNs now_ns, SourceId source = 0,
                   std::uint8_t priority_max = kPriorityMax);

  // Removes every sender of a source that has gone.
  void forget_source(SourceId source);

  // Removes the senders that have been silent for too long. Cheap before next_expiry_ns().
  void expire(TimeNs now_ns);
  // No sender expires before this time; kTimeNever: there is no sender. May be too early, never too late.
  [[nodiscard]] TimeNs next_expiry_ns() const { return next_expiry_ns_; }

  // Universes whose snapshot must be resolved again, each once, in the order in which they changed. Valid until
  // clear_changed().
  [[nodiscard]] std::span<const int> changed() const { return changed_; }
  // Makes the snapshot of one universe from its winners. Returns false and keeps the snapshot if there are none.
  bool resolve(int index);
  // Call after every changed universe was resolved.
  void clear_changed();

  // The snapshot: 512 levels, and the stamp, sender, sequence and priority of the winner received last. Valid until the
  // next resolve() of this universe. `universe` is 0, because Merge uses indices only.
  [[nodiscard]] FrameView snapshot(int index) const;
  // Starts with levels that no sender here sent (a buffer filled before the pump started). Senders are not changed.
  void set_snapshot(int index, const FrameView& frame);

  [[nodiscard]] int sender_count(int index) const;
  // The number of senders that share the highest priority.
  [[nodiscard]] int winner_count(int index) const;
  [[nodiscard]] const MergeCounters& counters(int index) const;
  // The `number`-th of sender_count(), in no order.
  [[nodiscard]] MergeSender sender(int index, int number) const;
  // Which senders have set each slot of the snapshot: bit k is the k-th of sender_count(). Several bits: they send the
  // same level; none: no sender claims the slot. Valid after resolve(). For displays: it compares all levels.
  using SlotSenders = std::array<std::uint8_t, kSlotCountMax>;
  void slot_senders(int index, SlotSenders& into) const;
  // Computes MergeSender::rate_hz over the time since the last call. `period_s` > 0.
  void count_rates(double period_s);

  // Continues from another merge: its universe `from_index[i]` becomes index i, with senders, snapshot and counters.
  // -1: index i starts empty. Modes are not copied. Call before anything is received.
  void adopt(const Merge& from, std::span<const int> from_index);

 private:
  struct Sender {
    SenderId id = 0;
    TimeNs received_ns = 0;         // `now_ns` of its last frame
    TimeNs stamp_ns = 0;            // of its last frame
    DurationNs silence_ns = 0;      // after which it is removed
    std::uint64_t received_at = 0;  // running number of its last frame, and of the last one that changed a level
    std::uint64_t changed_at = 0;
    SourceId source = 0;
    std::uint32_t sequence = 0;
    std::uint32_t frames = 0;  // since the last count_rates()
    float rate_hz = 0.0F;
    std::uint16_t slot_count = 0;  // of its longest frame
    std::uint8_t priority = 0;
    std::uint8_t place = 0;  // which of the eight blocks of levels_ it uses
    bool fresh = false;      // its last frame has not been resolved
    bool counts = false;     // has sent levels, and is not held back
    bool wins = false;       // in a universe merged slot by slot: at the last resolve(), or possibly since
    bool has_priorities = false;
    TimeNs priorities_ns = 0;  // `now_ns` of its last priorities
    DurationNs priorities_silence_ns = 0;
    TimeNs waits_until_ns = 0;  // it does not count until then; 0: it counts
  };
  // Fields that every frame touches come first.
  struct PerUniverse {
    std::uint8_t sender_count = 0;
    std::uint8_t priorities_count = 0;  // of senders with priorities
    MergeMode mode = MergeMode::kHtp;
    bool by_slot = false;  // a sender has priorities, or some slots are LTP
    bool changed = false;
    std::uint8_t snapshot_priority = kPriorityDefault;
    std::uint32_t snapshot_sequence = 0;
    TimeNs snapshot_stamp_ns = 0;
    SenderId snapshot_sender = 0;
    MergeCounters counters;
    Sender senders[kSendersPerUniverseMax];  // the first sender_count are there, in no order
  };
  // For a universe with LTP slots.
  struct LtpSlots {
    SlotSet slots;
    // Running number of the frame that last changed the slot: [place of the sender][slot].
    std::uint64_t changed_at[kSendersPerUniverseMax][kSlotCountMax] = {};
  };

  [[nodiscard]] static int highest_priority(const PerUniverse& universe);  // -1: there is no sender
  [[nodiscard]] static bool changed_last(const PerUniverse& universe, const Sender& sender);
  [[nodiscard]] std::uint8_t* levels_of(int index, int place) const;
  [[nodiscard]] static Sender* find(PerUniverse& universe, SourceId source, SenderId sender);
  [[nodiscard]] Sender* add(int index, const FrameView& frame, SourceId source);
  Received receive_priorities(int index, const FrameView& frame, TimeNs now_ns, SourceId source,
                              std::uint8_t priority_max);
  void drop_priorities(int index, Sender& sender);
  void set_by_slot(int index);
  bool resolve_by_slot(int index);
  [[nodiscard]] std::uint8_t* priorities_of(int index, int place) const;
  [[nodiscard]] DurationNs silence_of(const FrameView& frame) const;
  void remove(int index, int number);
  void mark_changed(int index);

  MergeOptions options_;
  std::vector<PerUniverse> universes_;
  std::unique_ptr<std::uint8_t[]> snapshots_;  // count() x 512
  // 8 x count() x 512, not initialised. Block [place][universe] is cleared when a sender takes it, so memory without a
  // sender is never touched.
  std::unique_ptr<std::uint8_t[]> levels_;
  std::unique_ptr<std::uint8_t[]> priorities_;        // likewise, touched only by senders with priorities
  std::vector<std::unique_ptr<LtpSlots>> ltp_slots_;  // per universe; null: none
  std::vector<int> changed_;
  TimeNs next_expiry_ns_ = kTimeNever;
  std::uint64_t frame_number_ = 0;
};

}  // namespace footlight
