// Real USB devices: a Connector on libusb. The Transport has control transfers and endpoints; where the device is one
// of FTDI's chips it is a serial line above those (drivers/usb/ftdi.h).
//
// libusb itself is seen only by libusb_connector.cpp. In a build without it, no_usb_connector.cpp stands in and every
// call answers kUnsupported.
#pragma once

#include <memory>
#include <string>

#include "drivers/device/transport.h"
#include "drivers/registry.h"

namespace footlight::drivers {

struct LibusbConfig {
  // Required
  std::string driver_id;  // of the devices to take, as in the driver table
  std::string target;     // a serial number, "port-1-2.3", or empty where only one such device is plugged in
  // Optional
  TransportKind unknown_kind = TransportKind::kFtdi;  // of a device that the user named and no row fits
  FindOptions find = {};
};

// Does not look for the device yet; connect() does. kUnsupported: built without USB, or libusb does not start.
[[nodiscard]] Result<std::unique_ptr<Connector>> make_libusb_connector(LibusbConfig config, Clock& clock);

}  // namespace footlight::drivers
