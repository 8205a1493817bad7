// A clock that moves only when set, for tests with device threads: safe to read from any of them.
#pragma once

#include <atomic>

#include "sim/core/clock.h"

namespace footlight::testing {

class SharedFakeClock final : public Clock {
 public:
  explicit SharedFakeClock(TimeNs start_ns = kNsPerS) : now_ns_(start_ns) {}
  TimeNs now_ns() override { return now_ns_; }
  void sleep_until_ns(TimeNs deadline_ns) override {
    TimeNs seen_ns = now_ns_;
    while (seen_ns < deadline_ns && !now_ns_.compare_exchange_weak(seen_ns, deadline_ns)) {
    }
  }
  void advance_ns(DurationNs by_ns) { now_ns_ += by_ns; }

 private:
  std::atomic<TimeNs> now_ns_;
};

}  // namespace footlight::testing
