#include "sim/system_clock.h"

#include <cerrno>
#include <ctime>

#include "sim/core/check.h"

namespace footlight {

TimeNs SystemClock::now_ns() {
  timespec now{};
  FL_CHECK_EQ(clock_gettime(CLOCK_MONOTONIC, &now), 0);
  return static_cast<TimeNs>(now.tv_sec) * kNsPerS + now.tv_nsec;
}

void SystemClock::sleep_until_ns(TimeNs deadline_ns) {
  if (deadline_ns <= 0) return;
  timespec deadline{};
  deadline.tv_sec = static_cast<time_t>(deadline_ns / kNsPerS);
  deadline.tv_nsec = static_cast<long>(deadline_ns % kNsPerS);
  // A signal ends the sleep early. The deadline is absolute, so the sleep is repeated.
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace footlight
