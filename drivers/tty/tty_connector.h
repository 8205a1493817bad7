// Serial devices through the kernel's tty: those of the USB communication class (/dev/ttyACM0), and FTDI chips where
// libusb is not there or may not open them (/dev/ttyUSB0). 250000 baud by termios2, breaks by ioctl.
//
// A tty is opened only where the driver table or the user has named its USB device: never by its number, which changes
// with every plugging in. It is taken for this program alone (TIOCEXCL).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/device/chooser.h"
#include "drivers/device/transport.h"

namespace footlight::drivers {

// Does not look for the device yet; connect() does. The chooser may be shared with another connector to the same
// device. kUnsupported: the system gives no file descriptors.
[[nodiscard]] Result<std::unique_ptr<Connector>> make_tty_connector(std::shared_ptr<Chooser> chooser, Clock& clock);

// A tty by its path, without a device behind it to look for: for tests on a pseudo-terminal.
[[nodiscard]] Result<std::unique_ptr<Transport>> open_tty(const std::string& path, Clock& clock);

// What a tty in PARMRK mode says of a line: FF 00 00 is a break, FF 00 x a byte with a framing error, FF FF a byte FF
// (termios(3)). Bytes may be cut anywhere.
class TtyMarkParser {
 public:
  // Appends to `into`.
  void take(std::span<const std::uint8_t> bytes, TimeNs stamp_ns, std::vector<LineByte>& into);
  void reset() { state_ = State::kPlain; }

 private:
  enum class State { kPlain, kMark, kError };
  State state_ = State::kPlain;
};

}  // namespace footlight::drivers
