// The driver through the real libusb and the real sysfs reader, with an emulated kernel and the model behind it.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "drivers/device/device.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/open_dmx_model.h"
#include "drivers/registry.h"
#include "drivers/transport/libusb_opener.h"
#include "drivers/widgets/enttec_pro.h"
#include "tests/support/emulated_bench.h"
#include "tests/support/usb_fs.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::EnttecProModel;
using testing::FrameKeeper;
using testing::line_frame_of;
using testing::poll_until;
using testing::some_snapshot;
using testing::UsbSocket;
using testing::wait_for_state;

template <class DriverClock>
struct BenchOn : testing::EmulatedBench<UsbSocket, EnttecProModel, DriverClock> {
  BenchOn() : testing::EmulatedBench<UsbSocket, EnttecProModel, DriverClock>("enttec-pro") {
    this->request.target = "EN172589";
  }
  // With timeouts that a test can wait for.
  std::unique_ptr<Sink> open_impatient_sink() {
    auto opener = make_libusb_opener({.chooser = std::make_shared<Chooser>("enttec-pro", "")}, this->clock);
    REQUIRE(opener);
    auto sink =
        DeviceSink::open({.widget = std::make_unique<EnttecPro>(EnttecProConfig{.write_timeout_ns = 20 * kNsPerMs}),
                          .opener = std::move(*opener),
                          .retry_ns = 20 * kNsPerMs},
                         {.name = "enttec-pro", .lines = {{.line = 0, .universe = 1}}}, this->clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
};
using Bench = BenchOn<SystemClock>;
// Everything here works without a timeout or a repeat.
using StillBench = BenchOn<testing::SharedFakeClock>;

TEST_CASE("a plugged-in widget is listed with its endpoint, without being opened") {
  Bench bench;
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  const FoundDevice& device = list.devices[0];
  CHECK(device.endpoint == "enttec-pro:EN172589");
  CHECK(device.model_name == "ENTTEC DMX USB Pro");
  CHECK(device.manufacturer == "ENTTEC");
  CHECK(device.port_path == "1-1");
  CHECK(device.node == "/dev/bus/usb/001/002");
  CHECK(device.kernel_driver == "ftdi_sio");
  CHECK(device.readiness == Readiness::kReady);
  CHECK(bench.socket.kernel_driver() == "ftdi_sio");
}

TEST_CASE("opening detaches the kernel driver from the widget and closing attaches it again") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  CHECK(bench.socket.claimed());
  CHECK(bench.socket.kernel_driver() == "usbfs");
  sink->close(bench.clock.now_ns());
  CHECK_FALSE(bench.socket.claimed());
  CHECK(bench.socket.kernel_driver() == "ftdi_sio");
}

TEST_CASE("serial number and parameters come over the bus, and the chip is set up") {
  Bench bench;
  bench.model.rate_hz = 33;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  CHECK(dynamic_cast<DeviceSink&>(*sink).link().identity() == "serial number 2172589, firmware 1.68");
  CHECK(sink->rate_hz_max() == 33.0);
  bench.socket.with_model([&] {
    CHECK(bench.model.baud_value == 0x000C);
    CHECK(bench.model.line_data == 0x1008);
    CHECK(bench.model.latency_ms == 16);
    CHECK(bench.model.reset_count == 3);
  });
}

TEST_CASE("100 frames arrive with every byte, each as soon as it was sent") {
  StillBench bench;  // without keep-alives
  bench.socket.plug();
  std::vector<Bytes> frames;
  bench.model.on_frame = [&](int, const Bytes& frame) { frames.push_back(frame); };
  const auto sink = bench.open_sink();
  for (std::size_t i = 0; i < 100; ++i) {
    bench.send(*sink, some_snapshot(i));
    REQUIRE(bench.shows(some_snapshot(i)));
  }
  bench.socket.with_model([&] {
    REQUIRE(frames.size() == 100);
    for (std::size_t i = 0; i < 100; ++i) CHECK(frames[i] == line_frame_of(some_snapshot(i)));
    CHECK(bench.model.false_start_count == drivers::pro_flush_bytes().size());  // the flush at opening, nothing else
  });
  CHECK(sink->counters().dropped == 0);
}

TEST_CASE("frames of the line are received with every byte") {
  Bench bench;
  bench.socket.plug();
  const auto source = bench.open_source();
  FrameKeeper keeper;
  for (std::size_t i = 0; i < 20; ++i) {
    bench.receive(some_snapshot(i));
    REQUIRE(poll_until(
        *source, [&] { (void)source->poll(bench.clock.now_ns(), keeper); },
        [&] { return keeper.kept.size() == i + 1; }));
    CHECK(keeper.kept[i].slots == some_snapshot(i));
  }
  bench.socket.with_model([&] { CHECK(bench.model.latency_ms == 2); });
  CHECK(source->counters().rejected == 0);
}

TEST_CASE("an unplug is detected without traffic, keep-alive or timeout") {
  StillBench bench;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  CHECK(sink->trouble().find("enttec-pro:EN172589") != std::string::npos);
}

TEST_CASE("the last frame is back after a replug, through the real libusb") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.socket.with_model([&] { bench.model.power_on(); });
  const TimeNs plugged_ns = bench.clock.now_ns();
  bench.socket.plug();
  REQUIRE(bench.shows(some_snapshot(1)));
  MESSAGE("replug to last frame: ", static_cast<double>(bench.clock.now_ns() - plugged_ns) * 1e-6, " ms");
  REQUIRE(wait_for_state(*sink, PortState::kWorking));
}

