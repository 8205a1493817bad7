// Serial devices through the kernel's tty: those of the USB communication class (/dev/ttyACM0), and FTDI chips if
// libusb is missing or may not open them (/dev/ttyUSB0). termios2 sets 250000 baud, an ioctl makes breaks.
//
// A tty is opened only if the driver table or the user names its USB device, never by its number, which may change with
// each replug. No other program can open it meanwhile (TIOCEXCL).
#pragma once

#include <memory>

#include "drivers/device/chooser.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

// Does not search for the device yet; connect() does. The chooser may be shared with another opener of the same device.
// kUnsupported: the system gives no file descriptors.
[[nodiscard]] Result<std::unique_ptr<Opener>> make_tty_opener(std::shared_ptr<Chooser> chooser, Clock& clock);

}  // namespace footlight::drivers
