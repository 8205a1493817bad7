// The output endpoint in the descriptors of a HID device: the size of a report, and how often the host may send one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/transport/transport.h"

namespace footlight::drivers {

struct HidEndpoint {
  std::uint8_t address = 0;     // bEndpointAddress
  std::size_t report_size = 0;  // bytes; wMaxPacketSize
  int interval_ms = 0;          // bInterval at low and full speed: one report per interval; 1 to 255
};

// The first interrupt OUT endpoint in a configuration descriptor (USB 2.0, section 9.6). nullopt if there is none.
// Accepts any bytes.
[[nodiscard]] std::optional<HidEndpoint> find_hid_output(std::span<const std::uint8_t> config_descriptor);
// Reads the configuration descriptor from the device first.
[[nodiscard]] Result<std::optional<HidEndpoint>> ask_hid_output(Transport& transport, TimeNs deadline_ns);

}  // namespace footlight::drivers
