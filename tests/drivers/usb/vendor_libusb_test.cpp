// Interfaces with their own endpoints through the real libusb on an emulated kernel: uDMX, Peperoni, DMXCreator,
// Velleman.
#include <doctest/doctest.h>

#include "drivers/device/device.h"
#include "drivers/mock/dmxcreator_model.h"
#include "drivers/mock/peperoni_model.h"
#include "drivers/mock/udmx_model.h"
#include "drivers/mock/velleman_model.h"
#include "drivers/registry.h"
#include "tests/support/emulated_bench.h"
#include "tests/support/usb_fs.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::DmxCreatorModel;
using mock::PeperoniModel;
using mock::UdmxModel;
using mock::VellemanModel;
using testing::line_frame_of;
using testing::some_snapshot;
using testing::UsbSocket;
using testing::wait_for_state;

template <class Model>
struct Bench : testing::EmulatedBench<UsbSocket, Model> {
  using testing::EmulatedBench<UsbSocket, Model>::EmulatedBench;
  // Frames arrive, an unplug is detected without traffic, and a frame sent meanwhile arrives after the replug.
  void check_snapshots_and_replug() {
    this->socket.plug();
    const DeviceList list = find_devices();
    REQUIRE(list.devices.size() == 1);
    CHECK(list.devices[0].driver_id == this->request.scheme);
    CHECK(list.devices[0].readiness == Readiness::kReady);
    const std::string kernel_driver = this->socket.kernel_driver();
    const auto sink = this->open_sink();
    CHECK(this->socket.kernel_driver() == "usbfs");
    for (std::size_t i = 0; i < 50; ++i) {
      this->send(*sink, some_snapshot(i));
      REQUIRE(this->shows(some_snapshot(i)));
    }
    this->socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    this->send(*sink, some_snapshot(99));
    this->socket.plug();
    REQUIRE(this->shows(some_snapshot(99)));
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
    sink->close(this->clock.now_ns());
    CHECK_FALSE(this->socket.claimed());
    CHECK(this->socket.kernel_driver() == kernel_driver);
  }
};

TEST_CASE("uDMX: frames arrive through libusb, and one sent meanwhile after a replug") {
  Bench<UdmxModel> bench("udmx");
  bench.check_snapshots_and_replug();
  bench.socket.with_model([&] { CHECK(bench.model.broken_count == 0); });
}

TEST_CASE("uDMX: a refused transfer is sent again, through libusb too") {
  Bench<UdmxModel> bench("udmx");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.with_model([&] { bench.model.stall_count = 2; });
  bench.send(*sink, some_snapshot(1));
  CHECK(bench.shows(some_snapshot(1)));
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->counters().errors == 0);
}

TEST_CASE("uDMX: another device with the shared ids is listed as not DMX, and not used") {
  Bench<UdmxModel> bench("udmx");
  bench.model.manufacturer = "obdev.at";
  bench.model.product = "PowerSwitch";
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNotDmx);
  CHECK(list.devices[0].model_name.find("FTDI") == std::string::npos);
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kNotFound);
}

TEST_CASE("Peperoni: frames of all three generations arrive through libusb") {
  for (const int release : {0x0150, 0x0402, 0x0504}) {
    Bench<PeperoniModel> bench("peperoni");
    bench.model.release = static_cast<std::uint16_t>(release);
    bench.check_snapshots_and_replug();
    bench.socket.with_model([&] { CHECK(bench.model.broken_count == 0); });
  }
}

TEST_CASE("Peperoni: both universes of a USBDMX21 arrive, by its row in the table") {
  Bench<PeperoniModel> bench("peperoni");
  bench.model.usb_product = 0x0004;
  bench.request.universes = {1, 2};
  bench.socket.plug();
  const auto sink = bench.open_sink();
  const Bytes first = some_snapshot(1), second = some_snapshot(2);
  const FrameView frames[] = {{.universe = 1, .slots = first}, {.universe = 2, .slots = second}};
  REQUIRE(sink->send(0, frames));
  CHECK(bench.socket.wait_for([&] {
    return bench.model.line(0).frame == line_frame_of(first) && bench.model.line(1).frame == line_frame_of(second);
  }));
}

