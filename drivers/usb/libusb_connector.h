// Real USB devices: a Connector on libusb, with the FTDI chip's framing taken off.
//
// libusb itself is seen only by libusb_connector.cpp. In a build without it, no_usb_connector.cpp stands in and every
// call answers kUnsupported.
#pragma once

#include <memory>
#include <string>

#include "drivers/registry.h"
#include "drivers/device/transport.h"

namespace footlight::drivers {

struct LibusbConfig {
  // Required
  std::string driver_id;  // of the devices to take, as in the driver table
  std::string target;     // a serial number, "port-1-2.3", or empty where only one such device is plugged in
  // Optional
  int latency_ms = 16;  // of the chip's latency timer: how long a packet that is not full waits inside it; 1 to 255
  FindOptions find = {};
};

// Does not look for the device yet; connect() does. kUnsupported: built without USB, or libusb does not start.
[[nodiscard]] Result<std::unique_ptr<Connector>> make_libusb_connector(LibusbConfig config, Clock& clock);

}  // namespace footlight::drivers
