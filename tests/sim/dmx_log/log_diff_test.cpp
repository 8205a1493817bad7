#include "sim/dmx_log/log_diff.h"

#include <algorithm>
#include <cmath>

#include "tests/sim/dmx_log/support.h"

namespace footlight {
namespace {

using testing::log_bytes;
using testing::open_log;
using testing::OwnedFrame;
using testing::Random;

constexpr DurationNs kPeriodNs = kNsPerS / 44;

// Universes 1 and 3 at 44 Hz with some jitter: a fade, then constant levels, then a chase that returns to its start.
std::vector<OwnedFrame> show(int rounds = 400) {
  std::vector<OwnedFrame> frames;
  Random random(5);
  for (int round = 0; round < rounds; ++round) {
    for (const Universe universe : {1, 3}) {
      OwnedFrame frame;
      frame.universe = universe;
      frame.time_ns = round * kPeriodNs + universe * 20'000 + static_cast<DurationNs>(random.below(30'000));
      frame.slots.assign(512, 0);
      const int step = std::min(round, 150);
      frame.slots[0] = static_cast<std::uint8_t>(step);
      frame.slots[10] = static_cast<std::uint8_t>(round > 250 ? round % 12 : 0);
      frame.slots[511] = static_cast<std::uint8_t>(universe);
      frames.push_back(frame);
    }
  }
  return frames;
}

LogDiff diff(const std::vector<OwnedFrame>& a, std::vector<OwnedFrame> b, const LogDiffOptions& options = {}) {
  std::stable_sort(b.begin(), b.end(), [](const auto& x, const auto& y) { return x.time_ns < y.time_ns; });
  LogReader reader_a = open_log(log_bytes(a, 100 * kNsPerS));
  LogReader reader_b = open_log(log_bytes(b, 100 * kNsPerS));
  const auto result = diff_logs(reader_a, reader_b, options);
  REQUIRE_MESSAGE(result, result.error().message);
  return *result;
}

}  // namespace

TEST_CASE("a log equals itself, to the nanosecond") {
  LogDiffOptions exact;
  exact.time_tolerance_ns = 0;
  const LogDiff same = diff(show(), show(), exact);
  CHECK(same.equal);
  CHECK(same.offset_ns == 0);
  REQUIRE(same.universes.size() == 2);
  CHECK(same.universes[0].pairs == 400);
  CHECK(same.universes[1].universe == 3);
}

TEST_CASE("a recording with another start time is aligned with the other by its changes, also if frames are missing") {
  auto late = show();
  late.erase(late.begin(), late.begin() + 30);                    // it starts 15 rounds later ...
  for (OwnedFrame& frame : late) frame.time_ns += 3'456'789'012;  // ... on a clock with another origin
  LogDiffOptions exact;
  exact.time_tolerance_ns = 0;
  const LogDiff found = diff(show(), late, exact);
  CHECK(found.offset_from == LogOffsetFrom::kChanges);
  CHECK(found.offset_ns == 3'456'789'012);
  for (const LogUniverseDiff& one : found.universes) {
    CHECK(one.only_a == 15);
    CHECK(one.only_b == 0);
    CHECK(one.different == 0);
    CHECK(one.times.max_ns == 0);
  }
  CHECK(!found.equal);
}

TEST_CASE("lost frames are counted as that many frames, wherever they are, and cause no different level") {
  Random random(11);
  for (const int lost : {1, 5, 40}) {
    CAPTURE(lost);
    auto frames = show();
    for (int i = 0; i < lost; ++i) {
      frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(random.below(frames.size())));
    }
    const LogDiff found = diff(show(), frames);
    CHECK(found.universes[0].only_a + found.universes[1].only_a == static_cast<std::uint64_t>(lost));
    for (const LogUniverseDiff& one : found.universes) {
      CHECK(one.only_b == 0);
      CHECK(one.different == 0);
      CHECK(one.times.max_ns == 0);
    }
    CHECK(!found.equal);
    const LogDiff turned = diff(frames, show());
    CHECK(turned.universes[0].only_b + turned.universes[1].only_b == static_cast<std::uint64_t>(lost));
  }
}

