// A real widget: FOOTLIGHT_REAL_ENTTEC_PRO=EN172589 build/dev/tests/drivers/usb/drivers_real_usb_tests
//
// It plays a slow ramp on address 1 for two seconds, and zeros at the end: unplug fixtures that must not move. If
// FOOTLIGHT_REAL_ENTTEC_PRO_INPUT is set as well, it expects a DMX line on the widget's input instead.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "drivers/device/device.h"
#include "drivers/ports_factory.h"
#include "sim/system_clock.h"
#include "tests/support/usb_port_test.h"

namespace footlight::drivers {
namespace {

PortRequest request_of_environment() {
  return {.scheme = "enttec-pro",
          .target = std::getenv("FOOTLIGHT_REAL_ENTTEC_PRO"),
          .universes = {1},
          .blackout_on_exit = true};
}

TEST_CASE("a real widget accepts 40 frames a second for two seconds without an error") {
  if (std::getenv("FOOTLIGHT_REAL_ENTTEC_PRO_INPUT") != nullptr) return;
  SystemClock clock;
  auto sink = open_sink(request_of_environment(), clock);
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  MESSAGE(dynamic_cast<DeviceSink&>(**sink).link().identity(), ", ", (*sink)->rate_hz_max(), " Hz");
  TimeNs due_ns = clock.now_ns();
  for (int i = 0; i < 80; ++i, due_ns += 25 * kNsPerMs) {
    const std::vector<std::uint8_t> slots(1, static_cast<std::uint8_t>(i * 3));
    const FrameView frame{.universe = 1, .slots = slots};
    REQUIRE((*sink)->send(clock.now_ns(), {&frame, 1}));
    clock.sleep_until_ns(due_ns);
  }
  CHECK((*sink)->state() == PortState::kWorking);
  CHECK((*sink)->counters().errors == 0);
  (*sink)->close(clock.now_ns());
  CHECK((*sink)->counters().frames >= 75);
}

TEST_CASE("a real widget receives its line") {
  if (std::getenv("FOOTLIGHT_REAL_ENTTEC_PRO_INPUT") == nullptr) return;
  SystemClock clock;
  auto source = open_source(request_of_environment(), clock);
  REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
  testing::FrameKeeper keeper;
  CHECK(testing::poll_until(
      **source, [&] { (void)(*source)->poll(clock.now_ns(), keeper); }, [&] { return keeper.kept.size() >= 20; }));
  CHECK((*source)->counters().rejected == 0);
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (std::getenv("FOOTLIGHT_REAL_ENTTEC_PRO") == nullptr) {
    std::fprintf(stderr, "SKIPPED: FOOTLIGHT_REAL_ENTTEC_PRO is not set to the serial number of a widget\n");
    return 77;
  }
  return doctest::Context(argc, argv).run();
}