TEST_CASE("a widget unplugged during a transfer gets the frame when it is back") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.out_frozen = true;
  bench.send(*sink, some_snapshot(5));
  REQUIRE(bench.socket.transfer_in_flight(0x02));
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.socket.out_frozen = false;
  bench.socket.plug();
  CHECK(bench.shows(some_snapshot(5)));
}

TEST_CASE("a source receives again after a replug") {
  Bench bench;
  bench.socket.plug();
  const auto source = bench.open_source();
  FrameKeeper keeper;
  const auto poll = [&] { (void)source->poll(bench.clock.now_ns(), keeper); };
  bench.socket.unplug();
  REQUIRE(poll_until(*source, poll, [&] { return source->state() == PortState::kGone; }));
  bench.socket.plug();
  REQUIRE(poll_until(*source, poll, [&] { return source->state() != PortState::kGone; }));
  bench.receive(some_snapshot(3));
  REQUIRE(poll_until(*source, poll, [&] { return !keeper.kept.empty(); }));
  CHECK(keeper.kept[0].slots == some_snapshot(3));
}

TEST_CASE("another widget is not used instead of the unplugged one, and the message names it") {
  Bench bench;
  bench.request.target = "";
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  EnttecProModel other;
  other.serial = "EN999999";
  {
    UsbSocket other_socket(bench.testbed, other, 2);
    other_socket.plug();
    REQUIRE(poll_until(
        *sink, [&] { (void)sink->poll(0); },
        [&] { return sink->trouble().find("there is enttec-pro:EN999999") != std::string::npos; }));
    CHECK_FALSE(other_socket.claimed());
  }
  bench.socket.plug();
  CHECK(wait_for_state(*sink, PortState::kWorking));
}

TEST_CASE("transfers that accept only a few bytes each still send the whole frame") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.out_size_max = 7;
  bench.send(*sink, some_snapshot(2));
  CHECK(bench.shows(some_snapshot(2)));
}

TEST_CASE("a widget that accepts nothing becomes gone, and returns by itself") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_impatient_sink();
  bench.socket.out_frozen = true;
  bench.send(*sink, some_snapshot(2));
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.socket.out_frozen = false;
  CHECK(bench.shows(some_snapshot(2)));
}

