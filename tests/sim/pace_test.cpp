#include "sim/pace.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

using namespace footlight;

TEST_CASE("endless demand at 44 Hz for ten hours gives 44 times 36000 events, each within 1 ns of its due time") {
  constexpr double kRateHz = 44.0;
  constexpr double kPeriodNs = 1e9 / kRateHz;
  Pace pace;
  const TimeNs start_ns = 123'456'789'012'345;  // a day and a half after boot
  TimeNs now_ns = start_ns;
  std::int64_t events = 0;
  double error_ns_max = 0.0;
  while (now_ns - start_ns < 36'000 * kNsPerS) {
    pace.happened(now_ns, kPeriodNs);
    ++events;
    const auto exact_ns = static_cast<long double>(events) * 1e9L / 44.0L;
    error_ns_max = std::max(
        error_ns_max, std::abs(static_cast<double>(static_cast<long double>(pace.due_ns() - start_ns) - exact_ns)));
    now_ns = pace.due_ns();
  }
  CHECK(events == 44 * 36'000);
  CHECK(error_ns_max <= 1.0);
}

TEST_CASE("events that are always late by less than a period keep the rate") {
  constexpr double kPeriodNs = 1e9 / 30.0;
  Pace pace;
  TimeNs now_ns = 0;
  std::int64_t events = 0;
  std::uint64_t random = 1;
  while (now_ns < 3'600 * kNsPerS) {
    pace.happened(now_ns, kPeriodNs);
    ++events;
    random = random * 6364136223846793005u + 1442695040888963407u;
    now_ns = pace.due_ns() + static_cast<TimeNs>((random >> 33) % 20'000'000);  // 0 to 20 ms of 33
  }
  CHECK(events >= 30 * 3'600 - 1);
  CHECK(events <= 30 * 3'600 + 1);
}

TEST_CASE("after a pause the next event comes at once and there is no burst to catch up") {
  constexpr double kPeriodNs = 25e6;
  Pace pace;
  CHECK(pace.due_ns() < 0);
  pace.happened(0, kPeriodNs);
  CHECK(pace.due_ns() == 25'000'000);
  const TimeNs late_ns = kNsPerS + 7;
  CHECK(pace.due_ns() <= late_ns);
  pace.happened(late_ns, kPeriodNs);
  CHECK(pace.due_ns() == late_ns + 25'000'000);
}
