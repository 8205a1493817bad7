// The operating system's clock: CLOCK_MONOTONIC, which no time server adjusts in steps.
//
// Threads: any. Cost: one vDSO call, no system call, for now_ns().
#pragma once

#include "sim/core/clock.h"

namespace footlight {

class SystemClock final : public Clock {
 public:
  TimeNs now_ns() override;
  void sleep_until_ns(TimeNs deadline_ns) override;
};

}  // namespace footlight
