// Tests common to every driver, with its model in this process. Time stands still unless a test moves it.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "drivers/device/device.h"
#include "drivers/driver.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/mock/open_dmx_model.h"
#include "drivers/ports_factory.h"
#include "drivers/usb_match.h"
#include "tests/support/usb_port_test.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::MockUsb;
using mock::UsbModel;
using testing::FrameKeeper;
using testing::line_frame_of;
using testing::some_snapshot;

// Drivers with their own widget.
std::vector<const DriverInfo*> real_drivers() {
  std::vector<const DriverInfo*> found;
  for (const DriverInfo* driver : drivers())
    if (driver->make_widget != nullptr) found.push_back(driver);
  return found;
}

struct Bench {
  explicit Bench(const DriverInfo& of) : driver(of) {
    auto model = of.make_model();
    // A line without timing, so that a clock that stands still delays nothing.
    if (auto* timed = dynamic_cast<mock::OpenDmxModel*>(model.get())) {
      timed->slot_ns = 0;
      timed->break_min_ns = timed->mark_min_ns = 0;
    }
    usb = std::make_shared<MockUsb>(std::move(model), fmt::format("mock:{}", of.id));
  }

  DevicePlan plan() {
    auto widget = driver.make_widget({.scheme = std::string(driver.id), .universes = {1}}, {});
    REQUIRE_MESSAGE(widget, (widget ? "" : widget.error().message));
    return {.widget = std::move(*widget), .opener = mock::make_mock_opener(usb, clock)};
  }
  int first_line(LineUse use) {
    const DevicePlan device_plan = plan();
    for (int i = 0; i < device_plan.widget->line_count(); ++i)
      if (device_plan.widget->can(i, use)) return i;
    return -1;
  }
  DevicePortConfig port(int on_line) const {
    return {.name = fmt::format("mock:{}", driver.id), .lines = {{.line = on_line, .universe = 1}}};
  }
  std::unique_ptr<DeviceSink> open_sink() {
    line = first_line(LineUse::kOutput);
    Result<std::unique_ptr<DeviceSink>> sink = DeviceSink::open(plan(), port(line), clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  void send(Sink& sink, const Bytes& slots) {
    const FrameView frame{.universe = 1, .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  // Waits for what needs no time, and moves the clock if time is needed.
  template <class Done>
  bool until(Done&& done, DurationNs time_max_ns = 60 * kNsPerS) {
    const TimeNs give_up_ns = clock.now_ns() + time_max_ns;
    while (clock.now_ns() < give_up_ns) {
      if (usb->wait_for([&](const UsbModel& model) { return done(model); }, std::chrono::milliseconds(20))) return true;
      clock.advance_ns(5 * kNsPerMs);
      usb->clock_moved();
    }
    return false;
  }
  bool shows(const Bytes& slots) {
    return until([&](const UsbModel& model) { return model.line(line).frame == line_frame_of(slots); });
  }
  static bool is_gone(Sink& sink) { return testing::wait_for_state(sink, PortState::kGone); }

  const DriverInfo& driver;
  testing::SharedFakeClock clock;
  std::shared_ptr<MockUsb> usb;
  int line = 0;  // of the sink
};

template <class Test>
void for_every_output(Test&& test) {
  for (const DriverInfo* driver : real_drivers()) {
    if ((driver->capabilities & kCanOutput) == 0) continue;
    CAPTURE(driver->id);
    Bench bench(*driver);
    test(bench);
  }
}

TEST_SUITE_BEGIN("every_driver");

TEST_CASE("every driver's model matches the driver's own rows, or must be named") {
  for (const DriverInfo* driver : real_drivers()) {
    CAPTURE(driver->id);
    const auto model = driver->make_model();
    const Bytes device = model->device_descriptor();
    const auto word_at = [&](std::size_t i) { return static_cast<std::uint16_t>(device[i] | device[i + 1] << 8); };
    const UsbMatch match = match_usb_device(word_at(8), word_at(10), model->manufacturer, model->product);
    CHECK(match.ids_are_known);
    const bool generic = (driver->usb_ids[0].quirks & kQuirkGenericUsbIds) != 0 &&
                         driver->usb_ids[0].manufacturer_text.empty() && driver->usb_ids[0].product_text.empty();
    CHECK(match.driver == (generic ? nullptr : driver));
  }
}

TEST_CASE("every driver's frame reaches the line with start code 0 and 512 slots, and so does the next") {
  for_every_output([](Bench& bench) {
    const auto sink = bench.open_sink();
    CHECK(sink->state() == PortState::kWorking);
    bench.send(*sink, some_snapshot(7));
    CHECK(bench.shows(some_snapshot(7)));
    bench.send(*sink, some_snapshot(200));
    CHECK(bench.shows(some_snapshot(200)));
    bench.send(*sink, Bytes{255, 0});
    Bytes expected = some_snapshot(200);
    expected[0] = 255;
    expected[1] = 0;
    CHECK(bench.shows(expected));
    CHECK(sink->counters().rejected == 0);
    CHECK(sink->counters().errors == 0);
  });
}

TEST_CASE("every model's lines have no frame after a power cycle until one is sent") {
  for_every_output([](Bench& bench) {
    {
      const auto sink = bench.open_sink();
      bench.send(*sink, some_snapshot(7));
      REQUIRE(bench.shows(some_snapshot(7)));
    }
    bench.usb->unplug();
    bench.usb->plug();
    bench.usb->with_model([&](UsbModel& model) { CHECK(model.line(bench.line).frame.empty()); });
  });
}

TEST_CASE("every driver reports an unplugged device gone, and shows the last frame again when it is back") {
  for_every_output([](Bench& bench) {
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(7));
    REQUIRE(bench.shows(some_snapshot(7)));
    bench.usb->unplug();
    REQUIRE(bench.is_gone(*sink));
    CHECK(sink->trouble().find(std::string(bench.driver.id)) != std::string::npos);
    bench.send(*sink, some_snapshot(9));
    bench.usb->plug();
    CHECK(bench.shows(some_snapshot(9)));
  });
}

// A bus without notifications: a wait for a device lasts until the deadline.
class SilentBus final : public Opener {
 public:
  SilentBus(std::unique_ptr<Opener> inner, Clock& clock) : inner_(std::move(inner)), clock_(clock) {}
  Result<std::unique_ptr<Transport>> connect() override { return inner_->connect(); }
  std::string identity() override { return inner_->identity(); }
  void wait(TimeNs deadline_ns) override {
    std::unique_lock lock(mutex_);
    deadline_ns_ = deadline_ns;
    changed_.notify_all();
    changed_.wait(lock, [&] { return std::exchange(woken_, false) || clock_.now_ns() >= deadline_ns; });
    deadline_ns_.reset();
  }
  void wake() override {
    inner_->wake();
    end_wait();
  }
  void abort() override {
    inner_->abort();
    end_wait();
  }

  // Returns when a thread waits here for a time after now.
  TimeNs wait_for_a_wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return deadline_ns_ && *deadline_ns_ > clock_.now_ns(); });
    return *deadline_ns_;
  }
  void clock_moved() { changed_.notify_all(); }

