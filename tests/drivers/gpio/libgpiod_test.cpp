// The source through the real libgpiod, on an emulated /dev/gpiochip0. Its main() starts it again under umockdev.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <linux/gpio.h>
#include <poll.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <thread>

#include "drivers/gpio/gpio_list.h"
#include "drivers/gpio/gpio_source.h"
#include "drivers/wait/epoll_waiter.h"
#include "sim/pump.h"
#include "sim/system_clock.h"
#include "tests/drivers/gpio/gpio_fs.h"

namespace footlight::drivers {
namespace {

using footlight::testing::GpioFs;
using footlight::testing::Testbed;

struct Machine {
  Testbed testbed;  // first member: destroyed last
  GpioFs chip{testbed, {"STROBE0", "STROBE1", "BLACKOUT", "LED"}};
  SystemClock clock;
  std::shared_ptr<GpioChips> chips = make_gpio_chips();

  [[nodiscard]] Result<std::unique_ptr<GpioLine>> request(GpioLineRequest request) {
    if (request.chip.empty()) request.chip = "gpiochip0";
    return chips->request(request);
  }
  [[nodiscard]] std::string refusal(GpioLineRequest wanted, ErrorCode code) {
    auto line = request(std::move(wanted));
    REQUIRE_FALSE(line);
    CHECK(line.error().code == code);
    return line.error().message;
  }
};

bool readable(int fd, int timeout_ms = 20'000) {
  pollfd wait{.fd = fd, .events = POLLIN, .revents = 0};
  return ::poll(&wait, 1, timeout_ms) == 1;
}

// Waits in real time; the emulated kernel has its own threads.
template <class F>
bool becomes_true(F&& f) {
  for (int i = 0; i < 5'000; ++i) {
    if (f()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

GpioConfig config_of(std::vector<std::string> lines) {
  GpioConfig config;
  config.chip = "gpiochip0";
  config.lines = std::move(lines);
  config.strobe.hold_ns = 0;
  config.strobe.flashes_hz_max = 0;
  return config;
}

TEST_CASE("edges arrive in order with the stamps of the kernel, and the line is released") {
  Machine machine;
  {
    auto line = machine.request({.line = "1"});
    REQUIRE_MESSAGE(line, line.error().message);
    CHECK(machine.chip.is_requested(1));
    CHECK(machine.chip.consumer(1) == "footlight");
    std::array<GpioEdge, 16> edges;
    CHECK((*line)->read_edges(edges).value() == 0);  // does not block
    const TimeNs now_ns = machine.clock.now_ns();
    machine.chip.drive(1, true, now_ns - 2'000);
    machine.chip.drive(1, false, now_ns - 1'000);
    REQUIRE(readable((*line)->fd()));
    REQUIRE((*line)->read_edges(edges).value() == 2);
    CHECK(edges[0].level);
    CHECK(edges[0].stamp_ns == now_ns - 2'000);
    CHECK_FALSE(edges[1].level);
    CHECK(edges[1].stamp_ns == now_ns - 1'000);
    CHECK((*line)->read_level().value() == false);
    machine.chip.drive(1, true);
    CHECK((*line)->read_level().value() == true);
  }
  CHECK_FALSE(machine.chip.is_requested(1));
}

TEST_CASE("wall clock stamps of a kernel are converted to the pump's clock") {
  Machine machine;
  auto line = machine.request({.line = "0"});
  REQUIRE(line);
  timespec wall{};
  const TimeNs before_ns = machine.clock.now_ns();
  ::clock_gettime(CLOCK_REALTIME, &wall);
  const std::int64_t wall_ns = static_cast<std::int64_t>(wall.tv_sec) * kNsPerS + wall.tv_nsec;
  constexpr DurationNs kAgoNs = kNsPerS;
  machine.chip.drive(0, true, wall_ns - kAgoNs);
  REQUIRE(readable((*line)->fd()));
  std::array<GpioEdge, 16> edges;
  REQUIRE((*line)->read_edges(edges).value() == 1);
  // The two clocks are never read at the same time. However long a thread pauses in between, the stamp is in this
  // range.
  const TimeNs after_ns = machine.clock.now_ns();
  CHECK(edges[0].stamp_ns > before_ns - kAgoNs - (after_ns - before_ns));
  CHECK(edges[0].stamp_ns < after_ns - kAgoNs);
}

TEST_CASE("a listed chip has its own label, and reading it requests no line") {
  Machine machine;
  const auto chips = find_gpio_chips();
  REQUIRE(chips.size() == 1);
  CHECK(chips[0].name == "gpiochip0");
  CHECK(chips[0].label == "footlight-gpio");
  CHECK(chips[0].line_count == 4);
  CHECK(chips[0].node == "/dev/gpiochip0");
  CHECK(chips[0].readiness == Readiness::kReady);
  for (unsigned line = 0; line < 4; ++line) CHECK_FALSE(machine.chip.is_requested(line));
}

TEST_CASE("a line is found by name, a chip by path") {
  Machine machine;
  auto line = machine.request({.chip = "/dev/gpiochip0", .line = "BLACKOUT"});
  REQUIRE_MESSAGE(line, line.error().message);
  CHECK(machine.chip.is_requested(2));
}

TEST_CASE("polarity and bias are requested from the kernel, and levels are logical") {
  Machine machine;
  auto line = machine.request({.line = "0", .active_low = true, .bias = GpioBias::kPullUp});
  REQUIRE(line);
  CHECK((machine.chip.handle_flags(0) & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0);
  CHECK((machine.chip.handle_flags(0) & GPIOHANDLE_REQUEST_BIAS_PULL_UP) != 0);
  CHECK((*line)->read_level().value() == true);
  auto other = machine.request({.line = "1", .bias = GpioBias::kNone});
  REQUIRE(other);
  CHECK((machine.chip.handle_flags(1) & GPIOHANDLE_REQUEST_BIAS_DISABLE) != 0);
  CHECK((machine.chip.handle_flags(1) & GPIOHANDLE_REQUEST_ACTIVE_LOW) == 0);
}

TEST_CASE("errors name the line, its user, and the next step") {
  Machine machine;
  machine.chip.hold(3, "spi0 CS0");
  const std::string busy = machine.refusal({.line = "3"}, ErrorCode::kIo);
  CHECK(busy ==
        "/dev/gpiochip0 line 3: in use by \"spi0 CS0\"; end that program or take another line: 'gpioinfo "
        "gpiochip0' lists them");
  const std::string missing = machine.refusal({.line = "4"}, ErrorCode::kNotFound);
  CHECK(missing.find("the chip has 4, 0 to 3") != std::string::npos);
  CHECK(machine.refusal({.line = "NOSUCH"}, ErrorCode::kNotFound).find("gpioinfo") != std::string::npos);
  CHECK(machine.refusal({.chip = "gpiochip7", .line = "1"}, ErrorCode::kNotFound).find("gpiodetect") !=
        std::string::npos);
  machine.chip.refuse(EINVAL);
  CHECK(machine.refusal({.line = "1", .bias = GpioBias::kPullUp}, ErrorCode::kUnsupported).find("resistor") !=
        std::string::npos);
  CHECK(machine.refusal({.line = "1"}, ErrorCode::kUnsupported).find("interrupts") != std::string::npos);
  machine.chip.refuse(EPERM);
  (void)machine.refusal({.line = "1"}, ErrorCode::kPermission);
}

TEST_CASE("the error for a line in use by this program names this program") {
  Machine machine;
  auto line = machine.request({.line = "1"});
  REQUIRE(line);
  CHECK(machine.refusal({.line = "1"}, ErrorCode::kIo).find("\"footlight\"") != std::string::npos);
}

// Runs a pump on the emulated chip, like the program.
class Bridge {
 public:
  Bridge(Machine& machine, GpioConfig config) : machine_(machine) {
    auto opened = GpioSource::open(std::move(config), machine.chips, machine.clock);
    REQUIRE_MESSAGE(opened, opened.error().message);
    source_ = std::move(*opened);
    pump_.add_source(*source_);
    thread_ = std::thread([this] { pump_.run(); });
    REQUIRE(becomes_true([this] { return stamp().revision != 0; }));
  }
  ~Bridge() {
    pump_.request_stop();
    thread_.join();
  }
  [[nodiscard]] FrameStamp stamp() { return snapshot().second; }
  [[nodiscard]] int level(Address address) {
    return snapshot().first.at(static_cast<std::size_t>(slot_of_address(address)));
  }
  [[nodiscard]] bool gone() {
    for (int i = 0; i < 3; ++i) {
      const PumpStatus status = pump_.latest_status();
      if (!status.ports.empty() && status.ports[0].state == PortState::kGone) return true;
    }
    return false;
  }

 private:
  std::pair<Slots, FrameStamp> snapshot() {
    Slots slots{};
    FrameStamp stamp;
    universes_->snapshot(0, slots, stamp);
    return {slots, stamp};
  }

  Machine& machine_;
  std::unique_ptr<Universes> universes_ = Universes::make(std::vector<Universe>{1}).value();
  std::unique_ptr<EpollWaiter> waiter_ = EpollWaiter::make().value();
  Pump pump_{*universes_, machine_.clock, *waiter_, {.status_period_ns = 50 * kNsPerMs}};
  std::unique_ptr<GpioSource> source_;
  std::thread thread_;
};

TEST_CASE("an edge reaches the universe with its stamp, through epoll and the pump") {
  Machine machine;
  Bridge bridge(machine, config_of({"0", "STROBE1"}));
  const TimeNs pressed_ns = machine.clock.now_ns();
  machine.chip.drive(1, true, pressed_ns);
  REQUIRE(becomes_true([&] { return bridge.level(2) == 255; }));
  CHECK(bridge.stamp().stamp_ns == pressed_ns);
  CHECK(bridge.level(1) == 0);
  machine.chip.drive(1, false);
  CHECK(becomes_true([&] { return bridge.level(2) == 0; }));
}

TEST_CASE("an overflow of the kernel's queue leaves no lamp on") {
  Machine machine;
  auto source = GpioSource::open(config_of({"0"}), machine.chips, machine.clock);
  REQUIRE(source);
  struct Ignore final : FrameReceiver {
    void receive(const FrameView& frame) override {
      if (frame.start_code == kStartCodeLevels) level = frame.slots[0];
    }
    int level = -1;
  } frames;
  REQUIRE((*source)->poll(machine.clock.now_ns(), frames));
  for (int i = 1; i <= 41; ++i) machine.chip.drive(0, i % 2 == 1);
  CHECK(machine.chip.lost(0) == 25);
  REQUIRE((*source)->poll(machine.clock.now_ns(), frames));
  CHECK(frames.level == 255);  // the queue ends inactive, the line is active
  for (int i = 1; i <= 41; ++i) machine.chip.drive(0, i % 2 == 0);
  REQUIRE((*source)->poll(machine.clock.now_ns(), frames));
  CHECK(frames.level == 0);
}

TEST_CASE("unplugging a chip turns its slots off, plugged in again it works") {
  Machine machine;
  Bridge bridge(machine, config_of({"0"}));
  for (int round = 0; round < 3; ++round) {
    machine.chip.drive(0, true);
    REQUIRE(becomes_true([&] { return bridge.level(1) == 255; }));
    machine.chip.unplug();
    REQUIRE(becomes_true([&] { return bridge.level(1) == 0; }));
    CHECK(becomes_true([&] { return bridge.gone(); }));
    machine.chip.plug();
    REQUIRE(becomes_true([&] { return bridge.level(1) == 255; }));  // read when it is back
    machine.chip.drive(0, false);
    REQUIRE(becomes_true([&] { return bridge.level(1) == 0; }));
  }
}

TEST_CASE("a failed level read loses the lines until a read succeeds") {
  Machine machine;
  machine.chip.drive(0, true);
  Bridge bridge(machine, config_of({"0"}));
  REQUIRE(becomes_true([&] { return bridge.level(1) == 255; }));
  machine.chip.fail_levels(EIO);
  CHECK(becomes_true([&] { return bridge.level(1) == 0; }));
  machine.chip.fail_levels(0);
  CHECK(becomes_true([&] { return bridge.level(1) == 255; }));
}

}  // namespace
}  // namespace footlight::drivers

int main(int argc, char** argv) {
  if (const int skip = footlight::testing::run_under_umockdev(argv); skip != 0) return skip;
  return doctest::Context(argc, argv).run();
}
