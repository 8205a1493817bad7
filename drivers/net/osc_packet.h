// Open Sound Control 1.0: packets with messages and bundles.
//
// Strict: a packet with any error in it is rejected as a whole, so no part of a damaged bundle has an effect. Only the
// meaning of a message is the caller's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

namespace footlight::drivers {

enum class OscFault {
  kEmpty,    // no octet
  kSize,     // a length is not a multiple of four, or exceeds its packet
  kAddress,  // does not begin with "/", or is not terminated and padded with zeros
  kTypes,    // no type tags, or an unknown one
  kNesting,  // bundles in bundles beyond kOscNestingMax
};
[[nodiscard]] const char* text_of(OscFault fault);

inline constexpr int kOscNestingMax = 8;
inline constexpr std::size_t kOscNumbersMax = 8;

// Views into the packet.
struct OscMessage {
  std::string_view address;  // "/VRSL/ch12"
  // Its arguments, if all are numbers (i, f, h, d, T, F) and at most kOscNumbersMax; then `all_numbers`.
  std::array<double, kOscNumbersMax> numbers = {};
  std::array<bool, kOscNumbersMax> is_float = {};  // f or d
  std::size_t number_count = 0;
  bool all_numbers = false;
};

// Appends the messages of a packet to `into`, those of bundles in their order. Time tags are not used: contents are for
// now. After an error `into` has its old size.
[[nodiscard]] tl::expected<void, OscFault> parse_osc(std::span<const std::uint8_t> packet,
                                                     std::vector<OscMessage>& into);

// As below, with one 32-bit float.
[[nodiscard]] std::size_t build_osc_float(std::string_view address, float number, std::span<std::uint8_t> out);
// Writes a message with up to kOscNumbersMax 32-bit integers and returns its size; 0: it does not fit.
[[nodiscard]] std::size_t build_osc(std::string_view address, std::span<const std::int32_t> numbers,
                                    std::span<std::uint8_t> out);

}  // namespace footlight::drivers
