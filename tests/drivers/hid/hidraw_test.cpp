// The hidraw connector and the real /sys reader on an emulated kernel, with the drivers and their models at both ends.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "drivers/device/device.h"
#include "drivers/mock/nodle_model.h"
#include "drivers/registry.h"
#include "tests/support/emulated_bench.h"
#include "tests/support/hidraw_fs.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::NodleModel;
using testing::FrameKeeper;
using testing::HidSocket;
using testing::line_frame_of;
using testing::poll_until;
using testing::some_snapshot;
using testing::wait_for_state;

template <class Model, class DriverClock = SystemClock>
using Bench = testing::EmulatedBench<HidSocket, Model, DriverClock>;

TEST_CASE("a HID interface is listed with its endpoint, without being opened") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  const FoundDevice& device = list.devices[0];
  CHECK(device.endpoint == "nodle:A0042");
  CHECK(device.model_name == "DMXControl Projects Nodle U1");
  CHECK(device.hidraw == "/dev/hidraw1");
  CHECK(device.readiness == Readiness::kReady);
}

TEST_CASE("a node that this user may not open is named together with the command that mends it") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const DeviceList list =
      find_devices({.node_access = [](const std::string& node) { return node == "/dev/hidraw1" ? EACCES : 0; },
                    .etc_root = "/nonexistent",
                    .lib_roots = {},
                    .user_name = "anna"});
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNoPermission);
  CHECK(list.devices[0].reason == "/dev/hidraw1: Permission denied; the udev rules are not installed");
  CHECK(list.devices[0].remedy.find("70-footlight.rules") != std::string::npos);
}

TEST_CASE("100 looks arrive over hidraw with every byte") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  for (int i = 0; i < 100; ++i) {
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(i)));
    REQUIRE(bench.shows(some_snapshot(static_cast<std::uint8_t>(i))));
  }
  bench.socket.with_model([&] { CHECK(bench.model.broken_count == 0); });
}

TEST_CASE("frames of the input arrive over hidraw with every byte while looks go out") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  const auto source = bench.open_source();
  REQUIRE(bench.socket.wait_for([&] { return bench.model.mode == 6; }));
  FrameKeeper keeper;
  for (std::uint8_t i = 0; i < 20; ++i) {
    bench.socket.with_model([&] { bench.model.receive_line_frame(1, line_frame_of(some_snapshot(i))); });
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(100 + i)));
    REQUIRE(poll_until(
        *source, [&] { (void)source->poll(bench.clock.now_ns(), keeper); },
        [&] { return !keeper.kept.empty() && keeper.kept.back().slots == some_snapshot(i); }));
    REQUIRE(bench.shows(some_snapshot(static_cast<std::uint8_t>(100 + i))));
  }
  CHECK(source->counters().rejected == 0);
}

TEST_CASE("an unplug is noticed without traffic, and the last look is back after the replug") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  const TimeNs unplugged_ns = bench.clock.now_ns();
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  MESSAGE("unplug to gone: ", static_cast<double>(bench.clock.now_ns() - unplugged_ns) * 1e-6, " ms");
  bench.send(*sink, some_snapshot(2));
  const TimeNs plugged_ns = bench.clock.now_ns();
  bench.socket.plug();
  REQUIRE(bench.shows(some_snapshot(2)));
  MESSAGE("replug to last look: ", static_cast<double>(bench.clock.now_ns() - plugged_ns) * 1e-6, " ms");
}

TEST_CASE("a device that leaves in the middle of a look gets it when it is back") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  for (const int at : {0, 1, 8, 16}) {  // the mode report, then 16 blocks
    bench.socket.unplug_at_write = at;
    bench.socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(at)));
    const auto report_count = [&] { return bench.model.mode_count + bench.model.block_count; };
    const std::uint64_t before = report_count();
    bench.socket.plug();
    REQUIRE(bench.socket.wait_for([&] { return report_count() >= before + static_cast<std::uint64_t>(at); }));
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    // "Unplugged", or what a new try found while the kernel was still tidying up.
    CHECK(sink->trouble().starts_with("nodle: "));
    bench.socket.unplug_at_write = -1;
    bench.socket.unplug();
    bench.socket.plug();
    CHECK(bench.shows(some_snapshot(static_cast<std::uint8_t>(at))));
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
  }
}

