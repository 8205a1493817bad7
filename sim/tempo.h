// The speed of made-up patterns (sim/pattern.h) in beats a minute: set as a number, or tapped.
//
// From the second tap on, the speed is the mean of the last taps, at most kTapsMax of them:
//
//   60 s x (n - 1) / (time of the last tap - time of the first one)
//
// A pause of more than kTapPauseNs begins anew, so the slowest speed that can be tapped is kTempoMin. A tap sooner than
// kTapBounceNs after the last one is a key that bounces, and counts for nothing, so the fastest is kTempoMax.
//
// A beat begins with each tap from the second on: the nearest beat is moved there. A set speed moves no beat that has
// begun. One beat lasts a whole number of nanoseconds, so beats are counted without an error that adds up.
//
// Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight {

inline constexpr double kTempoDefault = 120;  // beats a minute
inline constexpr double kTempoMin = 30;
inline constexpr double kTempoMax = 300;
inline constexpr DurationNs kTapPauseNs = 2 * kNsPerS;
inline constexpr DurationNs kTapBounceNs = 200 * kNsPerMs;
inline constexpr std::size_t kTapsMax = 8;

// A time in beats since the clock's zero at the default speed: how many have begun, and the share of the current one.
struct TempoBeat {
  std::int64_t count = 0;
  double share = 0;  // [0, 1)
  friend bool operator==(const TempoBeat&, const TempoBeat&) = default;
};

class Tempo {
 public:
  void tap(TimeNs now_ns);
  // kBadInput names the range.
  Status set(double beats_a_minute, TimeNs now_ns);
  [[nodiscard]] double beats_a_minute() const;
  [[nodiscard]] TempoBeat at(TimeNs now_ns) const;

 private:
  [[nodiscard]] TempoBeat beat_at(TimeNs now_ns) const;  // with the mutex held

  mutable std::mutex mutex_;  // guards all
  DurationNs beat_ns_ = kNsPerS / 2;
  TimeNs anchor_ns_ = 0;  // when beat anchor_ began
  std::int64_t anchor_ = 0;
  std::deque<TimeNs> taps_;
};

}  // namespace footlight
