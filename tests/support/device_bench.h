// A driver of the table with its model in this process, and the faults that every driver must survive. Time stands
// still unless a test moves it.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/device/device.h"
#include "drivers/driver.h"
#include "drivers/mock/mock_usb.h"
#include "tests/support/usb_port_test.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::testing {

using drivers::mock::Bytes;

constexpr Universe kBenchUniverse = 3;

// Calls before_send() before each transfer to the device.
class WatchedOpener final : public drivers::Opener {
 public:
  WatchedOpener(std::unique_ptr<drivers::Opener> inner, std::function<void()> before_send)
      : inner_(std::move(inner)), before_send_(std::move(before_send)) {}
  Result<std::unique_ptr<drivers::Transport>> connect() override {
    FL_ASSIGN(auto transport, inner_->connect());
    return std::make_unique<Watched>(std::move(transport), before_send_);
  }
  void wait(TimeNs deadline_ns) override { inner_->wait(deadline_ns); }
  void wake() override { inner_->wake(); }
  std::string identity() override { return inner_->identity(); }
  void abort() override { inner_->abort(); }

 private:
  class Watched final : public drivers::Transport {
   public:
    Watched(std::unique_ptr<drivers::Transport> inner, const std::function<void()>& before_send)
        : inner_(std::move(inner)), before_send_(before_send) {}
    std::string where() const override { return inner_->where(); }
    std::string serial() const override { return inner_->serial(); }
    Status wait(TimeNs deadline_ns) override { return inner_->wait(deadline_ns); }
    Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
      before_send_();
      return inner_->write(bytes, deadline_ns);
    }
    Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
      return inner_->read(into, deadline_ns);
    }
    Status control_out(const drivers::ControlRequest& request, std::span<const std::uint8_t> bytes,
                       TimeNs deadline_ns) override {
      before_send_();
      return inner_->control_out(request, bytes, deadline_ns);
    }
    Result<std::size_t> control_in(const drivers::ControlRequest& request, std::span<std::uint8_t> into,
                                   TimeNs deadline_ns) override {
      return inner_->control_in(request, into, deadline_ns);
    }
    Status write_endpoint(std::uint8_t endpoint, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
      before_send_();
      return inner_->write_endpoint(endpoint, bytes, deadline_ns);
    }
    Result<std::size_t> read_endpoint(std::uint8_t endpoint, std::span<std::uint8_t> into,
                                      TimeNs deadline_ns) override {
      return inner_->read_endpoint(endpoint, into, deadline_ns);
    }

   private:
    const std::unique_ptr<drivers::Transport> inner_;
    const std::function<void()>& before_send_;
  };
  const std::unique_ptr<drivers::Opener> inner_;
  const std::function<void()> before_send_;
};

struct DeviceBench {
  // row: of the driver's table.
  explicit DeviceBench(std::string_view driver_id, std::size_t row = 0)
      : driver(*drivers::find_driver(driver_id)), model_row(driver.usb_ids[row]) {
    usb->with_model([](auto& model) {
      if (model.serial.empty()) model.serial = "S1";
    });
  }

  SharedFakeClock clock;
  const drivers::DriverInfo& driver;
  const drivers::UsbModelId model_row;
  std::shared_ptr<drivers::mock::MockUsb> usb =
      std::make_shared<drivers::mock::MockUsb>(driver.make_model(), "mock:" + std::string(driver.id));
  int output_line = 0, input_line = 0;
  std::function<void()> before_send = [] {};

