// Transport: an open device. Opener: opens one device, and opens it again after each unplug.
//
// Each device has one thread. Only that thread calls connect(), wait() and the functions of a Transport other than
// where() and serial(); these calls block until a deadline. Other threads may call wake(), abort() and identity() only.
//
// Deadlines are absolute times of the clock that the implementation was made with.
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
  int latency_ms = 16;  // how long the interface may hold received bytes back to send more at once; 1 to 255
};

// A byte or a break that was received on a serial line.
struct LineByte {
  std::uint8_t value = 0;
  bool is_break = false;       // the line was low for longer than a byte; value has no meaning
  bool framing_error = false;  // value may be wrong
  bool lost_before = false;    // the receiver overran: bytes are missing before this one
  TimeNs stamp_ns = 0;         // when the packet that contained it arrived
};

// Largest size of one IN transfer in bytes: whole packets at full and at high speed.
inline constexpr std::size_t kUsbTransferSizeMax = 512;

// An open device. The destructor releases its interface, and the kernel driver is bound again.
//
// Errors of all calls:
// - kTimeout: the device did not take all bytes in time; the caller cannot tell which ones it took.
// - kDisconnected: unplugged, or abort() was called.
// - kIo: the bus reported an error; open the device again.
// - kUnsupported: this kind of transport has no such call.
class Transport {
 public:
  virtual ~Transport() = default;
  // The device's node at the moment, for messages: "/dev/bus/usb/001/004".
  [[nodiscard]] virtual std::string where() const = 0;
  // The serial number in its USB descriptor; may be empty.
  [[nodiscard]] virtual std::string serial() const = 0;
  // Sleeps until the deadline or wake(). kDisconnected if the device is unplugged meanwhile. For widgets without an
  // input.
  virtual Status wait(TimeNs deadline_ns) = 0;

  // --- A pipe of bytes (a serial port, an FTDI chip) or of reports (HID: one whole report per call, its number first).
  // Writes all bytes.
  virtual Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) = 0;
  // Waits for at least one byte, or for one report. Returns the number of bytes in `into`. 0: the deadline has passed,
  // or wake() was called.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) = 0;

  // --- USB devices with endpoints of their own.
  virtual Status control_out(const ControlRequest& request, std::span<const std::uint8_t> bytes, TimeNs deadline_ns);
  virtual Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                         TimeNs deadline_ns);
  // As write() and read(), for one endpoint. Its descriptor tells bulk from interrupt. A read returns bytes of one
  // transfer only, so packet borders stay known if `into` has kUsbTransferSizeMax bytes. The first read of an endpoint
  // submits its IN transfers.
  virtual Status write_endpoint(std::uint8_t endpoint, std::span<const std::uint8_t> bytes, TimeNs deadline_ns);
  virtual Result<std::size_t> read_endpoint(std::uint8_t endpoint, std::span<std::uint8_t> into, TimeNs deadline_ns);

  [[nodiscard]] virtual std::size_t packet_size(std::uint8_t endpoint) const;

  // --- Serial lines whose timing the host makes.
  virtual Status set_line(const LineSettings& settings, TimeNs deadline_ns);
  virtual Status set_break(bool on, TimeNs deadline_ns);
  // True if the last bit that was written has left the transmitter. Read from the chip, not computed from the time.
  virtual Result<bool> transmitter_empty(TimeNs deadline_ns);
  // As read(), with the breaks between the bytes. Use either this or read(), not both.
  virtual Result<std::size_t> read_line(std::span<LineByte> into, TimeNs deadline_ns);
};

// Opens one device as often as needed. The first connect() that succeeds pins the device: by its serial number if it
// has one, else by its USB socket. Later calls accept no other device.
class Opener {
 public:
  virtual ~Opener() = default;
  // Only one Transport at a time. kNotFound: not plugged in. kPermission: busy or not permitted; the message names the
  // command that fixes it.
  virtual Result<std::unique_ptr<Transport>> connect() = 0;
  // Sleeps while there is no device: until one may have been plugged in, the deadline, or wake().
  virtual void wait(TimeNs deadline_ns) = 0;
  // Makes the current or next read() or wait() return at once. Does not end a write().
  virtual void wake() = 0;
  // Names the device that connect() would open at this moment. The text is the same for one device, whatever the
  // endpoint named it by. If no device is plugged in, the text is made from the endpoint. Any thread.
  [[nodiscard]] virtual std::string identity() = 0;
  // Ends the current call, a write() too, and makes every later call fail with kDisconnected. Cannot be undone.
  virtual void abort() = 0;
};

}  // namespace footlight::drivers
