// Time: int64 nanoseconds on one monotonic clock, passed in as arguments. Only SystemClock (sim/system_clock.h) reads
// the operating system's clock; tests use tests/support/fake_clock.h.
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
  // Returns at or after the absolute deadline, or at once if it has passed. Absolute, so that delays never add up.
  virtual void sleep_until_ns(TimeNs deadline_ns) = 0;
};

}  // namespace footlight
