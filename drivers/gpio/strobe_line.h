// One input line: edges with times in, a slot value and deadlines out. No I/O, no clock of its own, no allocation after
// the constructor.
//
//   StrobeLine line({.mode = StrobeMode::kOneShot, .hold_ns = 80 * kNsPerMs});
//   line.start(level, now_ns);                 // the level that is there when the line is opened
//   line.edge(true, stamp_ns);                 // oldest first, with the stamps of the kernel
//   line.advance(now_ns);                      // at next_deadline_ns(), and after every batch of edges
//   slots[address - 1] = line.value();
//
// Debounce: the leading edge counts at once, at its own time. For debounce_ns after it the contact may bounce as it
// likes; then the level decides, and if it is another than the accepted one, that is an edge at that moment, which
// opens a window of its own. So a press costs no latency, and a release is late by debounce_ns at most, when it falls
// into the window of its press.
//
// Lost edges: the kernel reports rising and falling in turn. Two of a kind in a row mean that the one between was lost
// or too short to be seen; it is taken to have happened at the time of the second. read_level() repairs what a queue
// that ran over has lost.
//
// The cap: a flash is a change from off to on. Never more than N begin within any window of W, where N is the whole
// part of flashes_hz_max (1 at least) and W = N / flashes_hz_max; with 4: no more than 4 in any one second, wherever it
// begins. A flash that the cap forbids is left out in one-shot; in follow and toggle it begins as soon as the cap
// allows, if it is still wanted then. In rate the value is that of the cap.
//
// Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/core/clock.h"

namespace footlight::drivers {

enum class StrobeMode : std::uint8_t {
  kFollow,   // on while the line is active, and for hold_ns at least
  kOneShot,  // a rising edge turns on for hold_ns
  kToggle,   // a rising edge turns on or off
  kRate,     // the time between rising edges sets the value, by rate_points
};

// What a rising edge does during the hold of a one-shot.
enum class Retrigger : std::uint8_t {
  kExtend,  // the hold begins anew
  kIgnore,  // nothing
};

// Edges that come hz times a second set the slot to value.
struct RatePoint {
  double hz = 0.0;
  std::uint8_t value = 0;
  friend bool operator==(const RatePoint&, const RatePoint&) = default;
};

// UK Health and Safety Executive, for strobes at public events: no more than four flashes a second. docs/gpio.md says
// what that is worth.
inline constexpr double kFlashesMaxDefaultHz = 4.0;
inline constexpr double kFlashesMaxLimitHz = 60.0;
// Longer than a DMX frame of 512 slots, 22.7 ms, so that a short pulse is on the wire once at least.
inline constexpr DurationNs kFollowHoldDefaultNs = 25 * kNsPerMs;
inline constexpr DurationNs kOneShotHoldDefaultNs = 80 * kNsPerMs;

struct StrobeConfig {
  StrobeMode mode = StrobeMode::kFollow;
  DurationNs hold_ns = kFollowHoldDefaultNs;  // >= 0; follow: the shortest flash; one-shot: every flash
  Retrigger retrigger = Retrigger::kExtend;
  DurationNs debounce_ns = 0;  // >= 0; about 5 ms for contacts, 0 for optocouplers and logic
  std::uint8_t on = 255;
  std::uint8_t off = 0;
  // 0 to kFlashesMaxLimitHz; 0: no cap.
  double flashes_hz_max = kFlashesMaxDefaultHz;
  // Rate: straight lines between these, ends kept beyond them. Not empty, hz above 0 and rising. When no edge has come
  // for two periods the value is `off`; edges slower than half the first hz are none.
  std::vector<RatePoint> rate_points = {{1.0, 1}, {25.0, 255}};
  friend bool operator==(const StrobeConfig&, const StrobeConfig&) = default;
};

struct StrobeCounters {
  std::uint64_t edges = 0;     // as they came, bounces included
  std::uint64_t bounces = 0;   // of those, inside a debounce window
  std::uint64_t lost = 0;      // that must have been between two of a kind
  std::uint64_t repaired = 0;  // levels that read_level() found to be another than the edges said
  std::uint64_t flashes = 0;   // changes from off to on
  std::uint64_t capped = 0;    // flashes that the cap has forbidden or put off; rate: values that it has lowered
};

class StrobeLine {
 public:
  explicit StrobeLine(StrobeConfig config);

  // The line is there, at this level: follow shows it; the other modes wait for an edge. Forgets the past except the
  // cap's.
  void start(bool level, TimeNs now_ns);
  // The line is gone: off, whatever the mode.
  void stop(TimeNs now_ns);
  // `stamp_ns`: when it happened. One before its predecessor counts as of the same time.
  void edge(bool level, TimeNs stamp_ns);
  // What the line reads at this moment, after all edges that could be read. Ends a debounce window that is due.
  void read_level(bool level, TimeNs now_ns);
  // Everything that is due until now.
  void advance(TimeNs now_ns);

  // When advance() has something to do; kTimeNever: nothing.
  [[nodiscard]] TimeNs next_deadline_ns() const;
  // A debounce window ends until then: read_level() is asked for before advance().
  [[nodiscard]] bool wants_level(TimeNs now_ns) const { return settle_ns_ <= now_ns; }
  [[nodiscard]] std::uint8_t value() const { return value_; }
  // When what made the value happened: the stamp of an edge, or a deadline.
  [[nodiscard]] TimeNs changed_ns() const { return changed_ns_; }
  [[nodiscard]] bool level() const { return accepted_; }
  [[nodiscard]] const StrobeCounters& counters() const { return counters_; }
  [[nodiscard]] const StrobeConfig& config() const { return config_; }

 private:
  void take(bool level, TimeNs time_ns);    // through the debouncer
  void accept(bool level, TimeNs time_ns);  // what the modes see
  void rise(TimeNs time_ns);
  void fall(TimeNs time_ns);
  void rise_rate(TimeNs time_ns);
  bool turn_on(TimeNs time_ns);  // false: the cap forbids it
  void turn_off(TimeNs time_ns);
  void set_value(std::uint8_t value, TimeNs time_ns);
  [[nodiscard]] TimeNs allowed_ns() const;  // when the cap lets the next flash begin
  [[nodiscard]] std::uint8_t value_of_hz(double hz) const;

  StrobeConfig config_;
  StrobeCounters counters_;
  // The cap: the begins of the last flashes, a ring of flash_count_max_ places.
  std::array<TimeNs, static_cast<std::size_t>(kFlashesMaxLimitHz)> flashes_ns_{};
  std::size_t flash_count_max_ = 0;  // 0: no cap
  DurationNs flash_window_ns_ = 0;
  std::uint64_t flashes_begun_ = 0;

  TimeNs last_ns_ = INT64_MIN;     // of the last edge
  bool raw_ = false;               // as the last edge or reading said
  bool accepted_ = false;          // after the debouncer
  TimeNs settle_ns_ = kTimeNever;  // end of the debounce window
  TimeNs read_ns_ = INT64_MIN;     // when read_level() was ahead of the edges

  bool on_ = false;
  TimeNs on_since_ns_ = 0;
  TimeNs off_ns_ = kTimeNever;      // when to turn off
  TimeNs pending_ns_ = kTimeNever;  // when to turn on, the cap allowing
  TimeNs last_rise_ns_ = INT64_MIN;
  std::uint8_t value_ = 0;
  TimeNs changed_ns_ = 0;
};

}  // namespace footlight::drivers
