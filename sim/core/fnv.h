// FNV-1a, 64 bits (Fowler, Noll, Vo): a sum that tells damaged or changed bytes, not forged ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace footlight {

inline constexpr std::uint64_t kFnvStart = 0xcbf29ce484222325u;

// Goes on from the sum of what comes before.
[[nodiscard]] inline std::uint64_t fnv_sum(std::span<const std::byte> bytes, std::uint64_t sum = kFnvStart) {
  for (const std::byte byte : bytes) sum = (sum ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3u;
  return sum;
}
[[nodiscard]] inline std::uint64_t fnv_sum(std::string_view text, std::uint64_t sum = kFnvStart) {
  return fnv_sum(std::as_bytes(std::span(text.data(), text.size())), sum);
}

}  // namespace footlight