TEST_CASE("after a bus error the widget is opened again") {
  Bench bench;
  bench.socket.plug();
  const auto sink = bench.open_impatient_sink();
  bench.socket.out_status = -EPROTO;
  bench.send(*sink, some_snapshot(2));
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  CHECK(sink->trouble().find("/dev/bus/usb/001/002") != std::string::npos);
  bench.socket.out_status = 0;
  CHECK(bench.shows(some_snapshot(2)));
}

TEST_CASE("a claimed widget is reported as in use, with a command that shows the user") {
  Bench bench;
  bench.socket.plug();
  bench.socket.claim_error = EBUSY;
  const auto sink = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kPermission);
  CHECK(sink.error().message.find("fuser -v /dev/bus/usb/001/002") != std::string::npos);

  bench.socket.claim_error = 0;
  const auto opened = bench.open_sink();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kBusy);  // as another program would find it
}

TEST_CASE("a bare FTDI chip is listed as not DMX, and used only when it is named") {
  Bench bench;
  bench.model.manufacturer = "FTDI";
  bench.model.product = "FT232R USB UART";
  bench.model.serial = "A50285BI";
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNotDmx);
  CHECK(list.devices[0].endpoint.empty());

  bench.request.target = "";
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kNotFound);
  bench.request.target = "A50285BI";
  CHECK(bench.open_sink()->state() == PortState::kWorking);
  bench.request.target = "port-1-1";
  CHECK(bench.open_sink()->state() == PortState::kWorking);
}

TEST_CASE("two widgets without a name in the request are refused with their ports") {
  Bench bench;
  EnttecProModel other;
  other.serial = "EN999999";
  UsbSocket other_socket(bench.testbed, other, 2);
  bench.socket.plug();
  other_socket.plug();
  bench.request.target = "";
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kBadInput);
  CHECK(refused.error().message.find("enttec-pro:port-1-1, enttec-pro:port-1-2") != std::string::npos);

  bench.request.target = "EN172589";
  const auto first = bench.open_sink();
  bench.request.target = "EN999999";
  const auto second = drivers::open_sink(bench.request, bench.clock);
  REQUIRE(second);
  CHECK(other_socket.claimed());
}

// --- The other drivers over libusb

struct Other : testing::EmulatedBench<UsbSocket, mock::UsbModel> {
  explicit Other(const char* id)
      : testing::EmulatedBench<UsbSocket, mock::UsbModel>(id, find_driver(id)->make_model()) {
    request.target = model.serial;
    socket.plug();
  }
};

TEST_CASE("every frame reaches the line, and the kernel driver is bound again at the end") {
  for (const char* id : {"eurolite-pro", "eurolite-mk2", "vince", "open-dmx"}) {
    CAPTURE(id);
    Other bench(id);
    const std::string kernel_driver = bench.socket.kernel_driver();
    CHECK(kernel_driver == (std::string_view(id) == "eurolite-pro" ? "" : "ftdi_sio"));
    const auto sink = bench.open_sink();
    CHECK(bench.socket.kernel_driver() == "usbfs");
    for (std::size_t i = 1; i <= 5; ++i) {
      bench.send(*sink, some_snapshot(i));
      REQUIRE(bench.shows(some_snapshot(i)));
    }
    CHECK(sink->counters().errors == 0);
    sink->close(bench.clock.now_ns());
    CHECK_FALSE(bench.socket.claimed());
    CHECK(bench.socket.kernel_driver() == kernel_driver);
  }
}

TEST_CASE("a chip without a driver after a killed program is opened, and has ftdi_sio again after the close") {
  for (const char* id : {"enttec-pro", "open-dmx"}) {
    CAPTURE(id);
    Other bench(id);
    bench.socket.lose_kernel_driver();
    CHECK(bench.socket.kernel_driver().empty());
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(1));
    REQUIRE(bench.shows(some_snapshot(1)));
    sink->close(bench.clock.now_ns());
    CHECK(bench.socket.kernel_driver() == "ftdi_sio");
  }
}

