// hidapi and the real /sys reader on an emulated kernel, with a driver on one side and the model of its device on the
// other.
//
// FOOTLIGHT_REPLUGS=1000 sets the number of replugs in the tests that count them.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdlib>
#include <functional>
#include <mutex>

#include "drivers/device/device.h"
#include "drivers/mock/nodle_model.h"
#include "drivers/registry.h"
#include "drivers/transport/hid_opener.h"
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

// A clock that stands still, and on which a sleep takes no time. Only connect() sleeps, until the node has settled.
class ContactClock final : public Clock {
 public:
  TimeNs now_ns() override { return clock_.now_ns(); }
  void sleep_until_ns(TimeNs deadline_ns) override {
    if (on_sleep) on_sleep();
    clock_.sleep_until_ns(deadline_ns);
  }
  std::function<void()> on_sleep;  // set while no port is open

 private:
  testing::SharedFakeClock clock_;
};

int replug_count(int usual) {
  const char* const wanted = std::getenv("FOOTLIGHT_REPLUGS");
  return wanted != nullptr ? std::atoi(wanted) : usual;
}

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

TEST_CASE("a node that this user may not open is named together with the command that fixes it") {
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

TEST_CASE("100 frames arrive over hidraw with every byte") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  const auto sink = bench.open_sink();
  for (int i = 0; i < 100; ++i) {
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(i)));
    REQUIRE(bench.shows(some_snapshot(static_cast<std::uint8_t>(i))));
  }
  bench.socket.with_model([&] { CHECK(bench.model.broken_count == 0); });
}

TEST_CASE("frames of the input arrive over hidraw with every byte while frames go out") {
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

TEST_CASE("an unplug is noticed without traffic, and the last frame is back after the replug") {
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
  MESSAGE("replug to last frame: ", static_cast<double>(bench.clock.now_ns() - plugged_ns) * 1e-6, " ms");
}

TEST_CASE("a device that leaves in the middle of a frame gets it when it is back") {
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
    // Not the count alone: the last report before the failing one may be the mode report, after which the driver is
    // about to work for the first time.
    REQUIRE(bench.socket.wait_for([&] { return !bench.socket.is_plugged(); }));
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    bench.socket.with_model([&] { CHECK(report_count() == before + static_cast<std::uint64_t>(at)); });
    // "Unplugged", or the error of a new attempt while the kernel was still removing the device.
    CHECK(sink->trouble().starts_with("nodle: "));
    bench.socket.unplug_at_write = -1;
    bench.socket.unplug();
    bench.socket.plug();
    CHECK(bench.shows(some_snapshot(static_cast<std::uint8_t>(at))));
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
  }
}

TEST_CASE("the device is opened again after a write that fails or is cut short") {
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

TEST_CASE("two devices of one model are told apart by their serial numbers, and neither takes the other's place") {
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

TEST_CASE("closing ends without traffic, and leaves no descriptor and no thread") {
  Bench<NodleModel, testing::SharedFakeClock> bench("nodle");  // no wait ends by a timeout
  bench.socket.plug();
  { const auto warm_up = bench.open_sink(); }
  const testing::ProcessCounts before;
  for (int i = 0; i < 20; ++i) (void)bench.open_sink();
  CHECK(testing::returns_to(before));
}

TEST_CASE("a device that leaves within 100 ms of its check is never opened by hidapi") {
  Bench<NodleModel, ContactClock> bench("nodle");
  bench.socket.plug();
  bench.clock.on_sleep = [&] { bench.socket.unplug(); };
  const auto refused = drivers::open_sink(bench.request, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kNotFound);
  CHECK(refused.error().message.find("unplugged within 100 ms") != std::string::npos);
  CHECK(bench.socket.size_request_count() == 1);  // of the check
}

TEST_CASE("a device that is replugged within 100 ms of its check is opened when it has stayed for 100 ms") {
  Bench<NodleModel, ContactClock> bench("nodle");
  bench.socket.plug();
  int bounce_count = 0;
  bench.clock.on_sleep = [&] {
    if (bounce_count == 3) return;
    ++bounce_count;
    bench.socket.unplug();
    bench.socket.plug();
  };
  for (int i = 0; i < 3; ++i) REQUIRE_FALSE(drivers::open_sink(bench.request, bench.clock));
  CHECK(bench.socket.size_request_count() == 3);  // of the checks
  const TimeNs begin_ns = bench.clock.now_ns();
  const auto sink = bench.open_sink();
  CHECK(bench.clock.now_ns() - begin_ns == kHidSettleNs);
  CHECK(bench.socket.size_request_count() == 5);  // of the check and of hidapi
  bench.send(*sink, some_snapshot(1));
  CHECK(bench.shows(some_snapshot(1)));
}

// Unplugs and replugs a device that shows a frame, and counts what is left open.
template <class AnyBench>
void replug(AnyBench& bench, int count, const std::function<void(int)>& plug) {
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(0));
  REQUIRE(bench.shows(some_snapshot(0)));
  const testing::ProcessCounts before;
  for (int i = 1; i <= count; ++i) {
    CAPTURE(i);
    bench.socket.unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    const auto snapshot = some_snapshot(static_cast<std::size_t>(i % 256));
    bench.send(*sink, snapshot);
    plug(i);
    REQUIRE(bench.shows(snapshot));
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
  }
  CHECK(testing::returns_to(before));
}

TEST_CASE("replugs over hidraw leak no descriptor and no thread, and lose no frame") {
  Bench<NodleModel> bench("nodle");
  bench.socket.plug();
  replug(bench, replug_count(20), [&](int) { bench.socket.plug(); });
}

TEST_CASE("replugs with a bouncing contact leak no descriptor and no thread, and lose no frame") {
  Bench<NodleModel, ContactClock> bench("nodle");
  bench.socket.plug();
  std::mutex plugging;
  int bounces = 0;  // guarded by plugging
  bench.clock.on_sleep = [&] {
    const std::lock_guard lock(plugging);
    if (bounces == 0) return;
    --bounces;
    bench.socket.unplug();
    bench.socket.plug();
  };
  replug(bench, replug_count(20), [&](int i) {
    const std::lock_guard lock(plugging);
    bounces = i % 4;
    bench.socket.plug();
  });
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (const int skipped = footlight::testing::run_under_umockdev(argv)) return skipped;
  return doctest::Context(argc, argv).run();
}
