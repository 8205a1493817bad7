#include "drivers/widgets/udmx.h"

#include <algorithm>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/udmx_model.h"
#include "tests/support/device_bench.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using testing::DeviceBench;
using testing::some_snapshot;

std::vector<UdmxRange> ranges_of(const Slots& known, const Slots& wanted) {
  std::vector<UdmxRange> ranges;
  int from = 0;
  while (const auto range = next_udmx_range(known, wanted, from)) {
    ranges.push_back(*range);
    from = range->first + range->count;
  }
  return ranges;
}
DurationNs cost_of(const std::vector<UdmxRange>& ranges) {
  DurationNs cost_ns = 0;
  for (const UdmxRange& range : ranges) cost_ns += udmx_transfer_ns(range.count);
  return cost_ns;
}

TEST_SUITE_BEGIN("udmx");

TEST_CASE("transfer times match the published rates: 15 frames a second of 512 slots, 30 of 256") {
  CHECK(std::abs(static_cast<double>(kNsPerS) / static_cast<double>(udmx_transfer_ns(512)) - 15.0) < 0.5);
  CHECK(std::abs(static_cast<double>(kNsPerS) / static_cast<double>(udmx_transfer_ns(256)) - 30.0) < 1.0);
  CHECK(udmx_transfer_ns(1) == 3 * kNsPerMs);
}

TEST_CASE("nothing changed: nothing to send, one slot changed: that slot") {
  Slots known{}, wanted{};
  CHECK(ranges_of(known, wanted).empty());
  wanted[300] = 1;
  CHECK(ranges_of(known, wanted) == std::vector<UdmxRange>{{300, 1}});
}

TEST_CASE("changes that are near each other share a transfer, and far ones do not") {
  Slots known{}, wanted{};
  wanted[10] = wanted[20] = 1;
  CHECK(ranges_of(known, wanted) == std::vector<UdmxRange>{{10, 11}});
  wanted[20] = 0;
  wanted[200] = 1;
  CHECK(ranges_of(known, wanted) == std::vector<UdmxRange>{{10, 1}, {200, 1}});
}

TEST_CASE("the ranges of any change produce the new frame, and cost no more than all slots or each run separately") {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    Slots known{}, wanted{};
    const auto changed_of_64 = random() % 65;
    for (std::size_t i = 0; i < known.size(); ++i) {
      known[i] = static_cast<std::uint8_t>(random());
      wanted[i] = random() % 64 < changed_of_64 ? static_cast<std::uint8_t>(random()) : known[i];
    }
    const auto ranges = ranges_of(known, wanted);
    Slots result = known;
    int end = 0;
    for (const UdmxRange& range : ranges) {
      REQUIRE(range.first >= end);
      REQUIRE(range.count > 0);
      end = range.first + range.count;
      REQUIRE(end <= 512);
      std::copy_n(wanted.begin() + range.first, range.count, result.begin() + range.first);
    }
    REQUIRE(result == wanted);
    std::vector<UdmxRange> runs;
    for (int i = 0; i < 512; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (known[at] == wanted[at]) continue;
      if (!runs.empty() && runs.back().first + runs.back().count == i)
        ++runs.back().count;
      else
        runs.push_back({i, 1});
    }
    REQUIRE(cost_of(ranges) <= cost_of(runs));
    REQUIRE(cost_of(ranges) <= udmx_transfer_ns(512));
  }
}

TEST_CASE("the model refuses ranges past slot 512 and values past 255, as the firmware does") {
  mock::UdmxModel model;
  model.power_on();
  const mock::Bytes levels(8, 1);
  (void)model.control({0x40, 2, 8, 504, 8}, levels);
  CHECK(model.broken_count == 0);
  (void)model.control({0x40, 2, 8, 505, 8}, levels);
  CHECK(model.broken_count == 1);
  (void)model.control({0x40, 2, 9, 0, 8}, levels);
  CHECK(model.broken_count == 2);
  (void)model.control({0x40, 1, 256, 0, 0}, {});
  CHECK(model.broken_count == 3);
  CHECK(model.slot_count == 8);
}

// --- The driver with the model in this process. Time stands still unless a test moves it.

template <class F>
auto with(DeviceBench& bench, F&& f) {
  return bench.usb->with_model<mock::UdmxModel>(std::forward<F>(f));
}

TEST_CASE("a frame reaches the device with every slot, the first one whole") {
  DeviceBench bench("udmx");
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  CHECK(bench.shows(some_snapshot(7)));
  CHECK(with(bench, [](mock::UdmxModel& model) { return model.slot_count; }) == 512);
  CHECK(sink->rate_hz_max() == doctest::Approx(41.5));
}

TEST_CASE("after the first frame only changed slots are sent") {
  DeviceBench bench("udmx");
  const auto sink = bench.open_sink();
  Bytes snapshot = some_snapshot(7);
  bench.send(*sink, snapshot);
  REQUIRE(bench.shows(snapshot));
  const auto packets = [&] { return with(bench, [](mock::UdmxModel& model) { return model.packet_count; }); };
  const std::uint64_t before = packets();
  snapshot[3] ^= 1;
  snapshot[400] ^= 1;
  bench.send(*sink, snapshot);
  REQUIRE(bench.shows(snapshot));
  CHECK(with(bench, [](mock::UdmxModel& model) { return model.slot_count; }) == 514);
  CHECK(packets() - before == 6);  // 6 ms of the bus instead of 66
}

TEST_CASE("an unchanged frame is refreshed piece by piece, a piece a second, until all is sent") {
  DeviceBench bench("udmx");
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  REQUIRE(bench.shows(some_snapshot(7)));
  with(bench, [](mock::UdmxModel& model) { model.memory.fill(0); });
  for (std::uint64_t i = 1; i <= 8; ++i) {
    bench.advance_ns(kNsPerS);
    REQUIRE(bench.usb->wait_for<mock::UdmxModel>(
        [&](const mock::UdmxModel& model) { return model.slot_count == 512 + 64 * i; }));
  }
  CHECK(bench.shows(some_snapshot(7)));
}

TEST_CASE("an occasionally refused transfer is sent again at once, and is not an error") {
  DeviceBench bench("udmx");
  const auto sink = bench.open_sink();
  for (std::uint8_t i = 0; i < 20; ++i) {
    with(bench, [&](mock::UdmxModel& model) { model.stall_count = i % 3; });
    bench.send(*sink, some_snapshot(i));
    REQUIRE(bench.shows(some_snapshot(i)));
  }
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->counters().errors == 0);
  CHECK(testing::figure_of(*sink, "refused_transfers") == 19);  // 0 1 2 0 1 2 ... of 20
}

TEST_CASE("a device that refuses everything is opened again, and gets the whole frame when it recovers") {
  DeviceBench bench("udmx");
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  with(bench, [](mock::UdmxModel& model) { model.stall_count = 1'000'000; });
  bench.send(*sink, some_snapshot(2));
  REQUIRE(testing::wait_for_state(*sink, PortState::kGone));
  with(bench, [](mock::UdmxModel& model) { model.stall_count = 0; });
  CHECK(bench.advance_until([&] { return bench.shows(some_snapshot(2), std::chrono::milliseconds(1)); }));
}

TEST_CASE("after an unplug before any transfer of a frame, the frame reaches the line") {
  DeviceBench bench("udmx");
  testing::check_unplug_at_every_transfer(bench);
}
TEST_CASE("a transfer cut short loses no frame") {
  DeviceBench bench("udmx");
  testing::check_cut_write(bench, 511);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