TEST_CASE("forty replugs leak no descriptor or thread and lose no universe") {
  // An emulated kernel has 50 descriptors: a leak of one per replug ends the program.
  for (const char* id : {"enttec-pro", "eurolite-pro", "vince", "open-dmx"}) {
    CAPTURE(id);
    Other bench(id);
    const auto sink = bench.open_sink();
    for (std::size_t i = 1; i <= 40; ++i) {
      bench.send(*sink, some_snapshot(i));
      REQUIRE(bench.shows(some_snapshot(i)));
      bench.socket.unplug();
      REQUIRE(wait_for_state(*sink, PortState::kGone));
      bench.socket.plug();
      REQUIRE(bench.shows(some_snapshot(i)));
    }
  }
}

TEST_CASE("an output without anything to read detects its unplug without traffic") {
  Other bench("eurolite-pro");
  const auto sink = bench.open_sink();
  bench.socket.unplug();
  CHECK(wait_for_state(*sink, PortState::kGone));
}

TEST_CASE("a line that this machine times has no cut frame and no short break through the real libusb") {
  Other bench("open-dmx");
  const auto sink = bench.open_sink();
  auto& model = dynamic_cast<mock::OpenDmxModel&>(bench.model);
  for (std::size_t i = 1; i <= 20; ++i) {
    bench.send(*sink, some_snapshot(i));
    REQUIRE(bench.shows(some_snapshot(i)));
  }
  bench.socket.with_model([&] {
    CHECK(model.cut_count == 0);
    CHECK(model.bad_break_count == 0);
    for (const auto& frame : model.timings) CHECK(frame.break_ns >= 92 * kNsPerUs);
  });
}

TEST_CASE("two devices without serial numbers keep their universes when both are replugged in the other order") {
  SystemClock clock;
  testing::Testbed testbed;
  EnttecProModel left_model, right_model;
  left_model.serial = right_model.serial = "";
  UsbSocket left(testbed, left_model, 1), right(testbed, right_model, 2);
  left.plug();
  right.plug();
  const auto open = [&](const char* target, Universe universe) {
    auto sink = drivers::open_sink({.scheme = "enttec-pro", .target = target, .universes = {universe}}, clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  };
  const auto to_left = open("port-1-1", 1), to_right = open("port-1-2", 2);
  const auto send = [&](Sink& sink, Universe universe, const Bytes& slots) {
    const FrameView frame{.universe = universe, .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  };
  left.unplug();
  right.unplug();
  REQUIRE(wait_for_state(*to_left, PortState::kGone));
  REQUIRE(wait_for_state(*to_right, PortState::kGone));
  send(*to_left, 1, some_snapshot(1));
  send(*to_right, 2, some_snapshot(2));
  right.plug();
  CHECK(right.wait_for([&] { return right_model.line(0).frame == line_frame_of(some_snapshot(2)); }));
  CHECK(to_left->state() == PortState::kGone);
  left.plug();
  CHECK(left.wait_for([&] { return left_model.line(0).frame == line_frame_of(some_snapshot(1)); }));
}

TEST_CASE("the error without any widget states that it is not plugged in") {
  Bench bench;
  const auto sink = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kNotFound);
  CHECK(sink.error().message == "enttec-pro:EN172589: not plugged in");
}

TEST_CASE("a sink destroyed during a frozen transfer waits for no timeout") {
  StillBench bench;
  bench.socket.plug();
  auto sink = bench.open_sink();
  bench.socket.out_frozen = true;
  bench.send(*sink, some_snapshot(5));
  REQUIRE(bench.socket.transfer_in_flight(0x02));
  sink.reset();  // the write's own timeout never expires
  CHECK_FALSE(bench.socket.claimed());
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (const int skipped = footlight::testing::run_under_umockdev(argv)) return skipped;
  return doctest::Context(argc, argv).run();
}
