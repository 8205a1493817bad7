// Hashes that identify senders: the same on every machine and after every start. Not for secrets.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace footlight::drivers {

// FNV-1a, 64 bits.
[[nodiscard]] inline std::uint64_t fnv1a64(std::string_view text, std::uint64_t seed = 0xCBF2'9CE4'8422'2325u) {
  std::uint64_t hash = seed;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x0000'0100'0000'01B3u;
  return hash;
}

// The finaliser of SplitMix64: a bijection in which every input bit affects every output bit.
[[nodiscard]] inline std::uint64_t mix64(std::uint64_t x) {
  x += 0x9E37'79B9'7F4A'7C15u;
  x = (x ^ (x >> 30)) * 0xBF58'476D'1CE4'E5B9u;
  x = (x ^ (x >> 27)) * 0x94D0'49BB'1331'11EBu;
  return x ^ (x >> 31);
}

// Never 0, because SenderId 0 means no sender.
[[nodiscard]] inline std::uint64_t sender_hash(std::span<const std::uint8_t> bytes) {
  const std::uint64_t hash =
      mix64(fnv1a64(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())));
  return hash == 0 ? 1 : hash;
}

}  // namespace footlight::drivers
