// HID devices on the kernel's hidraw: a Opener whose Transport is a pipe of reports. Why not hidapi:
// docs/decisions/0021-hidraw-without-a-library.md.
//
// Reports begin with their number, 0 for the devices here, which do not number theirs. control_in() answers the one
// question for a descriptor, from what the kernel has read (/sys), since hidraw has no control transfers. wait() drops
// the reports that come meanwhile.
//
// What hidraw cannot do: a write() that the device does not take is given up by the kernel after 5 s and by nobody
// before (USB_CTRL_SET_TIMEOUT in drivers/hid/usbhid); deadlines and abort() act between reports. An unplug ends it.
#pragma once

#include <memory>
#include <string>

#include "drivers/registry.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

struct HidrawConfig {
  // Required
  std::string driver_id;  // of the devices to take, as in the driver table
  std::string target;     // a serial number, "port-1-2.3", or empty where only one such device is plugged in
  // Optional
  FindOptions find = {};
};

// Does not look for the device yet; connect() does.
[[nodiscard]] std::unique_ptr<Opener> make_hidraw_opener(HidrawConfig config, Clock& clock);

}  // namespace footlight::drivers
