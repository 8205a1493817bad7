#include "tests/sim/soak.h"

#include <doctest/doctest.h>

using namespace footlight;

// A day at the full rate of faults, about one a second, and 3 rounds a second instead of 44: a fixed amount of work,
// however busy the machine is. `soak --hours 24 --rate 44` in this folder runs the day at the full rate.
TEST_CASE("in a day of faults every lost frame is counted, no working sink is stale and memory does not grow") {
  const testing::SoakReport report = testing::run_soak({.hours = 24.0, .rate_hz = 3.0, .seed = 1});
  for (const std::string& offence : report.offences) CHECK_MESSAGE(false, offence);
  CHECK(report.memory_growth_bytes < 1'024);  // error texts differ in length
  // The day had enough of everything.
  CHECK(report.minutes_checked >= 1'400);
  CHECK(report.frames > 4'000'000);
  CHECK(report.snapshots > 4'000'000);
  for (const std::uint64_t count :
       {report.silences, report.endings, report.bursts, report.priority_changes, report.claim_changes,
        report.source_failures, report.sink_failures, report.stalls, report.jumps, report.takeovers})
    CHECK(count > 1'000);
  CHECK(report.reloads > 500);
}

TEST_CASE("twelve minutes at the full rate, from each of three seeds, pass the same checks") {
  for (const std::uint64_t seed : {2u, 3u, 4u}) {
    const testing::SoakReport report = testing::run_soak({.hours = 0.2, .rate_hz = 44.0, .seed = seed});
    for (const std::string& offence : report.offences) CHECK_MESSAGE(false, offence);
    CHECK(report.frames > 500'000);
  }
}
