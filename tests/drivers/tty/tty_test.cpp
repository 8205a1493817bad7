// Drivers through the real termios and the real sysfs reader, on an emulated tty with a model behind it.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "drivers/device/device.h"
#include "drivers/mock/dmx4all_model.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/open_dmx_model.h"
#include "drivers/registry.h"
#include "tests/support/emulated_bench.h"
#include "tests/support/tty_fs.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using testing::some_snapshot;
using testing::TtySocket;
using testing::wait_for_state;

template <class Model, class DriverClock = SystemClock>
struct Bench : testing::EmulatedBench<TtySocket, Model, DriverClock> {
  Bench(std::string scheme, std::string tty)
      : testing::EmulatedBench<TtySocket, Model, DriverClock>(std::move(scheme), std::make_unique<Model>(),
                                                              std::move(tty)) {}
};
// On a clock that stands still there is no keep-alive and no timeout: events are detected without them.
template <class Model>
using StillBench = Bench<Model, testing::SharedFakeClock>;

// Polls the source until done().
template <class Done>
bool poll_source(Source& source, testing::FrameKeeper& keeper, Done&& done) {
  return testing::poll_until(
      source, [&] { (void)source.poll(0, keeper); }, std::forward<Done>(done));
}
// Unplugs and replugs the device of an open source.
template <class SomeBench>
void check_unplugged_input(SomeBench& bench, Source& source, testing::FrameKeeper& keeper) {
  bench.socket.unplug();
  REQUIRE(poll_source(source, keeper, [&] { return source.state() == PortState::kGone; }));
  CHECK(source.trouble().find("plugged") != std::string::npos);
  bench.socket.plug();
  REQUIRE(poll_source(source, keeper, [&] {
    bench.clock.advance_ns(kNsPerS);  // the device is searched for again, and libusb has had its time
    return source.state() != PortState::kGone;
  }));
}

TEST_CASE("a NanoDMX on a ttyACM is listed, opened by its tty, set to 250000 baud and shows the frame") {
  Bench<mock::Dmx4allModel> bench("dmx4all", "ttyACM0");
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].tty == "/dev/ttyACM0");
  CHECK(list.devices[0].endpoint == "dmx4all:NANO0042");
  CHECK(list.devices[0].readiness == Readiness::kReady);
  const auto sink = bench.open_sink();
  CHECK(bench.socket.baud() == 250'000);
  CHECK(bench.socket.has_two_stop_bits());
  bench.send(*sink, some_snapshot(1));
  CHECK(bench.shows(some_snapshot(1)));
  bench.send(*sink, some_snapshot(2));
  CHECK(bench.shows(some_snapshot(2)));
  CHECK(sink->counters().rejected == 0);
}

TEST_CASE("a DMXking MAX uses the protocol of a DMX USB Pro on a ttyACM, in both directions") {
  Bench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.model.manufacturer = "DMXking";
  bench.model.product = "ultraDMX MAX";
  bench.socket.plug();
  {
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(1));
    CHECK(bench.shows(some_snapshot(1)));
    sink->close(bench.clock.now_ns());
  }
  const auto source = bench.open_source();
  testing::FrameKeeper keeper;
  REQUIRE(bench.socket.wait_for([&] { return bench.model.listens(0); }));
  for (std::size_t i = 1; i <= 10; ++i) {
    bench.receive(some_snapshot(i));
    REQUIRE(testing::poll_until(
        *source, [&] { (void)source->poll(bench.clock.now_ns(), keeper); },
        [&] { return !keeper.kept.empty() && keeper.kept.back().slots == some_snapshot(i); }));
  }
  CHECK(source->counters().rejected == 0);
}

TEST_CASE("a DMXking MAX that is plugged in after the start is opened by its tty") {
  Bench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.request.wait_for_device = true;
  const auto sink = bench.open_sink();
  CHECK(sink->state() == PortState::kGone);
  bench.send(*sink, some_snapshot(1));
  bench.socket.plug();
  CHECK(bench.shows(some_snapshot(1)));
  CHECK(wait_for_state(*sink, PortState::kWorking));
}

TEST_CASE("an unplug is detected without traffic, and the last frame is back after the replug") {
  StillBench<mock::Dmx4allModel> bench("dmx4all", "ttyACM0");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  CHECK(sink->trouble().find("unplugged") != std::string::npos);
  bench.socket.plug();
  bench.clock.advance_ns(kNsPerS);  // a search for the device is due
  CHECK(bench.shows(some_snapshot(1)));
}

TEST_CASE("an unplugged input of a DMXking MAX is gone without traffic, and receives frames after the replug") {
  StillBench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.socket.plug();
  const auto source = bench.open_source();
  testing::FrameKeeper keeper;
  REQUIRE(bench.socket.wait_for([&] { return bench.model.listens(0); }));
  for (std::size_t i = 1; i <= 5; ++i) {
    bench.receive(some_snapshot(i));
    REQUIRE(poll_source(*source, keeper,
                        [&] { return !keeper.kept.empty() && keeper.kept.back().slots == some_snapshot(i); }));
    check_unplugged_input(bench, *source, keeper);
    REQUIRE(bench.socket.wait_for([&] { return bench.model.listens(0); }));
  }
}

TEST_CASE("an unplugged input of a bare cable on a ttyUSB is gone without traffic, and open after the replug") {
  StillBench<mock::OpenDmxModel> bench("open-dmx", "ttyUSB0");
  bench.model.slot_ns = 0;
  bench.socket.plug();
  bench.request.target = "A50285BI";
  const auto source = bench.open_source();
  testing::FrameKeeper keeper;
  for (int i = 0; i < 5; ++i) check_unplugged_input(bench, *source, keeper);
}

TEST_CASE("forty replugs leak no descriptor and lose no universe") {
  Bench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  for (std::size_t i = 0; i < 40; ++i) {
    bench.send(*sink, some_snapshot(i));
    REQUIRE(bench.shows(some_snapshot(i)));
    bench.socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    bench.socket.plug();
    REQUIRE(bench.shows(some_snapshot(i)));
  }
}

TEST_CASE("an FTDI cable without libusb's node is used over its ttyUSB, with real breaks") {
  Bench<mock::OpenDmxModel> bench("open-dmx", "ttyUSB0");
  bench.model.slot_ns = 0;
  bench.model.break_min_ns = bench.model.mark_min_ns = 0;  // the model has no time here
  bench.socket.plug();
  bench.request.target = "A50285BI";
  const auto sink = bench.open_sink();
  for (std::size_t i = 1; i <= 5; ++i) {
    bench.send(*sink, some_snapshot(i));
    CHECK(bench.shows(some_snapshot(i)));
  }
  bench.socket.with_model([&] { CHECK(bench.model.cut_count == 0); });
}

TEST_CASE("a tty that nothing identifies is not opened") {
  Bench<mock::OpenDmxModel> bench("open-dmx", "ttyUSB0");
  bench.socket.plug();
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kNotFound);
  CHECK(bench.socket.baud() == 0);
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (const int skipped = footlight::testing::run_under_umockdev(argv)) return skipped;
  return doctest::Context(argc, argv).run();
}
