// The driver against the model in this process. Time stands still unless a test moves it.
#include "drivers/mock/velleman_model.h"
#include "tests/support/device_bench.h"

namespace footlight::drivers {
namespace {

using mock::VellemanModel;
using testing::DeviceBench;
using testing::some_snapshot;

std::uint64_t reports_of(DeviceBench& bench) {
  return bench.usb->with_model<VellemanModel>([](VellemanModel& model) { return model.report_count; });
}
std::uint64_t broken_of(DeviceBench& bench) {
  return bench.usb->with_model<VellemanModel>([](VellemanModel& model) { return model.broken_count; });
}

TEST_SUITE_BEGIN("velleman");

TEST_CASE("a look reaches the line with every slot, in reports of either size") {
  for (const bool upgraded : {false, true}) {
    DeviceBench bench("velleman");
    bench.usb->with_model<VellemanModel>([&](VellemanModel& model) {
      model.upgraded = upgraded;
      if (upgraded) model.interval_ms = 1;
    });
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(9));
    CHECK(bench.shows(some_snapshot(9)));
    CHECK(broken_of(bench) == 0);
  }
}

TEST_CASE("the rate is what the reports of a dark look take, and what a bright one takes is said") {
  DeviceBench bench("velleman");
  const auto sink = bench.open_sink();
  CHECK(sink->rate_hz_max() == doctest::Approx(20.0));  // 5 reports of 10 ms
  CHECK(sink->link().identity() == "reports of 8 bytes every 10 ms");
  REQUIRE(sink->link().remarks().size() == 1);
  CHECK(sink->link().remarks()[0] == "a frame without zeros takes 75 reports of 10 ms: 1.3 a second");
}

TEST_CASE("the replacement firmware is told by its descriptor and has nothing to excuse") {
  DeviceBench bench("velleman");
  bench.usb->with_model<VellemanModel>([&](VellemanModel& model) {
    model.upgraded = true;
    model.interval_ms = 1;
  });
  const auto sink = bench.open_sink();
  CHECK(sink->rate_hz_max() == doctest::Approx(44.0));
  CHECK(sink->link().identity() == "reports of 64 bytes every 1 ms");
  CHECK(sink->link().remarks().empty());
}

TEST_CASE("a look is repeated every 100 ms, and one that comes again unchanged before that is not sent") {
  DeviceBench bench("velleman");
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  const std::uint64_t once = reports_of(bench);
  bench.advance_ns(60 * kNsPerMs);
  bench.send(*sink, some_snapshot(1));
  REQUIRE(testing::poll_until(
      *sink, [&] { (void)sink->poll(0); }, [&] { return sink->counters().frames == 2; }, std::chrono::seconds(2)));
  CHECK(reports_of(bench) == once);
  bench.advance_ns(100 * kNsPerMs);
  CHECK(bench.usb->wait_for<VellemanModel>([&](const VellemanModel& model) { return model.report_count == 2 * once; }));
}

TEST_CASE("it has no input, and says so") {
  DeviceBench bench("velleman");
  const auto source = DeviceSource::open(bench.plan(), bench.port(0), bench.clock);
  REQUIRE_FALSE(source);
  CHECK(source.error().code == ErrorCode::kUnsupported);
  CHECK(source.error().message.find("use it as an output") != std::string::npos);
}

TEST_CASE("closing dark sends zeros, closing otherwise leaves the look") {
  for (const bool dark : {false, true}) {
    DeviceBench bench("velleman");
    DevicePortConfig port = bench.port(0);
    port.blackout_on_exit = dark;
    auto sink = DeviceSink::open(bench.plan(), port, bench.clock);
    REQUIRE(sink);
    bench.send(**sink, some_snapshot(1));
    REQUIRE(bench.shows(some_snapshot(1)));
    (*sink)->close(bench.clock.now_ns());
    CHECK(bench.shows(dark ? mock::Bytes(512, 0) : some_snapshot(1), std::chrono::milliseconds(0)));
    CHECK_FALSE(bench.usb->claimed());
  }
}

TEST_CASE("an unplug before any report of a look ends with that look") {
  DeviceBench bench("velleman");
  testing::check_unplug_at_every_transfer(bench);
  CHECK(broken_of(bench) == 0);
}
TEST_CASE("a report that is cut short at any byte costs no look") {
  DeviceBench bench("velleman");
  testing::check_cut_write(bench, 8);
}
TEST_CASE("what the device says is no reason to stop") {
  DeviceBench bench("velleman");
  testing::check_garbage(bench);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