 private:
  void end_wait() {
    const std::lock_guard lock(mutex_);
    woken_ = true;
    changed_.notify_all();
  }

  const std::unique_ptr<Opener> inner_;
  Clock& clock_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<TimeNs> deadline_ns_;  // guarded by mutex_
  bool woken_ = false;                 // guarded by mutex_
};

TEST_CASE("every driver has its frame on the line within a second of a replug without a notification") {
  for_every_output([](Bench& bench) {
    bench.line = bench.first_line(LineUse::kOutput);
    DevicePlan plan = bench.plan();
    auto owned_bus = std::make_unique<SilentBus>(std::move(plan.opener), bench.clock);
    SilentBus& bus = *owned_bus;
    plan.opener = std::move(owned_bus);
    auto sink = DeviceSink::open(std::move(plan), bench.port(bench.line), bench.clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    bench.usb->unplug();
    REQUIRE(bench.is_gone(**sink));
    bench.send(**sink, some_snapshot(9));
    const TimeNs looks_again_ns = bus.wait_for_a_wait();
    const TimeNs plugged_ns = bench.clock.now_ns();
    bench.usb->plug();
    bench.clock.sleep_until_ns(looks_again_ns);
    bus.clock_moved();
    // From here on time moves only if the driver itself requests a pause.
    REQUIRE(bench.usb->wait_for(
        [&](const UsbModel& model) { return model.line(bench.line).frame == line_frame_of(some_snapshot(9)); }));
    CHECK(bench.clock.now_ns() - plugged_ns < kNsPerS);
  });
}

TEST_CASE("every driver shows the whole frame after its device was unplugged in the middle of one") {
  for (const std::size_t byte_count : {0u, 1u, 2u, 5u, 100u, 190u, 512u}) {
    CAPTURE(byte_count);
    for_every_output([&](Bench& bench) {
      const auto sink = bench.open_sink();
      bench.usb->unplug_after(byte_count);
      bench.send(*sink, some_snapshot(9));
      // A device with shorter writes stays plugged in.
      (void)bench.until([&](const UsbModel& model) {
        return sink->state() == PortState::kGone || model.line(bench.line).frame == line_frame_of(some_snapshot(9));
      });
      bench.usb->plug();
      CHECK(bench.shows(some_snapshot(9)));
    });
  }
}

TEST_CASE("every driver shows the whole frame after a write was cut short") {
  for (const std::size_t byte_count : {0u, 1u, 2u, 3u, 5u, 100u, 190u, 512u, 517u}) {
    CAPTURE(byte_count);
    for_every_output([&](Bench& bench) {
      const auto sink = bench.open_sink();
      bench.send(*sink, some_snapshot(1));
      REQUIRE(bench.shows(some_snapshot(1)));
      bench.usb->cut_next_write(byte_count);
      bench.send(*sink, some_snapshot(9));
      CHECK(bench.shows(some_snapshot(9)));
    });
  }
}

TEST_CASE("every driver shows the newest frame when a blocked device accepts data again") {
  for_every_output([](Bench& bench) {
    const auto sink = bench.open_sink();
    bench.usb->stall(true);
    for (std::uint8_t i = 1; i <= 20; ++i) bench.send(*sink, some_snapshot(i));
    for (int i = 0; i < 20'000 && sink->state() != PortState::kGone; ++i) {
      bench.clock.advance_ns(20 * kNsPerMs);
      bench.usb->clock_moved();
      (void)bench.usb->wait_for([](const UsbModel&) { return false; }, std::chrono::milliseconds(1));
    }
    REQUIRE(sink->state() == PortState::kGone);
    CHECK(sink->counters().errors > 0);
    bench.usb->stall(false);
    CHECK(bench.shows(some_snapshot(20)));
    CHECK(bench.until([&](const UsbModel&) { return sink->state() == PortState::kWorking; }));
  });
}

TEST_CASE("every driver works with a device that answers late, in pieces, and between noise") {
  for_every_output([](Bench& bench) {
    bench.usb->limit_reads(3);
    bench.usb->slow_down(5 * kNsPerMs);
    bench.line = bench.first_line(LineUse::kOutput);
    DevicePortConfig config = bench.port(bench.line);
    // Opening blocks as long as the answers take, so time must advance by itself.
    std::unique_ptr<DeviceSink> sink;
    std::string refusal;
    std::atomic<bool> opened{false};
    std::thread opener([&] {
      auto result = DeviceSink::open(bench.plan(), config, bench.clock);
      if (result)
        sink = std::move(*result);
      else
        refusal = result.error().message;
      opened = true;
    });
    const bool in_time = bench.until([&](const UsbModel&) { return opened.load(); });
    if (!in_time) bench.usb->unplug();
    opener.join();
    REQUIRE_MESSAGE(sink != nullptr, refusal);
    REQUIRE(bench.usb->obey("garbage 00E7FF7E0AFFFF0F0F47"));
    bench.send(*sink, some_snapshot(3));
    CHECK(bench.shows(some_snapshot(3)));
  });
}

TEST_CASE("no driver uses another device in the same socket instead of the unplugged one") {
  for_every_output([](Bench& bench) {
    const std::string serial = bench.usb->with_model([](UsbModel& model) { return model.serial; });
    if (serial.empty()) return;  // then only the socket identifies it
    const auto sink = bench.open_sink();
    bench.usb->unplug();
    REQUIRE(bench.is_gone(*sink));
    REQUIRE(bench.usb->obey("serial OTHER99"));
    bench.usb->plug();
    CHECK(bench.until([&](const UsbModel&) { return sink->trouble().find("OTHER99") != std::string::npos; }));
    CHECK_FALSE(bench.usb->claimed());
    bench.usb->unplug();
    REQUIRE(bench.usb->obey("serial " + serial));
    bench.usb->plug();
    bench.send(*sink, some_snapshot(5));
    CHECK(bench.shows(some_snapshot(5)));
  });
}

TEST_CASE("every driver leaves the last frame on the line when it is closed, or zeros with blackout_on_exit") {
  for_every_output([](Bench& bench) {
    for (const bool dark : {false, true}) {
      CAPTURE(dark);
      bench.line = bench.first_line(LineUse::kOutput);
      DevicePortConfig config = bench.port(bench.line);
      config.blackout_on_exit = dark;
      auto sink = DeviceSink::open(bench.plan(), config, bench.clock);
      REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
      bench.send(**sink, some_snapshot(7));
      REQUIRE(bench.shows(some_snapshot(7)));
      std::atomic<bool> closed{false};
      std::thread closer([&] {
        (*sink)->close(bench.clock.now_ns());
        closed = true;
      });
      CHECK(bench.until([&](const UsbModel&) { return closed.load(); }));
      closer.join();
      CHECK_FALSE(bench.usb->claimed());
      CHECK((*sink)->state() == PortState::kEnded);
      const Bytes frame = bench.usb->with_model([&](UsbModel& model) { return model.line(bench.line).frame; });
      CHECK(frame == line_frame_of(dark ? Bytes(512, 0) : some_snapshot(7)));
    }
  });
}

TEST_CASE("no driver keeps its thread when its sink is destroyed while the device accepts nothing") {
  for_every_output([](Bench& bench) {
    auto sink = bench.open_sink();
    bench.usb->stall(true);
    bench.send(*sink, some_snapshot(7));
    sink.reset();  // the clock stands still: a timeout would never end
    CHECK_FALSE(bench.usb->claimed());
  });
}

TEST_CASE("a thousand replugs leak no descriptor or thread of any driver and lose no universe") {
  for_every_output([](Bench& bench) {
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(1));
    REQUIRE(bench.shows(some_snapshot(1)));
    const testing::ProcessCounts before;
    for (int i = 0; i < 1000; ++i) {
      bench.usb->unplug();
      REQUIRE(bench.is_gone(*sink));
      const Bytes snapshot = some_snapshot(static_cast<std::uint8_t>(i));
      bench.send(*sink, snapshot);
      bench.usb->plug();
      REQUIRE(bench.shows(snapshot));
    }
    CHECK(testing::returns_to(before));
    CHECK(bench.until([&](const UsbModel&) { return sink->link().stats().connects == 1001; }));
  });
}

