// Reads and writes numbers and text in packets. `at` counts octets from the start; the caller has checked the size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace footlight::drivers {

[[nodiscard]] inline std::uint16_t read_u16_be(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}
[[nodiscard]] inline std::uint16_t read_u16_le(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}
[[nodiscard]] inline std::uint32_t read_u32_be(std::span<const std::uint8_t> bytes, std::size_t at) {
  return std::uint32_t{read_u16_be(bytes, at)} << 16 | read_u16_be(bytes, at + 2);
}
inline void write_u16_be(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value >> 8);
  bytes[at + 1] = static_cast<std::uint8_t>(value & 0xFF);
}
inline void write_u16_le(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value & 0xFF);
  bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
}
inline void write_u32_be(std::span<std::uint8_t> bytes, std::size_t at, std::uint32_t value) {
  write_u16_be(bytes, at, static_cast<std::uint16_t>(value >> 16));
  write_u16_be(bytes, at + 2, static_cast<std::uint16_t>(value & 0xFFFF));
}

// The longest prefix of `text` of whole UTF-8 characters and at most `bytes_max` bytes.
[[nodiscard]] inline std::string_view cut_utf8(std::string_view text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  std::size_t size = bytes_max;
  // Octets 10xxxxxx continue a character: step back to the start of the character that does not fit.
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0u) == 0x80u) --size;
  return text.substr(0, size);
}

}  // namespace footlight::drivers
