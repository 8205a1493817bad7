// One physical DMX interface while it is open: its thread, and the ports that are made from it.
//
// The device thread alone talks to the Widget and to its Transport. It opens the device, sends the newest look of each
// output line, repeats it every keep_alive_ns, and takes what the input lines bring. After an unplug it looks for the
// same device until it is back, and sends every look again. Between that thread and the pump stand one mailbox of one
// frame per line, where a newer frame replaces an unused one and is counted as dropped, and an eventfd per port. The
// lock is held for a copy of 512 bytes and never during I/O.
//
// A device is open once in a program, whatever the number of its ports: an input and an output of the same interface,
// or its second connector, join the thread that is there. The last port to be closed gives the device back.
//
// Closing a sink leaves the last look on the line where the device repeats it by itself: a crashed or restarted bridge
// must not black a stage out. blackout_on_exit asks for zeros instead.
//
// Threads: a port belongs to one thread, the pump's; run_on_device() and figures() may be called from any. Errors while
// running: state() turns to kGone and trouble() says why.
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

// What a port asks of its device.
struct DevicePortConfig {
  std::string name;  // Port::name(): the endpoint as the user wrote it
  std::vector<DeviceLine> lines;
  bool blackout_on_exit = false;  // outputs: send zeros when the port is closed
  bool wait_for_device = false;   // open() succeeds though nothing is plugged in
};

// The way to a device and what speaks to it. Not used where the device is open already.
struct DevicePlan {
  std::unique_ptr<Widget> widget;
  std::unique_ptr<Opener> opener;
  DurationNs retry_ns = 250 * kNsPerMs;  // how often a lost device is looked for where nothing announces it
};

// Beyond PortCounters; a copy, taken at one instant.
struct DeviceStats {
  std::uint64_t connects = 0;           // times the device was opened
  std::uint64_t keep_alives = 0;        // looks sent again although unchanged
  std::uint64_t other_start_codes = 0;  // input frames that carry no levels (RDM, text, tests); not passed on
};

class Device;       // the thread and what it shares
struct DevicePort;  // what a port and the thread share

// Called once on the device's thread between two frames. context: nullptr where the device is gone or closed.
using DeviceJob = std::function<void(Widget& widget, WidgetContext* context)>;

// An open device, for those who must not keep it open. Any thread.
class DeviceHandle {
 public:
  explicit DeviceHandle(std::weak_ptr<Device> device) : device_(std::move(device)) {}
  // Whether it has been given back for good.
  [[nodiscard]] bool is_gone() const;
  // As DeviceLink::run_on_device(); false, and the job is not run: it is gone.
  bool run_on_device(DeviceJob job) const;

 private:
  std::weak_ptr<Device> device_;
};

// What sinks and sources of a device have in common.
class DeviceLink {
 public:
  // Opens the device on the caller's thread and starts its own thread; or joins the one that has it open.
  // kPermission: a line is in use by another port of this program.
  static Result<DeviceLink> open(DevicePlan plan, const DevicePortConfig& config, LineUse use, Clock& clock);
  DeviceLink(DeviceLink&&) noexcept;
  DeviceLink& operator=(DeviceLink&&) = delete;
  ~DeviceLink();  // without close(): ends at once, a write in progress is cut off where this is the last port

  // Sends the last words, and gives the device back where this is the last port of it.
  void close();
  void run_on_device(DeviceJob job) const;
  [[nodiscard]] DeviceHandle handle() const { return DeviceHandle(device_); }
  // Those of the port.
  [[nodiscard]] std::span<const DeviceLine> lines() const;
  // Whether its widget carries RDM (drivers/rdm/rdm_widget.h).
  [[nodiscard]] bool has_rdm() const;
  // What the widget said of the device ("firmware 1.44, serial number 2172589"), and what it cannot do as asked.
  [[nodiscard]] std::string identity() const;
  [[nodiscard]] std::vector<std::string> remarks() const;
  // Widget::figures() as they were when somebody last asked; asks for newer ones, after which poll_fd() is readable.
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
  // Slots past the end of a short frame keep the levels sent before.
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  std::span<const Universe> universes() const override;
  double rate_hz_max() const override;
  std::optional<std::uint64_t> frames_on_line() const override;
  // The host repeats nothing until the next send(). A device that repeats by itself goes on; no protocol stops it.
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
  PortState state() const override;  // kWaiting: open, and every line has been quiet for 1.25 s
  std::string trouble() const override;
  PortCounters counters() const override;
  void take_figures(std::vector<PortFigure>& into) const override { link_.take_figures(into); }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;  // at most one frame of each line: the newest
  std::span<const Universe> universes() const override;

  [[nodiscard]] const DeviceLink& link() const { return link_; }

 private:
  explicit DeviceSource(DeviceLink link);
  struct Line {
    std::array<std::uint8_t, kLineFrameMax> frame{};  // of the last poll(); FrameView points into it
    std::size_t size = 0;
    TimeNs heard_ns = 0;  // when the newest frame came
    bool quiet = true;
  };
  DeviceLink link_;
  std::vector<Line> lines_;  // as the port's lines
};

}  // namespace footlight::drivers