TEST_CASE("Peperoni: a USBDMX21 plugged in after the start has both universes, and a Rodin is refused") {
  for (const bool has_two : {true, false}) {
    Bench<PeperoniModel> bench("peperoni");
    bench.model.usb_product = has_two ? 0x0004 : 0x0002;
    bench.request.universes = {1, 2};
    bench.request.wait_for_device = true;
    const auto sink = bench.open_sink();
    CHECK(sink->state() == PortState::kGone);
    const Bytes first = some_snapshot(1), second = some_snapshot(2);
    const FrameView frames[] = {{.universe = 1, .slots = first}, {.universe = 2, .slots = second}};
    REQUIRE(sink->send(0, frames));
    bench.socket.plug();
    if (has_two) {
      CHECK(bench.socket.wait_for([&] {
        return bench.model.line(0).frame == line_frame_of(first) && bench.model.line(1).frame == line_frame_of(second);
      }));
    } else {
      CHECK(testing::poll_until(
          *sink, [&] { (void)sink->poll(0); },
          [&] { return sink->trouble().find("one output only; use connector 1") != std::string::npos; }));
    }
  }
}

TEST_CASE("Peperoni: after a bus error it is opened again") {
  Bench<PeperoniModel> bench("peperoni");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.out_status = -EPROTO;
  bench.send(*sink, some_snapshot(2));
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.socket.out_status = 0;
  CHECK(bench.shows(some_snapshot(2)));
}

TEST_CASE("Peperoni: a device unplugged during a transfer gets the frame when it is back") {
  Bench<PeperoniModel> bench("peperoni");
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

TEST_CASE("DMXCreator: frames arrive through libusb, and one sent meanwhile after a replug") {
  Bench<DmxCreatorModel> bench("dmxcreator");
  bench.check_snapshots_and_replug();
  bench.socket.with_model([&] {
    CHECK(bench.model.broken_count == 0);
    CHECK(bench.model.cut_count == 0);
  });
}

TEST_CASE("DMXCreator: a halted endpoint is cleared, and the frame arrives without reopening") {
  Bench<DmxCreatorModel> bench("dmxcreator");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.out_halted = true;
  bench.send(*sink, some_snapshot(4));
  CHECK(bench.shows(some_snapshot(4)));
  CHECK(sink->state() == PortState::kWorking);
  CHECK_FALSE(bench.socket.out_halted);
}

TEST_CASE("Velleman: frames arrive through libusb while vmk80xx has the device, and again after a replug") {
  Bench<VellemanModel> bench("velleman");
  bench.check_snapshots_and_replug();
  CHECK(bench.socket.kernel_driver() == "vmk80xx");
  bench.socket.with_model([&] {
    CHECK(bench.model.broken_count == 0);
    CHECK(bench.model.cut_count == 0);
  });
}

TEST_CASE("Velleman: a user who may open its USB node needs no hidraw node and no kernel module") {
  Bench<VellemanModel> bench("velleman");
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].hidraw.empty());
  CHECK(list.devices[0].readiness == Readiness::kReady);
  CHECK(list.devices[0].way == "libusb");
  CHECK(list.devices[0].remedy.empty());
}

TEST_CASE("Velleman: the reports of both firmwares arrive through libusb, detected by the descriptor") {
  for (const bool upgraded : {false, true}) {
    Bench<VellemanModel> bench("velleman");
    bench.model.upgraded = upgraded;
    bench.socket.plug();
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(3));
    CHECK(bench.shows(some_snapshot(3)));
    CHECK(dynamic_cast<DeviceSink&>(*sink).link().identity() ==
          (upgraded ? "reports of 64 bytes every 10 ms" : "reports of 8 bytes every 10 ms"));
    bench.socket.with_model([&] { CHECK(bench.model.broken_count == 0); });
  }
}

}  // namespace
}  // namespace footlight::drivers
