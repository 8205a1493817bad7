// Opens one device through libusb or through its tty. Each connect() chooses, by the device that is plugged in then.
//
// A device of the USB communication class is opened through its tty only. An FTDI chip is opened through libusb, or
// through its tty if this build has no libusb or this user may not open the USB node.
//
// A chip that was plugged in after the first connect() is tried through libusb only, for kAnnouncementNs. /sys lists it
// before udev sets the permissions of its node and before libusb reports it. A port that opened the tty in that time
// would keep it until the next replug (docs/decisions/0090-libusb-before-the-tty.md).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "drivers/driver.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

inline constexpr DurationNs kAnnouncementNs = kNsPerS;

struct SeenDevice {
  TransportKind kind = TransportKind::kFtdi;
  std::string node;  // "/dev/bus/usb/001/004"; another one after a replug
};
// The device that connect() would open at this moment; nullopt: none.
using LookForDevice = std::function<std::optional<SeenDevice>()>;

// wait() calls that of the opener which connect() tried last. Give the same Chooser to both openers and to `look`.
[[nodiscard]] std::unique_ptr<Opener> make_either_opener(std::unique_ptr<Opener> libusb, std::unique_ptr<Opener> tty,
                                                         LookForDevice look, Clock& clock);

}  // namespace footlight::drivers
