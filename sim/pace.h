// Limits an event to `rate_hz` times a second, on a time grid, so that the rate is met without drift.
//
// Under permanent demand, event n is due at anchor + n periods. An event that is late by less than a period does not
// move those after it. After a pause of a period or more the next event may happen at once and starts a new grid. So
// any span of T seconds has at most T * rate_hz + 2 events.
//
// The n periods are multiplied, not summed: the error is the rounding of a double, 2 ns after 208 days without a pause.
#pragma once

#include <cmath>
#include <cstdint>

#include "sim/core/clock.h"

namespace footlight {

class Pace {
 public:
  // The next event may happen at this time or later. Far in the past before the first event.
  [[nodiscard]] TimeNs due_ns() const { return due_ns_; }

  // Records an event now, at due_ns() or later. `period_ns` > 0, the same in every call.
  void happened(TimeNs now_ns, double period_ns) {
    if (due_ns_ == kLongAgo || static_cast<double>(now_ns - due_ns_) >= period_ns) {
      anchor_ns_ = now_ns;
      count_ = 0;
    }
    ++count_;
    due_ns_ = anchor_ns_ + static_cast<TimeNs>(std::ceil(static_cast<double>(count_) * period_ns));
  }

 private:
  static constexpr TimeNs kLongAgo = INT64_MIN;

  TimeNs anchor_ns_ = 0;
  TimeNs due_ns_ = kLongAgo;
  std::uint64_t count_ = 0;
};

}  // namespace footlight
