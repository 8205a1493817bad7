// One physical DMX interface while it is open: its thread and its ports.
//
// Only the device thread calls the Widget and its Transport. It opens the device, sends the newest snapshot of each
// output line, repeats it every keep_alive_ns, and receives frames from the input lines. After an unplug it searches
// for the same device until it is back, and sends every snapshot again. The thread and the pump share one mailbox per
// line, which holds one frame, and one eventfd per port. A newer frame replaces an unused one, which is counted as
// dropped. The lock is held for a copy of 512 bytes, never during I/O.
//
// A device is opened once in a program, whatever the number of its ports. An input and an output of the same interface,
// or its second connector, use the same thread. Closing the last port closes the device.
//
// Closing a sink leaves the last levels on the line if the device repeats them itself, so that a crashed or restarted
// bridge does not black out a stage. With blackout_on_exit it sends zeros instead.
//
// Threads: a port belongs to one thread, the pump's; run_on_device() and figures() may be called from any. Errors while
// running: state() becomes kGone and trouble() gives the reason.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/device/widget.h"
#include "drivers/transport/transport.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

inline constexpr std::size_t kLineFrameMax = 1 + kSlotCountMax;  // the start code and 512 slots

struct DeviceLine {
  int line = 0;  // connector, from 0
  Universe universe = 0;
};

// The configuration of one port of a device.
struct DevicePortConfig {
  std::string name;  // Port::name(): the endpoint as the user wrote it
  std::vector<DeviceLine> lines;
  bool blackout_on_exit = false;  // outputs: send zeros when the port is closed
  bool wait_for_device = false;   // open() succeeds even if no device is plugged in
};

// How to open and drive a device. Not used if the device is open already.
struct DevicePlan {
  std::unique_ptr<Widget> widget;
  std::unique_ptr<Opener> opener;
  DurationNs retry_ns = 250 * kNsPerMs;  // how often to search for a lost device that has no hotplug notification
};

// In addition to PortCounters; a copy taken at one instant.
struct DeviceStats {
  std::uint64_t connects = 0;           // times the device was opened
  std::uint64_t keep_alives = 0;        // repeats of an unchanged snapshot
  std::uint64_t other_start_codes = 0;  // input frames without levels (RDM, text, tests); not passed on
};

class Device;       // the thread and its shared state
struct DevicePort;  // the state that a port and the thread share

// Called once on the device's thread between two frames. context: nullptr if the device is gone or closed.
using DeviceJob = std::function<void(Widget& widget, WidgetContext* context)>;

// A reference to an open device that does not keep it open. Any thread.
class DeviceHandle {
 public:
  explicit DeviceHandle(std::weak_ptr<Device> device) : device_(std::move(device)) {}
  // True if the device was closed for good.
  [[nodiscard]] bool is_gone() const;
  // As DeviceLink::run_on_device(); returns false without running the job if the device is closed.
  bool run_on_device(DeviceJob job) const;

 private:
  std::weak_ptr<Device> device_;
};

// Common part of a device's sinks and sources.
class DeviceLink {
 public:
  // Opens the device on the caller's thread and starts its thread, or joins the one that has it open. kPermission:
  // another port of this program uses a line.
  static Result<DeviceLink> open(DevicePlan plan, const DevicePortConfig& config, LineUse use, Clock& clock);
  DeviceLink(DeviceLink&&) noexcept;
  DeviceLink& operator=(DeviceLink&&) = delete;
  ~DeviceLink();  // without close(): ends at once; the last port cuts off a write in progress

  // Sends the widget's final messages, and closes the device if this is its last port.
  void close();
  void run_on_device(DeviceJob job) const;
  [[nodiscard]] DeviceHandle handle() const { return DeviceHandle(device_); }
  // The lines of this port.
  [[nodiscard]] std::span<const DeviceLine> lines() const;
  // True if its widget supports RDM (drivers/rdm/rdm_widget.h).
  [[nodiscard]] bool has_rdm() const;
  // The device's identity as the widget read it ("firmware 1.44, serial number 2172589"), and requested features that
  // it lacks.
  [[nodiscard]] std::string identity() const;
  [[nodiscard]] std::vector<std::string> remarks() const;
  // Widget::figures() as of an earlier request. Requests newer ones; poll_fd() becomes readable when they are there.
  [[nodiscard]] std::vector<WidgetFigure> figures() const;
  void take_figures(std::vector<PortFigure>& into) const;  // likewise
  [[nodiscard]] DeviceStats stats() const;

  [[nodiscard]] Device& device() const { return *device_; }
  [[nodiscard]] DevicePort& port() const { return *port_; }

 private:
  DeviceLink(std::shared_ptr<Device> device, std::shared_ptr<DevicePort> port);
  std::shared_ptr<Device> device_;
  std::shared_ptr<DevicePort> port_;
};

class DeviceSink final : public Sink {
 public:
  static Result<std::unique_ptr<DeviceSink>> open(DevicePlan plan, const DevicePortConfig& config, Clock& clock);

  std::string name() const override;
  int poll_fd() const override;  // readable when state() may have changed
  PortState state() const override;
  std::string trouble() const override;
  PortCounters counters() const override;
  void take_figures(std::vector<PortFigure>& into) const override { link_.take_figures(into); }
  // Slots past the end of a short frame keep their last levels.
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  std::span<const Universe> universes() const override;
  double rate_hz_max() const override;
  std::optional<std::uint64_t> frames_on_line() const override;
  // The host stops repeating until the next send(). A device that repeats frames itself continues; no protocol stops
  // it.
  void rest(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;  // returns when the widget's write has ended or timed out

  [[nodiscard]] const DeviceLink& link() const { return link_; }

 private:
  explicit DeviceSink(DeviceLink link) : link_(std::move(link)) {}
  DeviceLink link_;
};

class DeviceSource final : public Source {
 public:
  static Result<std::unique_ptr<DeviceSource>> open(DevicePlan plan, const DevicePortConfig& config, Clock& clock);
  ~DeviceSource() override;

  std::string name() const override;
  int poll_fd() const override;  // readable when a frame has come or state() may have changed
  TimeNs next_deadline_ns() const override;
  PortState state() const override;  // kWaiting: open, and every line has been silent for 1.25 s
  std::string trouble() const override;
  PortCounters counters() const override;
  void take_figures(std::vector<PortFigure>& into) const override { link_.take_figures(into); }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;  // at most one frame per line: the newest
  std::span<const Universe> universes() const override;

  [[nodiscard]] const DeviceLink& link() const { return link_; }

 private:
  explicit DeviceSource(DeviceLink link);
  struct Line {
    std::array<std::uint8_t, kLineFrameMax> frame{};  // of the last poll(); FrameView refers to it
    std::size_t size = 0;
    TimeNs received_ns = 0;  // when the newest frame was received
    bool quiet = true;
  };
  DeviceLink link_;
  std::vector<Line> lines_;  // in the order of the port's lines
};

}  // namespace footlight::drivers