  drivers::DevicePlan plan() {
    auto widget = driver.make_widget({}, model_row);
    REQUIRE(widget);
    return {.widget = std::move(*widget),
            .opener =
                std::make_unique<WatchedOpener>(drivers::mock::make_mock_opener(usb, clock), [this] { before_send(); }),
            .retry_ns = 250 * kNsPerMs};
  }
  drivers::DevicePortConfig port(int line) const {
    return {.name = "mock:" + std::string(driver.id), .lines = {{.line = line, .universe = kBenchUniverse}}};
  }
  std::unique_ptr<drivers::DeviceSink> open_sink() {
    auto sink = drivers::DeviceSink::open(plan(), port(output_line), clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  std::unique_ptr<drivers::DeviceSource> open_source() {
    auto source = drivers::DeviceSource::open(plan(), port(input_line), clock);
    REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
    return std::move(*source);
  }
  void send(Sink& sink, const Bytes& slots) {
    const FrameView frame{.universe = kBenchUniverse, .stamp_ns = clock.now_ns(), .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  bool shows(const Bytes& slots, std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    return usb->wait_for([&](const auto& model) { return model.line(output_line).frame == line_frame_of(slots); },
                         patience);
  }
  void advance_ns(DurationNs by_ns) {
    clock.advance_ns(by_ns);
    usb->clock_moved();
  }
  // Moves time on in small steps until done(), or by at_most_ns.
  template <class Done>
  bool advance_until(Done&& done, DurationNs at_most_ns = 20 * kNsPerS) {
    for (DurationNs moved_ns = 0; moved_ns < at_most_ns; moved_ns += 10 * kNsPerMs) {
      if (done()) return true;
      advance_ns(10 * kNsPerMs);
      (void)usb->wait_for([](const auto&) { return false; }, std::chrono::milliseconds(1));  // lets the thread work
    }
    return done();
  }
};

template <class Port>
double figure_of(const Port& port, std::string_view name) {
  double value = std::nan("");
  const auto snapshot = [&] {
    for (const drivers::WidgetFigure& one : port.link().figures())
      if (one.name == name) value = one.value;
  };
  snapshot();
  (void)poll_until(port, snapshot, [&] { return !std::isnan(value); });
  return value;
}

// --- Faults that an output must survive, at every byte and transfer; tests common to every driver are in
// every_driver_test.cpp. Each ends with a snapshot on the line.

inline void check_unplug_at_every_transfer(DeviceBench& bench) {
  // The number of transfers of a snapshot.
  std::atomic<int> count{0};
  std::atomic<int> unplug_at{-1};
  bench.before_send = [&] {
    if (count++ == unplug_at) bench.usb->unplug();
  };
  const auto sink = bench.open_sink();
  count = 0;
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  const int transfers = std::max(1, count.load());
  for (int at = 0; at < transfers; ++at) {
    bench.usb->unplug();
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    unplug_at = -1;
    bench.usb->plug();
    REQUIRE(wait_for_state(*sink, PortState::kWorking));
    REQUIRE(bench.shows(some_snapshot(static_cast<std::uint8_t>(1 + at))));
    count = 0;
    unplug_at = at;
    bench.send(*sink, some_snapshot(static_cast<std::uint8_t>(2 + at)));
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    CHECK(sink->trouble().find("plugged") != std::string::npos);
    unplug_at = -1;
    bench.usb->plug();
    CHECK_MESSAGE(bench.shows(some_snapshot(static_cast<std::uint8_t>(2 + at))), "unplugged before transfer ", at);
  }
}

inline void check_cut_write(DeviceBench& bench, std::size_t size) {
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  for (std::size_t cut = 0; cut < size; ++cut) {
    bench.usb->cut_next_write(cut);
    const Bytes snapshot = some_snapshot(static_cast<std::uint8_t>(2 + cut));
    bench.send(*sink, snapshot);
    REQUIRE_MESSAGE(bench.advance_until([&] { return bench.shows(snapshot, std::chrono::milliseconds(1)); }),
                    "cut after byte ", cut);
  }
}

inline void check_garbage(DeviceBench& bench) {
  const auto sink = bench.open_sink();
  for (int i = 0; i < 300; ++i)
    bench.usb->with_model([&](auto& model) {
      model.send_to_host(Bytes(static_cast<std::size_t>(i % 70), static_cast<std::uint8_t>(i)));
    });
  bench.send(*sink, some_snapshot(5));
  CHECK(bench.advance_until([&] { return bench.shows(some_snapshot(5), std::chrono::milliseconds(1)); }));
  CHECK(sink->state() == PortState::kWorking);
}

}  // namespace footlight::testing