TEST_CASE("a stall is a difference in time, not in frames") {
  auto stalled = show();
  const DurationNs end_ns = stalled[2 * 60].time_ns;
  for (std::size_t i = 2 * 54; i < 2 * 60; ++i) stalled[i].time_ns = end_ns;
  const LogDiff found = diff(show(), stalled);
  for (const LogUniverseDiff& one : found.universes) {
    CHECK(one.pairs == 400);
    CHECK(one.different == 0);
    CHECK(one.times.max_ns > 5 * kPeriodNs);
    CHECK(one.times.max_ns < 7 * kPeriodNs);
    CHECK(one.times.p50_ns == 0);
  }
  CHECK(!found.equal);
  LogDiffOptions patient;
  patient.time_tolerance_ns = 200 * kNsPerMs;
  CHECK(diff(show(), stalled, patient).equal);
}

TEST_CASE(
    "different levels are counted by frame and by slot, and the first one is reported with its time and address") {
  auto changed = show();
  for (std::size_t round = 30; round < 34; ++round) changed[2 * round + 1].slots[7] = 3;  // universe 3
  changed[2 * 200 + 1].slots[9] = 2;
  const LogDiff found = diff(show(), changed);
  CHECK(!found.equal);
  CHECK(found.universes[0].different == 0);
  const LogUniverseDiff& one = found.universes[1];
  CHECK(one.pairs == 400);
  CHECK(one.different == 5);
  CHECK(one.slots_different == 2);
  CHECK(one.level_distance_max == 3);
  CHECK(one.first_address == 8);
  CHECK(one.first_level_a == 0);
  CHECK(one.first_level_b == 3);
  CHECK(one.first_ns == show()[2 * 30 + 1].time_ns);
  LogDiffOptions lenient;
  lenient.level_tolerance = 3;
  CHECK(diff(show(), changed, lenient).equal);
  lenient.level_tolerance = 2;
  CHECK(diff(show(), changed, lenient).universes[1].different == 4);
}

TEST_CASE("a clock that runs 50 ppm fast shows as drift, and every frame keeps its partner") {
  auto fast = show(4'000);
  for (OwnedFrame& frame : fast) frame.time_ns += frame.time_ns / 20'000;
  const LogDiff found = diff(show(4'000), fast);
  for (const LogUniverseDiff& one : found.universes) {
    CHECK(one.pairs == 4'000);
    CHECK(std::abs(one.drift_ppm - 50.0) < 0.5);
  }
}

TEST_CASE("a universe in only one of the logs is listed with its frames") {
  auto more = show();
  OwnedFrame frame;
  frame.universe = 9;
  frame.slots = {1};
  more.push_back(frame);
  const LogDiff found = diff(show(), more);
  REQUIRE(found.universes.size() == 3);
  CHECK(found.universes[2].only_b == 1);
  CHECK(!found.equal);
}

TEST_CASE("without repeats, a log that holds changes only equals one that holds every frame") {
  std::vector<OwnedFrame> changes;
  std::vector<std::uint8_t> last[4];
  for (const OwnedFrame& frame : show()) {
    auto& before = last[frame.universe];
    if (before != frame.slots) changes.push_back(frame);
    before = frame.slots;
  }
  REQUIRE(changes.size() < show().size());
  LogDiffOptions options;
  options.time_tolerance_ns = 0;
  CHECK(!diff(show(), changes, options).equal);
  options.changes_only = true;
  CHECK(diff(show(), changes, options).equal);
}

TEST_CASE("two logs without changes are aligned by their first frames unless an offset is given") {
  std::vector<OwnedFrame> still;
  for (int i = 0; i < 100; ++i) {
    OwnedFrame frame;
    frame.universe = 1;
    frame.time_ns = i * kPeriodNs;
    frame.slots.assign(10, 5);
    still.push_back(frame);
  }
  auto later = still;
  for (OwnedFrame& frame : later) frame.time_ns += 7 * kNsPerMs;
  const LogDiff found = diff(still, later);
  CHECK(found.equal);
  CHECK(found.offset_from == LogOffsetFrom::kFirstFrames);
  CHECK(found.offset_ns == 7 * kNsPerMs);
  LogDiffOptions fixed;
  fixed.offset_ns = 0;
  const LogDiff as_is = diff(still, later, fixed);
  CHECK(!as_is.equal);
  CHECK(as_is.universes[0].times.p50_ns == 7 * kNsPerMs);
  CHECK(diff({}, {}).equal);
}

}  // namespace footlight
