// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected, as RFC 3720 appendix B.4 tests it).
#pragma once

#include <cstdint>
#include <span>

namespace footlight::dmx_log {

[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

}  // namespace footlight::dmx_log
