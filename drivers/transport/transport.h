// A way to a device, and the means to get back to it after an unplug.
//
// A port has one thread for its device. It alone calls connect(), wait() and everything of a Transport but where() and
// serial(); these block, up to a deadline. Any other thread may call wake() and abort(), and nothing else.
//
// Deadlines are absolute, on the clock that the implementation was made with.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// A control transfer to or from endpoint 0 (USB 2.0, section 9.3).
struct ControlRequest {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

struct LineSettings {
  int baud = 250'000;
  int stop_bits = 2;    // 8 bits, no parity
  int latency_ms = 16;  // how long received bytes may wait inside the interface for more to come; 1 to 255
};

// One thing heard on a serial line.
struct LineByte {
  std::uint8_t value = 0;
  bool is_break = false;       // the line was low for longer than a byte; value means nothing
  bool framing_error = false;  // value is doubtful
  bool lost_before = false;    // the receiver overran: bytes are missing before this one
  TimeNs stamp_ns = 0;         // as good as the transport knows: when the packet that held it arrived
};

// What one IN transfer brings at most: whole packets at full and at high speed.
inline constexpr std::size_t kUsbTransferSizeMax = 512;

// An open device. Destroying it gives the device back: its interface is released and the kernel driver bound again.
//
// Errors of all calls: kTimeout: the device did not take everything in time; what it took is lost to the caller.
// kDisconnected: unplugged, or abort() was called. kIo: the bus reported an error; open the device afresh.
// kUnsupported: not a transport of that kind.
class Transport {
 public:
  virtual ~Transport() = default;
  // What the device is called at the moment, for messages: "/dev/bus/usb/001/004".
  [[nodiscard]] virtual std::string where() const = 0;
  // The serial number in its USB descriptor; may be empty.
  [[nodiscard]] virtual std::string serial() const = 0;
  // Sleeps until the deadline or wake(); kDisconnected where an unplug is noticed meanwhile. For widgets that have
  // nothing to read.
  virtual Status wait(TimeNs deadline_ns) = 0;

  // --- A pipe of bytes (a serial port, an FTDI chip) or of reports (HID: one whole report a call, its number first).
  // Writes all of it.
  virtual Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) = 0;
  // Waits for at least one byte, or for one report; returns how many bytes were put into `into`. 0: the deadline has
  // passed or wake() was called.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) = 0;

  // --- USB devices with endpoints of their own.
  virtual Status control_out(const ControlRequest& request, std::span<const std::uint8_t> bytes, TimeNs deadline_ns);
  virtual Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                         TimeNs deadline_ns);
  // Bulk or interrupt, as the device's descriptor says. As write() and read(). A read brings bytes of one transfer
  // only, so that packet borders are not lost where `into` has kUsbTransferSizeMax bytes. The first read of an endpoint
  // begins to listen there.
  virtual Status write_endpoint(std::uint8_t endpoint, std::span<const std::uint8_t> bytes, TimeNs deadline_ns);
  virtual Result<std::size_t> read_endpoint(std::uint8_t endpoint, std::span<std::uint8_t> into, TimeNs deadline_ns);

  [[nodiscard]] virtual std::size_t packet_size(std::uint8_t endpoint) const;

  // --- Serial lines whose timing is the host's.
  virtual Status set_line(const LineSettings& settings, TimeNs deadline_ns);
  virtual Status set_break(bool on, TimeNs deadline_ns);
  // Whether the last bit of what was written has left the transmitter, as the chip says it and not as the clock would
  // have it.
  virtual Result<bool> transmitter_empty(TimeNs deadline_ns);
  // As read(), with breaks where they came. Not to be mixed with read().
  virtual Result<std::size_t> read_line(std::span<LineByte> into, TimeNs deadline_ns);
};

// Knows which device is meant and opens it as often as needed. The first connect() that succeeds pins the device: by
// its serial number where it has one, else by the socket that it sits in. Later ones accept no other.
class Opener {
 public:
  virtual ~Opener() = default;
  // Only one Transport at a time. kNotFound: not plugged in. kPermission: busy or not allowed; says what mends it.
  virtual Result<std::unique_ptr<Transport>> connect() = 0;
  // Without a device: until one may have been plugged in, the deadline has passed, or wake() was called.
  virtual void wait(TimeNs deadline_ns) = 0;
  // Makes the running or else the next read() or wait() return at once. Does not disturb a write().
  virtual void wake() = 0;
  // Names the device that connect() would take at this moment, the same text for the same device however it was asked
  // for; where it is not plugged in, what was asked for. Any thread.
  [[nodiscard]] virtual std::string identity() = 0;
  // Ends what is running, a write() too, and makes every later call fail with kDisconnected. For good.
  virtual void abort() = 0;
};

}  // namespace footlight::drivers
