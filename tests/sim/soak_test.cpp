#include "tests/sim/soak.h"

#include <doctest/doctest.h>

#include "tests/support/long_tests.h"

using namespace footlight;

// The full rate of faults, about one a second, and 3 rounds a second instead of 44: a fixed amount of work, however
// busy the machine is. `soak --hours 24 --rate 44` in this folder runs a day at the full rate.
TEST_CASE("in hours of faults every lost frame is counted, no working sink is stale and memory does not grow") {
  const double hours = testing::runs_long_tests() ? 24 : 4;
  const testing::SoakReport report = testing::run_soak({.hours = hours, .rate_hz = 3.0, .seed = 1});
  for (const std::string& offence : report.offences) CHECK_MESSAGE(false, offence);
  CHECK(report.memory_growth_bytes < 1'024);  // error texts differ in length
  // Each hour had enough of everything.
  const auto each_hour = [&](std::uint64_t count) { return static_cast<double>(count) / hours; };
  CHECK(each_hour(report.minutes_checked) >= 58);
  CHECK(each_hour(report.frames) > 170'000);
  CHECK(each_hour(report.snapshots) > 170'000);
  for (const std::uint64_t count :
       {report.silences, report.endings, report.bursts, report.priority_changes, report.claim_changes,
        report.source_failures, report.sink_failures, report.stalls, report.jumps, report.takeovers})
    CHECK(each_hour(count) > 42);
  CHECK(each_hour(report.reloads) > 21);
}

TEST_CASE("minutes at the full rate, from each of three seeds, pass the same checks") {
  const double minutes = testing::runs_long_tests() ? 12 : 4;
  for (const std::uint64_t seed : {2u, 3u, 4u}) {
    const testing::SoakReport report = testing::run_soak({.hours = minutes / 60, .rate_hz = 44.0, .seed = seed});
    for (const std::string& offence : report.offences) CHECK_MESSAGE(false, offence);
    CHECK(static_cast<double>(report.frames) > 42'000 * minutes);
  }
}
