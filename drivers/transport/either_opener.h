// Two ways to one device: over libusb, or over its tty. Which one is decided at each connect(), by the device that is
// there at that moment.
//
// A device of the USB communication class is reached over its tty alone. An FTDI chip is reached over libusb, or over
// its tty where this build has no libusb or this user may not use it. A chip that was plugged in while the connector
// was in use is left to libusb for kAnnouncementNs: /sys shows it before udev has given its node permissions and
// before libusb has announced it, and a port that took its tty then would keep it.
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
// The device that connect() would take at this moment; nullopt: none.
using LookForDevice = std::function<std::optional<SeenDevice>()>;

// wait() is that of the way which connect() tried last. All three should choose with the same Chooser.
[[nodiscard]] std::unique_ptr<Opener> make_either_opener(std::unique_ptr<Opener> libusb, std::unique_ptr<Opener> tty,
                                                         LookForDevice look, Clock& clock);

}  // namespace footlight::drivers
