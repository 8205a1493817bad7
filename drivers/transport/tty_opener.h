// Serial devices through the kernel's tty: those of the USB communication class (/dev/ttyACM0), and FTDI chips where
// libusb is not there or may not open them (/dev/ttyUSB0). 250000 baud by termios2, breaks by ioctl.
//
// A tty is opened only where the driver table or the user has named its USB device: never by its number, which changes
// with every plugging in. It is taken for this program alone (TIOCEXCL).
#pragma once

#include <memory>

#include "drivers/device/chooser.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

// Does not look for the device yet; connect() does. The chooser may be shared with another connector to the same
// device. kUnsupported: the system gives no file descriptors.
[[nodiscard]] Result<std::unique_ptr<Opener>> make_tty_opener(std::shared_ptr<Chooser> chooser, Clock& clock);

}  // namespace footlight::drivers
