// The logic of one input line: converts timed edges to a slot value and deadlines. No I/O, no clock of its own, no
// allocation after the constructor.
//
//   StrobeLine line({.mode = StrobeMode::kOneShot, .hold_ns = 80 * kNsPerMs});
//   line.start(level, now_ns);                 // the level when the line is opened
//   line.edge(true, stamp_ns);                 // oldest first, with the stamps of the kernel
//   line.advance(now_ns);                      // at next_deadline_ns(), and after every batch of edges
//   slots[address - 1] = line.value();
//
// Debounce: the leading edge counts at once, at its own time. Further edges within debounce_ns after it are ignored.
// Then the level is read. If it differs from the accepted one, that is an edge at that moment, which opens a window of
// its own. So a press has no latency. A release is at most debounce_ns late, if it falls into the window of its press.
//
// Lost edges: the kernel reports rising and falling edges alternately. Two of a kind in a row mean that the one between
// was lost or too short. It is assumed at the time of the second. read_level() corrects the level after a queue
// overflow.
//
// The cap: a flash is a change from off to on. At most N flashes begin within any window of W, where N is the whole
// part of flashes_hz_max (1 at least) and W = N / flashes_hz_max. With 4: no more than 4 in any one second. In
// one-shot, a flash that exceeds the cap is left out. In follow and toggle, it begins as soon as the cap allows, if the
// line is still on. In rate, the value is limited to the cap.
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
  kRate,     // the rate of rising edges sets the value, by rate_points
};

// The effect of a rising edge during the hold of a one-shot.
enum class Retrigger : std::uint8_t {
  kExtend,  // the hold starts again
  kIgnore,  // nothing
};

// Edges at this rate set the slot to value.
struct RatePoint {
  double hz = 0.0;
  std::uint8_t value = 0;
  friend bool operator==(const RatePoint&, const RatePoint&) = default;
};

// UK Health and Safety Executive, for strobes at public events: no more than four flashes a second. docs/gpio.md
// discusses this limit.
inline constexpr double kFlashesMaxDefaultHz = 4.0;
inline constexpr double kFlashesMaxLimitHz = 60.0;
// Longer than a DMX frame of 512 slots (22.7 ms), so that a short pulse is on the wire at least once.
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
  // Rate: linear between these points, constant beyond them. Not empty, hz above 0 and rising. The value is `off` after
  // two periods without an edge; edges slower than half the first hz do not count.
  std::vector<RatePoint> rate_points = {{1.0, 1}, {25.0, 255}};
  friend bool operator==(const StrobeConfig&, const StrobeConfig&) = default;
};

struct StrobeCounters {
  std::uint64_t edges = 0;     // as received, bounces included
  std::uint64_t bounces = 0;   // of those, inside a debounce window
  std::uint64_t lost = 0;      // assumed between two of a kind
  std::uint64_t repaired = 0;  // levels that read_level() found different from the edges
  std::uint64_t flashes = 0;   // changes from off to on
  std::uint64_t capped = 0;    // flashes that the cap has left out or delayed; rate: values that it has lowered
};

class StrobeLine {
 public:
  explicit StrobeLine(StrobeConfig config);

  // The line is present, at this level: follow shows it; the other modes wait for an edge. Resets everything except the
  // cap.
  void start(bool level, TimeNs now_ns);
  // The line is gone: off in every mode.
  void stop(TimeNs now_ns);
  // `stamp_ns`: when it happened. A stamp before the last one counts as that time.
  void edge(bool level, TimeNs stamp_ns);
  // The level read now, after all readable edges. Ends a debounce window that is due.
  void read_level(bool level, TimeNs now_ns);
  // Handles everything due until now.
  void advance(TimeNs now_ns);

  // When advance() has work; kTimeNever: no deadline.
  [[nodiscard]] TimeNs next_deadline_ns() const;
  // A debounce window ends by then: call read_level() before advance().
  [[nodiscard]] bool needs_level(TimeNs now_ns) const { return settle_ns_ <= now_ns; }
  [[nodiscard]] std::uint8_t value() const { return value_; }
  // The time of the value's cause: the stamp of an edge, or a deadline.
  [[nodiscard]] TimeNs changed_ns() const { return changed_ns_; }
  [[nodiscard]] bool level() const { return accepted_; }
  [[nodiscard]] const StrobeCounters& counters() const { return counters_; }
  [[nodiscard]] const StrobeConfig& config() const { return config_; }

 private:
  void take(bool level, TimeNs time_ns);    // through the debouncer
  void accept(bool level, TimeNs time_ns);  // changes that the modes see
  void rise(TimeNs time_ns);
  void fall(TimeNs time_ns);
  void rise_rate(TimeNs time_ns);
  bool turn_on(TimeNs time_ns);  // false: the cap does not allow it
  void turn_off(TimeNs time_ns);
  void set_value(std::uint8_t value, TimeNs time_ns);
  [[nodiscard]] TimeNs allowed_ns() const;  // when the cap allows the next flash
  [[nodiscard]] std::uint8_t value_of_hz(double hz) const;

  StrobeConfig config_;
  StrobeCounters counters_;
  // The cap: the starts of the last flashes, a ring of flash_count_max_ places.
  std::array<TimeNs, static_cast<std::size_t>(kFlashesMaxLimitHz)> flashes_ns_{};
  std::size_t flash_count_max_ = 0;  // 0: no cap
  DurationNs flash_window_ns_ = 0;
  std::uint64_t flashes_begun_ = 0;

  TimeNs last_ns_ = INT64_MIN;     // of the last edge
  bool raw_ = false;               // from the last edge or reading
  bool accepted_ = false;          // after the debouncer
  TimeNs settle_ns_ = kTimeNever;  // end of the debounce window
  TimeNs read_ns_ = INT64_MIN;     // when read_level() differed from the edges

  bool on_ = false;
  TimeNs on_since_ns_ = 0;
  TimeNs off_ns_ = kTimeNever;      // when to turn off
  TimeNs pending_ns_ = kTimeNever;  // when to turn on, if the cap allows
  TimeNs last_rise_ns_ = INT64_MIN;
  std::uint8_t value_ = 0;
  TimeNs changed_ns_ = 0;
};

}  // namespace footlight::drivers
