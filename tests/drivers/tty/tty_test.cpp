// Drivers through the real termios and the real sysfs reader, on an emulated tty with a model behind it.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <numeric>

#include "drivers/device/device.h"
#include "drivers/mock/dmx4all_model.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/open_dmx_model.h"
#include "drivers/ports_factory.h"
#include "drivers/registry.h"
#include "sim/system_clock.h"
#include "tests/support/tty_fs.h"
#include "tests/support/usb_port_test.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using testing::TtySocket;
using testing::wait_for_state;

Bytes pattern(std::size_t seed) {
  Bytes slots(512);
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i * 7 + seed * 31 + (i >> 8));
  return slots;
}
Bytes line_frame_of(const Bytes& slots) {
  Bytes frame{0};
  frame.insert(frame.end(), slots.begin(), slots.end());
  return frame;
}

template <class Model>
struct Bench {
  Bench(std::string scheme, const std::string& tty)
      : socket(testbed, model, tty), request{.scheme = std::move(scheme)} {
    request.universes = {1};
  }
  std::unique_ptr<Sink> open_sink() {
    auto sink = drivers::open_sink(request, clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  void send(Sink& sink, const Bytes& slots) {
    const FrameView frame{.universe = 1, .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  bool shows(const Bytes& slots) {
    return socket.wait_for([&] { return model.line(0).frame == line_frame_of(slots); });
  }

  SystemClock clock;
  testing::Testbed testbed;
  Model model;
  TtySocket socket;
  PortRequest request;
};

TEST_CASE("a NanoDMX on a ttyACM is listed, opened by its tty, set to 250000 baud and shows the look") {
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
  bench.send(*sink, pattern(1));
  CHECK(bench.shows(pattern(1)));
  bench.send(*sink, pattern(2));
  CHECK(bench.shows(pattern(2)));
  CHECK(sink->counters().rejected == 0);
}

TEST_CASE("a DMXking MAX speaks the protocol of a DMX USB Pro on a ttyACM, both ways") {
  Bench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.model.manufacturer = "DMXking";
  bench.model.product = "ultraDMX MAX";
  bench.socket.plug();
  {
    const auto sink = bench.open_sink();
    bench.send(*sink, pattern(1));
    CHECK(bench.shows(pattern(1)));
    sink->close(bench.clock.now_ns());
  }
  auto source = drivers::open_source(bench.request, bench.clock);
  REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
  testing::FrameKeeper keeper;
  REQUIRE(bench.socket.wait_for([&] { return bench.model.listens(0); }));
  for (std::size_t i = 1; i <= 10; ++i) {
    bench.socket.with_model([&] { bench.model.receive_line_frame(0, line_frame_of(pattern(i))); });
    REQUIRE(testing::poll_until(
        **source, [&] { (void)(*source)->poll(bench.clock.now_ns(), keeper); },
        [&] { return !keeper.kept.empty() && keeper.kept.back().slots == pattern(i); }));
  }
  CHECK((*source)->counters().rejected == 0);
}

TEST_CASE("an unplug is noticed without traffic, and the last look is back within a second of the replug") {
  Bench<mock::Dmx4allModel> bench("dmx4all", "ttyACM0");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, pattern(1));
  REQUIRE(bench.shows(pattern(1)));
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  const TimeNs plugged_ns = bench.clock.now_ns();
  bench.socket.plug();
  CHECK(bench.shows(pattern(1)));
  const DurationNs back_ns = bench.clock.now_ns() - plugged_ns;
  CHECK(back_ns < kNsPerS);
  MESSAGE("replug to last look: ", static_cast<double>(back_ns) * 1e-6, " ms");
}

TEST_CASE("forty replugs cost no descriptor and no universe") {
  Bench<mock::EnttecProModel> bench("enttec-pro", "ttyACM0");
  bench.model.chip = mock::SerialChip::kCdcAcm;
  bench.model.vendor = 0x1FC9;
  bench.model.product_id = 0x0094;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  for (std::size_t i = 0; i < 40; ++i) {
    bench.send(*sink, pattern(i));
    REQUIRE(bench.shows(pattern(i)));
    bench.socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    bench.socket.plug();
    REQUIRE(bench.shows(pattern(i)));
  }
}

TEST_CASE("an FTDI cable without libusb's node is used over its ttyUSB, with real breaks") {
  Bench<mock::OpenDmxModel> bench("open-dmx", "ttyUSB0");
  bench.model.slot_ns = 0;
  bench.model.break_min_ns = bench.model.mark_min_ns = 0;  // the model is not told the time here
  bench.socket.plug();
  bench.request.target = "A50285BI";
  const auto sink = bench.open_sink();
  for (std::size_t i = 1; i <= 5; ++i) {
    bench.send(*sink, pattern(i));
    CHECK(bench.shows(pattern(i)));
  }
  bench.socket.with_model([&] { CHECK(bench.model.cut_count == 0); });
}

TEST_CASE("a tty that nothing names is left alone") {
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
