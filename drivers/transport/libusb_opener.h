// Real USB devices: a Opener on libusb. The Transport has control transfers and endpoints; where the device is one
// of FTDI's chips it is a serial line above those (drivers/transport/ftdi.h).
//
// libusb itself is seen only by libusb_opener.cpp. In a build without it, no_usb_opener.cpp stands in and every
// call answers kUnsupported.
#pragma once

#include <memory>

#include "drivers/device/chooser.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

struct LibusbConfig {
  std::shared_ptr<Chooser> chooser;                   // may be shared with another connector to the same device
  TransportKind unknown_kind = TransportKind::kFtdi;  // of a device that the user named and no row fits
};

// Does not look for the device yet; connect() does. kUnsupported: built without USB, or libusb does not start.
[[nodiscard]] Result<std::unique_ptr<Opener>> make_libusb_opener(LibusbConfig config, Clock& clock);

}  // namespace footlight::drivers
