#include "drivers/gpio/gpio_chip.h"

#include <algorithm>

namespace footlight::drivers {

TimeNs monotonic_stamp_ns(std::int64_t stamp_ns, TimeNs monotonic_now_ns, std::int64_t realtime_now_ns) {
  const DurationNs age_ns = monotonic_now_ns - stamp_ns;
  const DurationNs realtime_age_ns = realtime_now_ns - stamp_ns;
  const bool is_realtime = (realtime_age_ns < 0 ? -realtime_age_ns : realtime_age_ns) < (age_ns < 0 ? -age_ns : age_ns);
  return monotonic_now_ns - std::max<DurationNs>(is_realtime ? realtime_age_ns : age_ns, 0);
}

}  // namespace footlight::drivers