TEST_CASE("writes that fail or are cut short lead to opening the device afresh") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.socket.write_error = EPIPE;
  bench.send(*sink, some_snapshot(2));
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  CHECK(sink->trouble().find("/dev/hidraw1") != std::string::npos);
  bench.socket.write_error = 0;
  CHECK(bench.shows(some_snapshot(2)));
  REQUIRE(wait_for_state(*sink, PortState::kWorking));
  bench.socket.write_size_max = 7;
  bench.send(*sink, some_snapshot(3));
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.socket.write_size_max = -1;
  CHECK(bench.shows(some_snapshot(3)));
}

TEST_CASE("a device without a serial number is found again in its socket and in no other") {
  Bench<NodleModel> bench("nodle");
  bench.model.serial = "";
  bench.socket.plug();
  const DeviceList list = find_devices();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].endpoint == "nodle:port-1-1");
  const auto sink = bench.open_sink();
  bench.socket.unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  NodleModel other;
  other.serial = "";
  {
    HidSocket other_socket(bench.testbed, other, 2);
    other_socket.plug();
    REQUIRE(poll_until(
        *sink, [&] { (void)sink->poll(0); },
        [&] { return sink->trouble().find("nodle:port-1-2") != std::string::npos; }));
    other_socket.with_model([&] { CHECK(other.mode_count == 0); });
  }
  bench.socket.plug();
  CHECK(wait_for_state(*sink, PortState::kWorking));
}

TEST_CASE("two alike are told apart, and neither takes the other's place") {
  Bench<NodleModel> bench("nodle");
  NodleModel other;
  other.serial = "A0099";
  HidSocket other_socket(bench.testbed, other, 2);
  bench.socket.plug();
  other_socket.plug();
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kBadInput);
  bench.request.target = "A0099";
  const auto second = bench.open_sink();
  bench.request.target = "A0042";
  const auto first = bench.open_sink();
  bench.send(*first, some_snapshot(1));
  bench.send(*second, some_snapshot(2));
  CHECK(bench.shows(some_snapshot(1)));
  CHECK(other_socket.wait_for([&] { return other.line(0).frame == line_frame_of(some_snapshot(2)); }));
}

TEST_CASE("closing ends though nothing comes, and leaves no descriptor and no thread") {
  Bench<NodleModel, testing::SharedFakeClock> bench("nodle");  // no timeout ever ends a wait
  bench.socket.plug();
  { const auto warm_up = bench.open_sink(); }
  const std::size_t fds = testing::entries_of("/proc/self/fd"), threads = testing::entries_of("/proc/self/task");
  for (int i = 0; i < 20; ++i) (void)bench.open_sink();
  CHECK(testing::entries_of("/proc/self/fd") == fds);
  CHECK(testing::entries_of("/proc/self/task") == threads);
}

TEST_CASE("100 replugs over hidraw leak no descriptor and no thread, and lose no look") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(0));
  REQUIRE(bench.shows(some_snapshot(0)));
  const std::size_t fds = testing::entries_of("/proc/self/fd"), threads = testing::entries_of("/proc/self/task");
  for (int i = 1; i <= 100; ++i) {
    bench.socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(i)));
    bench.socket.plug();
    REQUIRE(bench.shows(some_snapshot(static_cast<std::uint8_t>(i))));
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
  }
  CHECK(testing::entries_of("/proc/self/fd") == fds);
  CHECK(testing::entries_of("/proc/self/task") == threads);
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (const int skipped = footlight::testing::run_under_umockdev(argv)) return skipped;
  return doctest::Context(argc, argv).run();
}
