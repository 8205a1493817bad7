// What a HID device says of its endpoints: how large a report is and how often the host may send one.
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
  int interval_ms = 0;          // bInterval at low and full speed: one report each time; 1 to 255
};

// The first interrupt OUT endpoint in a configuration descriptor (USB 2.0, section 9.6). nullopt where there is none.
// Any bytes may be given.
[[nodiscard]] std::optional<HidEndpoint> find_hid_output(std::span<const std::uint8_t> config_descriptor);
// Asks the device for its configuration descriptor first.
[[nodiscard]] Result<std::optional<HidEndpoint>> ask_hid_output(Transport& transport, TimeNs deadline_ns);

}  // namespace footlight::drivers
