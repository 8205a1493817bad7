// Time: int64 nanoseconds on one monotonic clock, passed in. Nothing but SystemClock (sim/system_clock.h) asks the
// operating system for the time; tests use tests/support/fake_clock.h.
#pragma once

#include <cstdint>

namespace footlight {

using TimeNs = std::int64_t;  // a point in time, nanoseconds since an arbitrary origin (CLOCK_MONOTONIC in SystemClock)
using DurationNs = std::int64_t;  // a difference of two TimeNs

inline constexpr DurationNs kNsPerUs = 1'000;
inline constexpr DurationNs kNsPerMs = 1'000'000;
inline constexpr DurationNs kNsPerS = 1'000'000'000;
inline constexpr TimeNs kTimeNever = INT64_MAX;

class Clock {
 public:
  virtual ~Clock() = default;
  virtual TimeNs now_ns() = 0;
  // Returns at or after the absolute deadline; at once where it has passed. Absolute, so that lateness never adds up.
  virtual void sleep_until_ns(TimeNs deadline_ns) = 0;
};

}  // namespace footlight