TEST_CASE("every driver with an input delivers the frames of its line, address 1 in slot 0") {
  for (const DriverInfo* driver : real_drivers()) {
    if ((driver->capabilities & kCanInput) == 0) continue;
    CAPTURE(driver->id);
    Bench bench(*driver);
    const int line = bench.first_line(LineUse::kInput);
    auto source = DeviceSource::open(bench.plan(), bench.port(line), bench.clock);
    REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
    FrameKeeper keeper;
    for (std::uint8_t i = 1; i <= 20; ++i) {
      REQUIRE(bench.until([&](const UsbModel& model) { return model.listens(line); }));
      bench.usb->with_model([&](UsbModel& model) { model.receive_line_frame(line, line_frame_of(some_snapshot(i))); });
      REQUIRE(bench.until([&](const UsbModel&) {
        REQUIRE((*source)->poll(bench.clock.now_ns(), keeper));
        return !keeper.kept.empty() && keeper.kept.back().slots == some_snapshot(i);
      }));
      CHECK(keeper.kept.back().view.universe == 1);
    }
    CHECK((*source)->counters().rejected == 0);
    bench.usb->unplug();
    REQUIRE(testing::poll_until(
        **source, [&] { (void)(*source)->poll(0, keeper); }, [&] { return (*source)->state() == PortState::kGone; }));
    bench.usb->plug();
    REQUIRE(bench.until(
        [&](const UsbModel& model) { return (*source)->state() != PortState::kGone && model.listens(line); }));
    bench.usb->with_model([&](UsbModel& model) { model.receive_line_frame(line, line_frame_of(some_snapshot(99))); });
    CHECK(bench.until([&](const UsbModel&) {
      REQUIRE((*source)->poll(bench.clock.now_ns(), keeper));
      return keeper.kept.back().slots == some_snapshot(99);
    }));
  }
}

TEST_CASE("mock endpoints work for every driver") {
  testing::SharedFakeClock clock;
  for (const DriverInfo* driver : real_drivers()) {
    CAPTURE(driver->id);
    const std::string target = fmt::format("{}/mock-endpoint-test", driver->id);
    if ((driver->capabilities & kCanOutput) != 0) {
      const auto sink = open_sink({.scheme = "mock", .target = target, .universes = {2}}, clock);
      REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
      CHECK((*sink)->state() == PortState::kWorking);
    }
  }
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
