// Several senders, one look: decides for every universe whose levels count.
//
// Rules, per universe (E1.31-2018 sections 6.2.3 and 6.7.1 for priority and loss):
// - The senders of the highest priority win. Equal ones are merged: HTP, the highest level of each slot, or LTP, the
//   levels of the one that changed last (a repeat of unchanged levels is not a change, or two consoles would flicker).
// - Losing senders are kept up to date, so that a failover shows their newest levels at once.
// - A sender that is silent holds its last look for the silence_max_ns of its last frame or, where that is 0, for
//   timeout_ns, 2.5 s by default, and is then forgotten. A frame marked `terminated` has it forgotten at once.
// - When the last sender is forgotten, the look stays as it is.
// - Slots that no winner ever sent stay as they are. Within one sender, slots past the end of a short frame stay as
//   well.
// - A priority above 200 is against the protocol: the frame is ignored and counted.
// - Single slots may be LTP where the rest of the universe is HTP: of the winners, the one that changed the slot last.
//
// Per-address priority (start code 0xDD, ETC's extension of sACN; ETCLabs/sACN, docs/pages/per_address_priority.md):
// - A sender that sends it has that priority in each slot instead of the one of its packets. 0: it leaves the slot to
//   others; slots past the end of a short frame are 0. Senders without it have their packets' priority in each slot
//   that they send. The highest wins slot by slot, equal ones merge as above; a slot that nobody claims keeps its
//   level.
// - A sender whose 0xDD frames stop, while its levels go on, falls back to its packets' priority after the time of
//   silence. One whose levels stop is forgotten, whether 0xDD goes on or not. Either may come first.
// - A new sender waits for its 0xDD for 1.5 s where another sender of its source sends them in this universe, so that a
//   desk that claims a few slots does not take all for its first frames. Elsewhere nobody waits.
// - A packet priority of 0 still claims a slot, below all others; a 0xDD frame with a value above 200 is refused.
// Universes in which nobody sends it pay nothing for it.
//
// - A sender is known by its source and its SenderId, so that two ports may give out the same numbers.
// - Eight senders at most. A ninth is refused and counted, unless its priority is above that of the lowest, which
//   cannot win beside it: then it takes that one's place (of several, the one silent for longest), which is counted
//   too.
//
// A source that speaks only when something changes has to repeat itself within that time, or it loses its universe to
// other senders.
//
// No frame of a winner is skipped: receive() refuses a second one of the same sender before the first was made into a
// look by resolve(). So each frame is counted in just one of the ways that MergeCounters names.
//
// Time is passed in: silence is counted from the `now_ns` of receive(), not from the frame's stamp, so that frames that
// waited in a socket while the machine was stopped count as heard when they are read.
//
// Threads: none of its own; not safe to share (the pump's thread owns it). Only the constructor and set_slot_modes()
// allocate: 512 bytes per universe for the look, and address space for the levels and priorities of 8 senders per
// universe, of which memory is used only as they come.
#pragma once

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
inline constexpr DurationNs kPrioritiesWaitNs = 1'500 * kNsPerMs;        // ETC's rule 13

using SlotSet = std::bitset<kSlotCountMax>;  // bit 0 = address 1

enum class MergeMode : std::uint8_t { kHtp, kLtp };

struct MergeOptions {
  DurationNs timeout_ns = kSenderTimeoutDefaultNs;  // > 0
  MergeMode mode = MergeMode::kHtp;                 // of every universe; set_mode() changes single ones
  friend bool operator==(const MergeOptions&, const MergeOptions&) = default;
};

// Which source a frame came from; given out by whoever calls receive().
using SourceId = std::uint32_t;

// What happened to the frames of one universe. `frames` is the sum of the seven after it, and of the frames that wait
// for resolve().
struct MergeCounters {
  std::uint64_t frames = 0;             // taken or refused by receive()
  std::uint64_t frames_shown = 0;       // are in a look, alone or merged with others
  std::uint64_t frames_outranked = 0;   // lost to a higher priority or, under LTP, to a later change
  std::uint64_t frames_priorities = 0;  // carried no levels but per-address priorities
  std::uint64_t frames_early = 0;       // of a new sender, while it is waited for whether it sends priorities
  std::uint64_t frames_ended = 0;       // said that the sender stops
  std::uint64_t refused_priority = 0;   // ignored: a priority above 200
  std::uint64_t refused_full = 0;       // ignored: eight other senders are there
  std::uint64_t senders_displaced = 0;  // senders that gave their place to one of higher priority
  std::uint64_t senders_silent = 0;     // senders forgotten for their silence
  std::uint64_t senders_ended = 0;      // senders that said they stop
};

// One sender of a universe, for people.
struct MergeSender {
  SourceId source = 0;
  SenderId id = 0;
  TimeNs heard_ns = 0;                       // when its last levels were received; 0: none yet
  double rate_hz = 0.0;                      // of frames with levels, as of the last count_rates()
  std::uint8_t priority = kPriorityDefault;  // of its last frame
  bool wins = false;                         // some of its levels count
  bool per_address = false;                  // its per-address priorities count, not `priority`
};

class Merge {
 public:
  explicit Merge(int universe_count, const MergeOptions& options = {});

  [[nodiscard]] int count() const { return static_cast<int>(universes_.size()); }
  void set_mode(int index, MergeMode mode);
  // HTP but for these slots, which are LTP; where nobody is known to have changed such a slot yet, its highest level
  // stays until somebody does. May allocate.
  void set_slot_modes(int index, const SlotSet& ltp);

  enum class Received {
    kStored,           // taken; whether the look may change is said by changed()
    kRefusedPriority,  // see MergeCounters
    kRefusedFull,
    kResolveFirst,  // not taken, not counted: the sender's last frame is not in a look yet; resolve, then give it again
  };
  // Takes one frame (oldest first within a sender). `now_ns` never goes back between calls.
  Received receive(int index, const FrameView& frame, TimeNs now_ns, SourceId source = 0);

