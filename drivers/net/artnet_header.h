// The octets that every Art-Net packet starts with, after Art-Net 4.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/net/bytes.h"

namespace footlight::drivers::artnet {

inline constexpr std::array<std::uint8_t, 8> kMagic = {'A', 'r', 't', '-', 'N', 'e', 't', 0};
inline constexpr std::uint16_t kVersion = 14;
inline constexpr std::size_t kAtOpCode = 8;    // low octet first
inline constexpr std::size_t kAtVersion = 10;  // high octet first; ArtPollReply has none

[[nodiscard]] inline bool starts_with_magic(std::span<const std::uint8_t> packet) {
  return packet.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), packet.begin());
}

// The magic and the op code, without the version.
inline void write_start(std::span<std::uint8_t> packet, std::uint16_t op_code) {
  std::copy(kMagic.begin(), kMagic.end(), packet.begin());
  write_u16_le(packet, kAtOpCode, op_code);
}
// write_start(), then the version.
inline void write_header(std::span<std::uint8_t> packet, std::uint16_t op_code) {
  write_start(packet, op_code);
  write_u16_be(packet, kAtVersion, kVersion);
}

}  // namespace footlight::drivers::artnet
