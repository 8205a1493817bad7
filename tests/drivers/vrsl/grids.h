// What tests of the grid share.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/vrsl/grid.h"

namespace footlight::drivers {

inline std::vector<GridFormat> all_formats() {
  std::vector<GridFormat> formats;
  for (const auto layout : {GridLayout::kHorizontalBottom, GridLayout::kHorizontalTop, GridLayout::kVerticalLeft,
                            GridLayout::kVerticalRight}) {
    for (const auto planes : {GridPlanes::kLuma, GridPlanes::kRgb}) {
      for (const auto range : {GridRange::kFull, GridRange::kLimited}) {
        for (const auto transfer : {GridTransfer::kLinear, GridTransfer::kFromSrgb, GridTransfer::kToSrgb}) {
          formats.push_back({.layout = layout, .planes = planes, .range = range, .transfer = transfer});
        }
      }
    }
  }
  return formats;
}

// Levels of 9 universes without a pattern; the same for each seed.
inline std::vector<std::uint8_t> random_levels(std::uint64_t seed) {
  std::vector<std::uint8_t> levels(9 * 512);
  std::uint64_t state = seed * 0x9E37'79B9'7F4A'7C15u + 1;
  for (std::uint8_t& level : levels) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    level = static_cast<std::uint8_t>(state >> 32);
  }
  return levels;
}

}  // namespace footlight::drivers
