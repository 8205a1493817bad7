// A pipe of bytes to a device, and the means to get back to it after an unplug.
//
// A driver has one thread. It alone calls connect(), read(), write() and wait(); they block, up to a deadline. Any
// other thread may call wake() and abort(), and nothing else. Implementations: drivers/usb/libusb_connector.h (real
// devices) and drivers/mock/mock_usb.h (device models in this process).
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

// An open device. Destroying it gives the device back: its interface is released and the kernel driver bound again.
class Transport {
 public:
  virtual ~Transport() = default;
  // Writes all of it. kTimeout: the device did not take everything in time; what it took is lost to the caller.
  // kDisconnected: unplugged, or abort() was called. kIo: the bus reported an error; open the device afresh.
  virtual Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) = 0;
  // Waits for at least one byte; returns how many were put into `into`. 0: the deadline has passed or wake() was
  // called.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) = 0;
  // What the device is called at the moment, for messages: "/dev/bus/usb/001/004".
  [[nodiscard]] virtual std::string where() const = 0;
  // The serial number in its USB descriptor; may be empty.
  [[nodiscard]] virtual std::string serial() const = 0;
};

// Knows which device is meant and opens it as often as needed. The first connect() that succeeds pins the device: by
// its serial number where it has one, else by the socket that it sits in. Later ones accept no other.
class Connector {
 public:
  virtual ~Connector() = default;
  // Only one Transport at a time. kNotFound: not plugged in. kPermission: busy or not allowed; says what mends it.
  virtual Result<std::unique_ptr<Transport>> connect() = 0;
  // Without a device: until one may have been plugged in, the deadline has passed, or wake() was called.
  virtual void wait(TimeNs deadline_ns) = 0;
  // Makes the running or else the next read() or wait() return at once. Does not disturb a write().
  virtual void wake() = 0;
  // Ends what is running, a write() too, and makes every later call fail with kDisconnected. For good.
  virtual void abort() = 0;
};

}  // namespace footlight::drivers
