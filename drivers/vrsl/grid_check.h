// The check row: 56 blocks, black or white, in a row beside the grid. It shows which pictures were lost or damaged on
// their way. VRSL does not read these pixels.
//
// Blocks have the size of cells. For a horizontal grid they are the row above it (at the bottom of the picture) or
// below it, from the left. For a vertical grid they are the column beside it, from the bottom. Bits, highest first:
//
//   8    10110010, which is in no even grey or stripe
//   16   a number that grows by one with each picture, and wraps
//   32   CRC-32 (ISO 3309) of the number, high byte first, and of all levels that the grid carries, as
//        GridCodec::through() leaves them
//
// Compression that changes levels changes the CRC as well. So a row is for lossless ways, or for ways of which it is
// known that the levels survive; docs/vrsl_pictures.md has a table.
#pragma once

#include <cstdint>
#include <span>

namespace footlight::drivers {

inline constexpr int kGridCheckBlocks = 56;
inline constexpr std::uint8_t kGridCheckMark = 0b1011'0010;

// CRC-32 as in ISO 3309 (zlib, PNG), continued from `crc`; 0 to begin.
[[nodiscard]] std::uint32_t crc32_of(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

}  // namespace footlight::drivers
