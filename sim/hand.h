// Levels set by hand: a source whose slots are set, faded, released and blacked out by commands, without a console.
//
// A command comes from `footlight set`, a phone or a fader; all make a HandCommand. The source owns single slots: those
// that were set have the priority of their command (frames with start code 0xDD), all others are not claimed. A slot
// that is released goes back to the other senders; if there are none, it keeps its level, as the merge does when any
// sender stops.
//
// Blackout is a sender of its own with kPriorityOverride, so it is above every other sender. So add the source to the
// pump with SourceRole{.may_override = true}. Levels that are set during
// a blackout show when it ends. Slots that no sender claims at its end get the levels that they had at its start.
//
// A hold is a dead man's switch: it must be renewed in time, or blackout begins. Only kLift ends a blackout.
//
// Fades are computed from their start, end and the time of the call, in integers: no error adds up, the last level is
// exact, and a late call gives the level of its own time. While a fade runs, the source asks to be polled 44 times a
// second (E1.11's highest rate of full universes) and at the end of each fade; at other times it has no deadline. A
// level that is set during a fade replaces it; a fade starts from the level at that time.
//
// Threads: the pump's. Nothing allocates, except that the first command for a universe makes its board, and that a
// command with more fades than ever before makes room for them.
#pragma once

#include <array>
#include <atomic>
#include <bitset>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/universes.h"

namespace footlight {

// Above the 100 of consoles, so that a command has an effect; below 200, so that a console may be set to win.
inline constexpr std::uint8_t kHandPriorityDefault = 150;
inline constexpr int kHandSlotsMax = 4;                             // of one number
inline constexpr DurationNs kHandFadeMaxNs = kNsPerS * 3'600 * 24;  // a day
inline constexpr int kHandFadeRateHz = 44;
inline constexpr DurationNs kHandHoldMinNs = 200 * kNsPerMs;
inline constexpr DurationNs kHandHoldMaxNs = 3'600 * kNsPerS;

// A number in one to four slots, the most significant byte first.
struct HandLevel {
  Universe universe = 1;
  int count = 1;
  std::array<std::uint16_t, kHandSlotsMax> slots = {};  // counted from 0
  std::uint32_t value = 0;
  bool jumps = false;  // a fade sets it at once: a place on a wheel
  friend bool operator==(const HandLevel&, const HandLevel&) = default;
};
// The highest value of a number in `count` slots.
[[nodiscard]] constexpr std::uint32_t hand_value_max(int count) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << (8 * count)) - 1);
}

enum class HandAction : std::uint8_t {
  kSet,         // levels, over_ns, priority
  kRelease,     // levels, without their values. This and kBlackout skip universes that are not part of the bridge
  kReleaseAll,  // every slot; blackout stays
  kBlackout,    // levels: only these slots, at these levels; none: every slot of every universe at 0. Adds to a
                // blackout that is on
  kLift,        // ends blackout and hold
  kHold,        // begins a hold that lasts over_ns; an error during another one
  kRenew,       // continues it for over_ns from now; an error if there is none
  kTempo,       // beats_a_minute; 0: a tap. It is the taker's, no source's: HandSource ignores it
};

struct HandCommand {
  HandAction action = HandAction::kSet;
  DurationNs over_ns = 0;  // kSet: duration of the fade; 0: at once
  std::uint8_t priority = kHandPriorityDefault;
  std::vector<HandLevel> levels;
  double beats_a_minute = 0;  // kTempo
  friend bool operator==(const HandCommand&, const HandCommand&) = default;
};

// A scene to recall: names and paths as in a control map.
struct SceneCall {
  std::string name;
  std::string file;  // of scenes
  std::string rig;   // for fixtures in it; "": none
  DurationNs over_ns = 0;
  std::uint8_t priority = kHandPriorityDefault;
};

// What ports that only control the hand (OSC, MIDI) speak to. Called on the pump's thread, also within a tick.
class HandTaker {
 public:
  virtual ~HandTaker() = default;
  virtual Status take(const HandCommand& command, TimeNs now_ns) = 0;
  // Returns at once. The file is read on another thread; errors are reported as events.
  virtual void recall(const SceneCall& call) = 0;
  [[nodiscard]] virtual bool blacked_out() const = 0;
};
// Finds out what a control sends: the next one that moves is kept and does nothing. Threads: any.
class HandLearner {
 public:
  struct Moved {
    std::string port;   // its name
    std::string input;  // as in a control map: "cc 1 7"
  };
  void begin();
  // Forgets what has moved, too.
  void end();
  [[nodiscard]] bool waits() const { return waits_.load(std::memory_order_relaxed); }
  // Of the ports, while waits(). False: another one was first.
  bool take(std::string_view port, std::string input);
  // The one that moved, once.
  [[nodiscard]] std::optional<Moved> moved();

 private:
  std::atomic<bool> waits_ = false;
  std::mutex mutex_;
  std::optional<Moved> moved_;  // guarded by mutex_
};
// Shared by the ports and the bridge, which sets it while it runs. nullptr: commands are lost.
struct HandLink {
  HandTaker* taker = nullptr;
  HandLearner learner;
};

// What the hand has of one universe.
struct HandSlots {
  Universe universe = 0;
  Slots levels = {};
  Slots priorities = {};  // 0: the hand does not have the slot
  Slots dark_levels = {};
  std::bitset<kSlotCountMax> dark;  // slots of a blackout, which have dark_levels
};

