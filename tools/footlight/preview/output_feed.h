// The levels of the picture as a source of a pump whose sinks drive real lamps, and how these lamps are left
// (decision 0140).
//
// The window's thread gives the levels once a turn, however long pictures take. The pump's thread passes the newest
// ones on kOutputRateHz times a second. In a blackout it passes zeros instead. If the window's thread gave nothing for
// kSilenceMaxNs while an output is armed, a blackout begins, since the user can then not begin one.
//
// need_hold() makes it a dead man's switch: lamps are lit only while a key is held, and the window says so each turn.
//
// Threads: give() belongs to the window's thread, what is marked so to the pump's. Neither waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/core/ports.h"
#include "sim/universes.h"
#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

class OutputFeed final : public Source {
 public:
  static constexpr int kOutputRateHz = 44;                       // E1.11's highest rate of full universes
  static constexpr DurationNs kSilenceMaxNs = 2'500 * kNsPerMs;  // after which E1.31 counts a sender as lost
  static constexpr DurationNs kHeldMaxNs = 500 * kNsPerMs;       // for which a key that was held counts as held

  // universes: those of the outputs, at least one.
  explicit OutputFeed(std::span<const Universe> universes) : given_(universes) {}

  // universes: those of the rig, ascending; levels: 512 for each of them. sendable: those of them that real lamps have,
  // ascending. Zeros are sent of a universe that was sendable before and is not any more. Levels that are missing
  // count as unchanged.
  void give(TimeNs now_ns, std::span<const Universe> universes, std::span<const std::uint8_t> levels,
            std::span<const Universe> sendable);

  // Any thread. From the next poll() on.
  void black_out() { darkness_.store(Darkness::kAsked); }
  // Ends any blackout. For the window's thread, which is alive.
  void lift(TimeNs now_ns);
  [[nodiscard]] Darkness darkness() const;

  // The window's thread. on: zeros are sent but while a key is held, from the next poll() on, and first of all the key
  // has to go up. Off again while it is not held: a blackout that the user ends.
  void need_hold(bool on);
  // Once a turn: whether the key is held. If this says nothing for kHeldMaxNs, the key has to go up and down again.
  void hold(TimeNs now_ns, bool held);

  // The pump's thread. One more or one less output is armed. Without any, nothing is passed on.
  void count_armed(int change);
  // The next poll() is due at once.
  void hurry() { due_ns_ = 0; }

  [[nodiscard]] std::string name() const override { return "picture"; }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return armed_ > 0 ? due_ns_ : kTimeNever; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {}; }
  [[nodiscard]] std::span<const Universe> universes() const override { return given_.numbers(); }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;

 private:
  Universes given_;                   // written by the window's thread
  std::atomic<TimeNs> given_ns_ = 0;  // of the last give() or lift()
  std::atomic<Darkness> darkness_ = Darkness::kNone;
  enum class Hold : std::uint8_t {
    kNotNeeded,
    kWaits,  // for the key to go up
    kUp,
    kDown,
  };
  void end_old_hold(TimeNs now_ns);
  std::atomic<Hold> hold_ = Hold::kNotNeeded;
  std::atomic<TimeNs> held_ns_ = 0;  // when hold() said so last

  // The pump's thread.
  int armed_ = 0;
  TimeNs due_ns_ = 0;
  std::uint32_t sequence_ = 0;
};

// The sink with another name and another end: when it is closed, the universes that it has sent get zeros first. They
// are sent four times, as often as network sinks send a change, since a datagram may be lost.
[[nodiscard]] std::unique_ptr<Sink> ending_dark(std::unique_ptr<Sink> sink, std::string name);

}  // namespace footlight::tools
