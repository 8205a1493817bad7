// Device models in this process, behind the same Transport as real devices. They ship: `mock:` with any driver's id, as
// in `mock:enttec-pro`, works on any machine. Everything above the bus runs as it does with hardware.
//
// As a sink the model keeps the newest frame and counts frames; as a source it plays a slow sine over all 512 slots.
// Faults happen on command: obey("unplug").
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "drivers/driver.h"
#include "drivers/mock/usb_model.h"
#include "sim/core/check.h"

namespace footlight::drivers::mock {

// A device, its USB socket, and the faults of the connection. Threads: safe to use from any.
class MockUsb {
 public:
  // Simulates the device's environment: called with the model when time may have passed; returns when it must be called
  // next.
  using Script = std::function<TimeNs(UsbModel& model, TimeNs now_ns)>;

  explicit MockUsb(std::unique_ptr<UsbModel> model, std::string where = "mock", Script script = {});

  // Runs f(model) exclusively, then lets waiting reads check again. Returns what f returns.
  template <class Model = UsbModel, class F>
  decltype(auto) with_model(F&& f) {
    const Notifier notifier{*this};
    const std::lock_guard lock(mutex_);
    return f(model_as<Model>());
  }
  // Waits until f(model) is true; false if it is not within `patience` of real time.
  template <class Model = UsbModel, class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, std::chrono::system_clock::now() + patience,
                               [&] { return f(std::as_const(model_as<Model>())); });
  }

  // --- Faults
  void unplug();                                // at once; transfers in progress fail
  void plug();                                  // the model is powered on again
  void unplug_after(std::size_t byte_count);    // in the middle of a write, after that many bytes
  void stall(bool stalled);                     // accepts and delivers nothing
  void cut_next_write(std::size_t byte_count);  // the device accepts that many bytes of one write, then the write times
                                                // out
  void limit_reads(std::size_t byte_count);     // a read returns at most that many bytes; 0: no limit
  void slow_down(DurationNs by_ns);             // data from the device arrives that much later
  // The same as text, one command per line: "unplug", "plug", "unplug-after 100", "stall on", "stall off", "cut-write
  // 7", "limit-reads 1", "slow 300" (ms), "garbage 7E00FF" (hex bytes towards the host), "serial EN999999" (before
  // "plug": another device).
  Status obey(std::string_view command);

  [[nodiscard]] bool claimed();  // true while it is open
  // Waits until it is open, or closed.
  bool wait_for_claim(bool claimed, std::chrono::milliseconds patience = std::chrono::seconds(10));
  // Call after moving a simulated clock: waits check it again.
  void clock_moved() { changed_.notify_all(); }
  // For tests with one thread: waits move the clock (Clock::sleep_until_ns) instead of sleeping, and every transfer
  // takes the time of its bus.
  struct BusTime {
    DurationNs control_ns = 0;
    DurationNs bulk_ns = 0;
  };
  void move_clock(BusTime time);

 private:
  friend class MockOpener;
  friend class MockTransport;
  struct Notifier {
    MockUsb& usb;
    ~Notifier() { usb.changed_.notify_all(); }
  };
  template <class Model>
  Model& model_as() {
    auto* model = dynamic_cast<Model*>(model_.get());
    FL_CHECK(model != nullptr);
    return *model;
  }

  const std::string where_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // All below: guarded by mutex_.
  const Script script_;
  TimeNs script_due_ns_ = 0;
  const std::unique_ptr<UsbModel> model_;
  bool plugged_ = true;
  std::uint64_t plug_count_ = 1;  // an open transport belongs to one plug cycle
  bool claimed_ = false;
  bool stalled_ = false;
  std::size_t unplug_after_ = SIZE_MAX;
  std::size_t cut_next_write_ = SIZE_MAX;
  std::size_t read_size_max_ = 0;
  DurationNs slow_ns_ = 0;
  TimeNs data_since_ns_ = kTimeNever;  // since when the device has had data to send
  bool moves_clock_ = false;
  BusTime bus_time_;
};

// The transport has the kind of the driver table's row. `serial`: empty for any.
[[nodiscard]] std::unique_ptr<Opener> make_mock_opener(std::shared_ptr<MockUsb> usb, Clock& clock,
                                                       std::string serial = {});

// The device of a `mock:` endpoint.
struct MockTarget {
  const DriverInfo* driver = nullptr;  // of the device
  UsbModelId row;                      // of its driver's table; an empty one if none matches
  std::shared_ptr<MockUsb> usb;
};
// Devices are made at first use and kept until the program ends. Target: a driver's id, or id/NAME to distinguish
// several. Without a name, sinks and sources get separate devices. kBadInput: the target has another form.
[[nodiscard]] Result<MockTarget> mock_of_target(std::string_view target, bool for_output);

// Plays one frame of all slots every 25 ms on every input line: each slot is a sine of 10 s, from 0 to 255; slot 511
// lags slot 0 by one period.
[[nodiscard]] MockUsb::Script slow_sine();

}  // namespace footlight::drivers::mock
