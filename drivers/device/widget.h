// The protocol of one family of DMX interfaces: encodes snapshots to bytes and decodes bytes to frames.
//
// A driver is a Widget and a row of the driver table. A Widget has no thread and no mailbox, and does not handle
// unplugging. drivers/device/device.h runs it, on one thread per device, and makes the Sink and the Source from it. The
// same widget drives a real device and its model (drivers/mock), since both are a Transport.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "drivers/transport/transport.h"
#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// The use of one DMX connector of the device.
enum class LineUse : std::uint8_t { kUnused, kOutput, kInput };

// What begin() has found out about the device.
struct WidgetTraits {
  double rate_hz_max = 44.0;           // the maximum per line; the pump sends no more often
  DurationNs keep_alive_ns = kNsPerS;  // a repeat of an unchanged snapshot is due after this time; the frame period if
                                       // the device does not repeat itself; kTimeNever: never
  bool host_timed = false;             // keep_alive_ns is a frame period to keep on average
  std::string identity;                // "firmware 1.44, serial number 02172589"; may be empty
  std::vector<std::string> remarks;    // requested features that the device lacks, one sentence each
};

// A value that one driver measures.
using WidgetFigure = PortFigure;

// What a widget may use during a call. Belongs to the device's thread.
class WidgetContext {
 public:
  virtual ~WidgetContext() = default;
  virtual Transport& transport() = 0;
  virtual TimeNs now_ns() const = 0;
  // For waits below a millisecond, which must be as exact as the clock; cannot be interrupted.
  virtual void sleep_until_ns(TimeNs deadline_ns) = 0;
  // Per connector; the first is line 0. The size is Widget::line_count().
  [[nodiscard]] virtual std::span<const LineUse> lines() const = 0;
  // True when the port is being closed: long waits should end.
  [[nodiscard]] virtual bool stopping() const = 0;
  // Input: one whole frame as it was on the line, start code first. Frames with start codes other than 0 are counted
  // and dropped after this call.
  virtual void deliver(int line, std::span<const std::uint8_t> line_frame, TimeNs stamp_ns) = 0;
  // Counted as PortCounters::rejected: a message or frame that violated its protocol.
  virtual void count_rejected(std::uint64_t count = 1) = 0;
};

class Widget {
 public:
  virtual ~Widget() = default;
  // DMX connectors of this model, 1 or more. Available before the device is plugged in.
  [[nodiscard]] virtual int line_count() const = 0;
  // Whether the line supports this use; if not, a message with the next step. Depends on the constructor's arguments
  // only; any thread.
  [[nodiscard]] virtual Status can(int line, LineUse use) const = 0;

  // Called after every connect, and when lines() has changed. Discards earlier state of the device, identifies it, and
  // sets up what lines() requires. kUnsupported: this device does not support it.
  virtual Result<WidgetTraits> begin(WidgetContext& context) = 0;
  // Output: sends a snapshot to a line. Returns when the device has it, or, if the host times the line, when the next
  // snapshot may be sent. kTimeout: the snapshot must be sent again.
  virtual Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) = 0;
  // Called when there is nothing to send until the deadline: reads what the device sends and delivers frames. Returns
  // early when frames were delivered or the transport was woken.
  virtual Status listen(WidgetContext& context, TimeNs deadline_ns) = 0;
  // Called before close() closes the device; not after an unplug.
  virtual Status end(WidgetContext&) { return {}; }
  [[nodiscard]] virtual std::vector<WidgetFigure> figures() const { return {}; }
};

}  // namespace footlight::drivers