  // Forgets every sender of a source that is no more.
  void forget_source(SourceId source);

  // Forgets the senders that have been silent for too long. Cheap before next_expiry_ns().
  void expire(TimeNs now_ns);
  // Nobody can be forgotten before; kTimeNever: nobody is there. May be too early, never too late.
  [[nodiscard]] TimeNs next_expiry_ns() const { return next_expiry_ns_; }

  // Universes whose look has to be made anew, in the order in which that became so, once each. Until clear_changed().
  [[nodiscard]] std::span<const int> changed() const { return changed_; }
  // Makes the look of one universe from its winners. Returns false, and leaves the look, where there are none.
  bool resolve(int index);
  // Call after every changed universe was resolved.
  void clear_changed();

  // The look: 512 levels, and the stamp, sender, sequence and priority of the winner heard last. Valid until the next
  // resolve() of this universe. `universe` is 0: Merge knows indices only.
  [[nodiscard]] FrameView snapshot(int index) const;
  // Begins with a look that nobody sent here (a buffer filled before the pump started). Senders are left alone.
  void set_snapshot(int index, const FrameView& frame);

  [[nodiscard]] int sender_count(int index) const;
  // How many of them win, that is: share the highest priority.
  [[nodiscard]] int winner_count(int index) const;
  [[nodiscard]] const MergeCounters& counters(int index) const;
  // The `number`-th of sender_count(), in no order.
  [[nodiscard]] MergeSender sender(int index, int number) const;
  // Reckons MergeSender::rate_hz over the time since the last call. > 0.
  void count_rates(double period_s);

  // Goes on where another merge was: its universe `from_index[i]` becomes index i, with senders, look and counters; -1:
  // index i begins empty. Modes are not taken over. Before anything is received.
  void adopt(const Merge& from, std::span<const int> from_index);

 private:
  struct Sender {
    SenderId id = 0;
    TimeNs heard_ns = 0;         // `now_ns` of its last frame
    TimeNs stamp_ns = 0;         // of its last frame
    DurationNs silence_ns = 0;   // after which it is forgotten
    std::uint64_t heard_at = 0;  // running number of its last frame, and of the last that changed a level
    std::uint64_t changed_at = 0;
    SourceId source = 0;
    std::uint32_t sequence = 0;
    std::uint32_t frames = 0;  // since the last count_rates()
    float rate_hz = 0.0F;
    std::uint16_t slot_count = 0;  // of its longest frame
    std::uint8_t priority = 0;
    std::uint8_t place = 0;  // which of the eight blocks of levels_ is its own
    bool fresh = false;      // its last frame has not been resolved
    bool counts = false;     // has sent levels, and is not waited for
    bool wins = false;       // in a universe that is merged slot by slot: as of the last resolve(), or perhaps
    bool has_priorities = false;
    TimeNs priorities_ns = 0;  // `now_ns` of its last priorities
    DurationNs priorities_silence_ns = 0;
    TimeNs waits_until_ns = 0;  // until then it does not count; 0: it does
  };
  // What every frame touches comes first.
  struct PerUniverse {
    std::uint8_t sender_count = 0;
    std::uint8_t priorities_count = 0;  // of senders that have priorities
    MergeMode mode = MergeMode::kHtp;
    bool by_slot = false;  // somebody has priorities, or some slots are LTP
    bool changed = false;
    std::uint8_t snapshot_priority = kPriorityDefault;
    std::uint32_t snapshot_sequence = 0;
    TimeNs snapshot_stamp_ns = 0;
    SenderId snapshot_sender = 0;
    MergeCounters counters;
    Sender senders[kSendersPerUniverseMax];  // the first sender_count are there, in no order
  };
  // Of a universe with LTP slots.
  struct LtpSlots {
    SlotSet slots;
    // Running number of the frame that last changed the slot; [place of the sender][slot].
    std::uint64_t changed_at[kSendersPerUniverseMax][kSlotCountMax] = {};
  };

  [[nodiscard]] static int highest_priority(const PerUniverse& universe);  // -1: nobody is there
  [[nodiscard]] static bool changed_last(const PerUniverse& universe, const Sender& sender);
  [[nodiscard]] std::uint8_t* levels_of(int index, int place) const;
  [[nodiscard]] static Sender* find(PerUniverse& universe, SourceId source, SenderId sender);
  [[nodiscard]] Sender* add(int index, const FrameView& frame, SourceId source);
  Received receive_priorities(int index, const FrameView& frame, TimeNs now_ns, SourceId source);
  void drop_priorities(int index, Sender& sender);
  void set_by_slot(int index);
  bool resolve_by_slot(int index);
  [[nodiscard]] std::uint8_t* priorities_of(int index, int place) const;
  [[nodiscard]] DurationNs silence_of(const FrameView& frame) const;
  void remove(int index, int sender);
  void mark_changed(int index);

  MergeOptions options_;
  std::vector<PerUniverse> universes_;
  std::unique_ptr<std::uint8_t[]> snapshots_;  // count() x 512
  // 8 x count() x 512, not initialised: block [place][universe] is cleared when a sender takes it, so that memory which
  // no sender needs is never touched.
  std::unique_ptr<std::uint8_t[]> levels_;
  std::unique_ptr<std::uint8_t[]> priorities_;        // likewise, and touched by senders that have priorities only
  std::vector<std::unique_ptr<LtpSlots>> ltp_slots_;  // per universe; null: none
  std::vector<int> changed_;
  TimeNs next_expiry_ns_ = kTimeNever;
  std::uint64_t frame_number_ = 0;
};

}  // namespace footlight
