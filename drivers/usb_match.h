// Matches a plugged-in device with a row of the driver table.
#pragma once

#include <cstdint>
#include <string_view>

#include "drivers/driver.h"

namespace footlight::drivers {

struct UsbMatch {
  const DriverInfo* driver = nullptr;  // nullptr: no row matches
  const UsbModelId* model = nullptr;   // the first matching row; points into the driver's table
  bool ids_are_known = false;          // some row has these ids, whatever the strings are
};

// manufacturer, product: the device's strings; may be empty.
[[nodiscard]] UsbMatch match_usb_device(std::uint16_t usb_vendor, std::uint16_t usb_product,
                                        std::string_view manufacturer, std::string_view product);

}  // namespace footlight::drivers
