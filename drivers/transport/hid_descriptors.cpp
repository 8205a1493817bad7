#include "drivers/transport/hid_descriptors.h"

#include <array>

namespace footlight::drivers {

std::optional<HidEndpoint> find_hid_output(std::span<const std::uint8_t> config_descriptor) {
  constexpr std::uint8_t kEndpoint = 5, kDirectionIn = 0x80, kTypeMask = 3, kInterrupt = 3;
  constexpr std::size_t kEndpointSize = 7, kHeadSize = 2;
  for (auto rest = config_descriptor; rest.size() >= kHeadSize;) {
    const std::size_t size = rest[0];
    if (size < kHeadSize || size > rest.size()) break;
    if (rest[1] == kEndpoint && size >= kEndpointSize && (rest[2] & kDirectionIn) == 0 &&
        (rest[3] & kTypeMask) == kInterrupt) {
      const HidEndpoint found{.address = rest[2],
                              .report_size = static_cast<std::size_t>(rest[4] | (rest[5] & 0x07) << 8),
                              .interval_ms = rest[6]};
      if (found.report_size > 0 && found.interval_ms > 0) return found;
    }
    rest = rest.subspan(size);
  }
  return std::nullopt;
}

Result<std::optional<HidEndpoint>> ask_hid_output(Transport& transport, TimeNs deadline_ns) {
  constexpr ControlRequest kGetConfigDescriptor{.request_type = 0x80, .request = 6, .value = 0x0200};
  std::array<std::uint8_t, 512> descriptor{};
  FL_ASSIGN(const std::size_t size, transport.control_in(kGetConfigDescriptor, descriptor, deadline_ns));
  return find_hid_output(std::span<const std::uint8_t>(descriptor).first(size));
}

}  // namespace footlight::drivers