// What the hand has, for a reader that shows it over levels which no pump merges. Threads: publish() belongs to the
// pump's, the rest to one other.
class HandShown {
 public:
  void publish(std::vector<HandSlots> slots);
  // Takes the newest. What follows is as of the last call.
  void take();
  [[nodiscard]] bool any() const { return !taken_.empty(); }
  [[nodiscard]] std::size_t held_count() const;  // slots
  [[nodiscard]] bool dark() const;
  // levels: 512 for each of `universes`, which are ascending. They count as one sender with base_priority that has
  // every slot. Equal priorities: the higher level.
  void overlay(std::span<const Universe> universes, std::span<std::uint8_t> levels, std::uint8_t base_priority) const;
  // The blackout alone, which is above everything.
  void darken(std::span<const Universe> universes, std::span<std::uint8_t> levels) const;

 private:
  std::mutex mutex_;
  std::vector<HandSlots> published_;  // guarded by mutex_
  bool fresh_ = false;                // likewise
  std::vector<HandSlots> taken_;      // of the reader
};

// The level of a fade at a time, rounded to the nearest integer, halves up. `elapsed_ns`: 0 to over_ns.
[[nodiscard]] std::uint32_t faded_value(std::uint32_t from, std::uint32_t to, DurationNs elapsed_ns,
                                        DurationNs over_ns);

class HandSource final : public Source {
 public:
  // `buffer`: of the pump. Its universes are those that can be set.
  explicit HandSource(std::shared_ptr<const Universes> buffer);

  // Keeps `shown` up to date from the next poll() on. It outlives this; nullptr: none.
  void show_in(HandShown* shown) { shown_ = shown; }

  // Checks the whole command first; one with an error changes nothing. Shown at the next poll(), which is due at once.
  // Returns the number of slots that it names. Errors: kBadInput, kNotFound (a universe that is not part of the
  // bridge; no hold to renew).
  Result<int> apply(const HandCommand& command, TimeNs now_ns);
  // The pump has moved to another buffer: levels of universes that are not in it are dropped, and a blackout of
  // everything covers the new ones. Everything is sent again, so remove the source from the pump before and add it
  // after.
  void move_to(std::shared_ptr<const Universes> buffer);

  struct Held {
    Universe universe = 0;
    Address address = 0;
    std::uint8_t level = 0;
    std::uint8_t priority = 0;
  };
  [[nodiscard]] std::vector<Held> held() const;
  [[nodiscard]] bool blacked_out() const { return black_all_ || black_slots_ > 0; }
  [[nodiscard]] bool holding() const { return hold_until_ns_ != kTimeNever; }
  [[nodiscard]] std::size_t fade_count() const { return fades_.size(); }

  [[nodiscard]] std::string name() const override { return "by hand"; }
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::optional<PortNotice> take_notice() override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override { return buffer_->numbers(); }
  [[nodiscard]] std::string sender_text(SenderId sender) const override;

 private:
  // What one of the two senders says about a universe.
  struct Layer {
    Slots levels = {};
    Slots priorities = {};  // 0: not claimed
    bool levels_changed = false;
    bool priorities_changed = false;
    bool sending = false;  // the merge has this sender
  };
  struct Board {
    Universe universe = 0;
    Layer hand;
    Layer black;
    Slots look = {};                                     // merged levels at the start of the blackout
    std::bitset<kSlotCountMax> leaving;                  // released before the hand's levels were sent
    std::array<std::uint32_t, kSlotCountMax> fade = {};  // number of the fade of the slot; 0: none
  };
  struct Fade {
    std::uint32_t number = 0;
    Board* board = nullptr;
    HandLevel to;
    std::uint32_t from = 0;
    TimeNs start_ns = 0;
    DurationNs over_ns = 0;
  };

  [[nodiscard]] Status check(const HandCommand& command) const;
  Board& board_of(Universe universe);
  [[nodiscard]] Slots merged(const Board& board) const;
  void set(const HandCommand& command, TimeNs now_ns);
  void release(const HandCommand& command);
  void release_slot(Board& board, std::size_t slot);
  void let_leave();
  [[nodiscard]] bool has(Universe universe) const { return buffer_->index_of(universe) >= 0; }
  void begin_blackout(std::span<const HandLevel> only);
  void black_out(Board& board, const Slots& look, std::size_t slot, std::uint8_t level);
  void black_out_everything();
  void lift();
  void advance(TimeNs now_ns);
  void deliver(Layer& layer, Universe universe, SenderId sender, TimeNs now_ns, FrameReceiver& receiver);
  void give_up_looks(Board& board, TimeNs now_ns, FrameReceiver& receiver);
  void send(const Layer& layer, Universe universe, SenderId sender, TimeNs now_ns, std::uint8_t start_code,
            FrameReceiver& receiver);
  [[nodiscard]] std::vector<HandSlots> slots() const;

  std::shared_ptr<const Universes> buffer_;
  std::vector<std::unique_ptr<Board>> boards_;  // sorted by universe
  std::vector<Fade> fades_;
  std::uint32_t last_fade_ = 0;
  TimeNs grid_start_ns_ = 0;           // of the 44 polls a second
  TimeNs fade_due_ns_ = kTimeNever;    // next poll for the fades
  TimeNs hold_until_ns_ = kTimeNever;  // of the dead man's switch
  TimeNs leave_ns_ = kTimeNever;       // when leaving slots are given up
  bool black_all_ = false;             // blackout of everything, also of universes that come later
  std::int64_t black_slots_ = 0;       // slots that are blacked out
  bool dirty_ = false;                 // the next poll() has something to send
  HandShown* shown_ = nullptr;
  std::uint32_t sequence_ = 0;
  PortCounters counters_;
  std::deque<PortNotice> notices_;
};

}  // namespace footlight
