// The driver that a stock kernel binds to the first interface of a device, as observed with Debian's 6.1.
//
// Sources: id_table_combined in drivers/usb/serial/ftdi_sio.c; vmk80xx_usb_id_table in
// drivers/comedi/drivers/vmk80xx.c; hid_ignore_list in drivers/hid/hid-quirks.c, which has the same Velleman ids, so
// that usbhid never makes a hidraw node for them.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/mock/usb_model.h"

namespace footlight::testing {

// "ftdi_sio", "vmk80xx", "usbhid", "cdc_acm"; empty: none.
inline std::string stock_driver_of(const drivers::mock::UsbModel& model) {
  constexpr std::uint8_t kInterfaceDescriptor = 4, kCommunication = 2, kHid = 3;
  const drivers::mock::Bytes device = model.device_descriptor(), config = model.config_descriptor();
  const int vendor = device[8] | device[9] << 8, product = device[10] | device[11] << 8;
  if (vendor == 0x0403) return "ftdi_sio";
  if (vendor == 0x10CF && product >= 0x8061 && product <= 0x8068) return "vmk80xx";
  for (std::size_t at = 0; at + 5 < config.size() && config[at] > 0; at += config[at]) {
    if (config[at + 1] != kInterfaceDescriptor) continue;
    return config[at + 5] == kHid ? "usbhid" : config[at + 5] == kCommunication ? "cdc_acm" : "";
  }
  return {};
}

}  // namespace footlight::testing
