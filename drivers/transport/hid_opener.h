// HID devices through hidapi's hidraw backend: an Opener whose Transport is a pipe of reports. Why hidapi, and how the
// opener keeps out of reach of a fault of its version 0.13: docs/decisions/0079-hidapi-behind-an-own-check.md.
//
// A report begins with its number: 0 for the devices here, which do not number their reports. control_in() answers
// requests for descriptors from /sys, since hidraw has no control transfers. wait() drops the reports that arrive.
//
// Limit of hidraw: if the device does not take a report, write() lasts until the kernel's timeout of 5 s
// (USB_CTRL_SET_TIMEOUT in drivers/hid/usbhid) or an unplug. Deadlines and abort() act between reports.
//
// hidapi is seen only by hid_opener.cpp. In a build without it, no_hid_opener.cpp takes its place.
#pragma once

#include <memory>
#include <string>

#include "drivers/registry.h"
#include "drivers/transport/transport.h"

namespace footlight::drivers {

struct HidConfig {
  // Required
  std::string driver_id;  // of the devices to open, as in the driver table
  std::string target;     // a serial number, "port-1-2.3", or empty if only one such device is plugged in
  // Optional
  FindOptions find = {};
};

// A device is opened only after its node has been there for this long without a break: a plug's contacts bounce for
// some milliseconds. connect() sleeps meanwhile.
inline constexpr DurationNs kHidSettleNs = 100 * kNsPerMs;

// Does not search for the device yet; connect() does. kUnsupported: built without hidapi, or the system gives no file
// descriptors.
[[nodiscard]] Result<std::unique_ptr<Opener>> make_hid_opener(HidConfig config, Clock& clock);

}  // namespace footlight::drivers
