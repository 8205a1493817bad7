// What VRSL itself reads from a picture, with its faults (docs/vrsl.md): for 'footlight vrsl check', and to know what
// viewers in a world get from a stream.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/vrsl/grid.h"

namespace footlight::tools {

// Channels that follow one another.
struct ChannelRange {
  int universe = 0;
  Address first = 0;
  Address last = 0;
  bool operator==(const ChannelRange&) const = default;
};

// Addresses that the layout carries and VRSL's shader does not find: 120 of nine universes.
[[nodiscard]] std::vector<ChannelRange> vrsl_unread(const drivers::GridFormat& format, bool exact_division = false);
[[nodiscard]] int count_of(const std::vector<ChannelRange>& ranges);

struct VrslSeen {
  // 0 to 1 for each address of nine universes; 0 where VRSL finds nothing. With three universes the luminance, with
  // nine the colour of its universe.
  std::array<float, std::size_t{9} * 512> values{};
  // Padding that is not black: with signal detection on, VRSL shows nothing of such a picture.
  bool guard_tripped = false;
};

// One pixel of each cell, at three quarters of its width and height as the table has them, as VRSL's passes read them
// (two pixels a cell, the upper right one). The grid is where codec.place() has it; range and transfer are ignored,
// since VRSL's shader knows neither. exact_division: as VrslDecode::exact_division.
[[nodiscard]] VrslSeen seen_by_vrsl(const drivers::GridCodec& codec, const drivers::PictureView& picture,
                                    bool exact_division = false);

}  // namespace footlight::tools
