// What one family of DMX interfaces understands: how a look becomes bytes, and bytes become frames.
//
// A driver is a Widget and a row of the driver table. It has no thread, no mailbox and no opinion on what happens after
// an unplug: drivers/device/device.h runs it, on one thread per device, and makes the Sink and the Source from it. The
// same widget talks to a real device and to its model (drivers/mock), since both are a Transport.
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

// One DMX connector of the device and what is wanted of it.
enum class LineUse : std::uint8_t { kUnused, kOutput, kInput };

// What a widget says of the device once begin() has talked to it.
struct WidgetTraits {
  double rate_hz_max = 44.0;           // what one line takes; the pump sends no more often
  DurationNs keep_alive_ns = kNsPerS;  // an unchanged look is sent again after this long; the frame period where the
                                       // device does not repeat by itself; kTimeNever: never
  bool host_timed = false;             // keep_alive_ns is a frame period that is to be kept on average
  std::string identity;                // for people: "firmware 1.44, serial number 02172589"; may be empty
  std::vector<std::string> remarks;    // what the device cannot do as asked, one sentence each
};

// What one driver measures.
using WidgetFigure = PortFigure;

// What a widget has while it is being called. All of it belongs to the device's thread.
class WidgetContext {
 public:
  virtual ~WidgetContext() = default;
  virtual Transport& transport() = 0;
  virtual TimeNs now_ns() const = 0;
  // For waits below a millisecond, which have to be as exact as the clock; cannot be woken.
  virtual void sleep_until_ns(TimeNs deadline_ns) = 0;
  // Per connector, first is line 0. The size is that of Widget::line_count().
  [[nodiscard]] virtual std::span<const LineUse> lines() const = 0;
  // True when the port is being closed: long waits should end.
  [[nodiscard]] virtual bool stopping() const = 0;
  // Input: one whole frame as it was on the line, start code first. Start codes other than 0 are counted and dropped
  // behind this call.
  virtual void deliver(int line, std::span<const std::uint8_t> line_frame, TimeNs stamp_ns) = 0;
  // Counted as PortCounters::rejected: a message or frame that broke its protocol.
  virtual void count_rejected(std::uint64_t count = 1) = 0;
};

class Widget {
 public:
  virtual ~Widget() = default;
  // DMX connectors of this model, 1 or more. Known before the device is there.
  [[nodiscard]] virtual int line_count() const = 0;
  // Whether line can be used so; a message with the next step where not. Depends on the construction alone; any
  // thread.
  [[nodiscard]] virtual Status can(int line, LineUse use) const = 0;

  // After every connect, and when lines() has changed: forgets what it knew of the device, finds out what it is, sets
  // up what lines() asks for. kUnsupported: the device that is there cannot do it.
  virtual Result<WidgetTraits> begin(WidgetContext& context) = 0;
  // Output: puts a look on a line. Returns when the device has it, or, where the host times the line, when the next
  // look may come. kTimeout: the look is due again.
  virtual Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) = 0;
  // Nothing to send until the deadline: takes what the device says and delivers frames; returns early when it has
  // delivered some, or when the transport was woken.
  virtual Status listen(WidgetContext& context, TimeNs deadline_ns) = 0;
  // Before the device is given back by close(); not after an unplug.
  virtual Status end(WidgetContext&) { return {}; }
  [[nodiscard]] virtual std::vector<WidgetFigure> figures() const { return {}; }
};

}  // namespace footlight::drivers
