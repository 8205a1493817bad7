// USB devices through libusb: an Opener whose Transport has control transfers and endpoints. For an FTDI chip the
// Transport is a serial line on top of those (drivers/transport/ftdi.h).
//
// libusb is seen only by libusb_opener.cpp. In a build without it, no_usb_opener.cpp takes its place.
#pragma once

#include <memory>

#include "drivers/device/chooser.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

struct LibusbConfig {
  std::shared_ptr<Chooser> chooser;                   // may be shared with another opener of the same device
  TransportKind unknown_kind = TransportKind::kFtdi;  // of a device that the user named and that fits no row
};

// Does not search for the device yet; connect() does. kUnsupported: built without libusb, or libusb does not start.
[[nodiscard]] Result<std::unique_ptr<Opener>> make_libusb_opener(LibusbConfig config, Clock& clock);

}  // namespace footlight::drivers
