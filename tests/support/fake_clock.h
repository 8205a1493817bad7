// A clock that moves only when set. sleep_until_ns() moves it there.
#pragma once

#include "sim/core/clock.h"

namespace footlight::testing {

class FakeClock final : public Clock {
 public:
  explicit FakeClock(TimeNs start_ns = 1'000'000'000) : now_ns_(start_ns) {}
  TimeNs now_ns() override { return now_ns_; }
  void sleep_until_ns(TimeNs deadline_ns) override {
    if (deadline_ns > now_ns_) now_ns_ = deadline_ns;
  }
  void advance_ns(DurationNs by_ns) { now_ns_ += by_ns; }

 private:
  TimeNs now_ns_;
};

}  // namespace footlight::testing
