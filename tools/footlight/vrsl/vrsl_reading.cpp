#include "tools/footlight/vrsl/vrsl_reading.h"

#include <algorithm>
#include <cmath>

#include "drivers/vrsl/grid_cells.h"
#include "fixtures/simulate/vrsl_compat.h"

namespace footlight::tools {
namespace {

using drivers::GridCodec;
using drivers::GridPlanes;
using drivers::PictureView;

constexpr int kGuardChannel =
    516;  // of each universe: INT shader's (0.658904, 0.32868), (..., 0.662112), (..., 0.996333)
constexpr double kGuardValue = 0.025;
constexpr double kSample = 0.75;  // of a cell

fixtures::VrslDecode decode_of(const drivers::GridFormat& format, bool exact_division) {
  fixtures::VrslDecode decode;
  decode.grid = is_horizontal(format.layout) ? fixtures::VrslGrid::kHorizontal : fixtures::VrslGrid::kVertical;
  decode.nine_universes = format.planes == GridPlanes::kRgb;
  decode.exact_division = exact_division;
  return decode;
}

// The pixel that VRSL reads for a cell of the table; nullptr outside the picture.
const std::uint8_t* pixel_of(const GridCodec& codec, const PictureView& picture, int column, int row) {
  const drivers::GridFormat& format = codec.format();
  const drivers::GridPlace& place = codec.place();
  const bool horizontal = is_horizontal(format.layout);
  const int across = horizontal ? row : column;
  const int rows_down = drivers::grid_cells_down(format.layout);
  const int from_first = horizontal ? column : row;  // of the direction that a flip turns
  const bool from_top = horizontal != format.flipped;
  const double down = from_top ? from_first + kSample : rows_down - from_first - kSample;
  const int x = static_cast<int>(std::floor(place.left + (across + kSample) * place.cell_width));
  const int y = static_cast<int>(std::floor(place.top + down * place.cell_height));
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return nullptr;
  return picture.at(x, y);
}

}  // namespace

std::vector<ChannelRange> vrsl_unread(const drivers::GridFormat& format, bool exact_division) {
  std::vector<ChannelRange> ranges;
  const auto codec = GridCodec::make(format);
  if (!codec) return ranges;
  const fixtures::VrslDecode decode = decode_of(format, exact_division);
  for (int universe = 1; universe <= codec->universe_count(); ++universe) {
    for (Address channel = 1; channel <= codec->slot_count(universe); ++channel) {
      if (fixtures::vrsl_reads(universe, channel, decode)) continue;
      const bool follows = !ranges.empty() && ranges.back().universe == universe && ranges.back().last == channel - 1;
      if (follows) {
        ranges.back().last = channel;
      } else {
        ranges.push_back({universe, channel, channel});
      }
    }
  }
  return ranges;
}

int count_of(const std::vector<ChannelRange>& ranges) {
  int count = 0;
  for (const ChannelRange& range : ranges) count += range.last - range.first + 1;
  return count;
}

VrslSeen seen_by_vrsl(const GridCodec& codec, const PictureView& picture, bool exact_division) {
  VrslSeen seen;
  const bool nine = codec.format().planes == GridPlanes::kRgb;
  const fixtures::VrslDecode decode = decode_of(codec.format(), exact_division);
  const auto pixel_at = [&](int universe, int channel) {
    const fixtures::VrslCell cell = fixtures::vrsl_cell(universe, channel, nine);
    return pixel_of(codec, picture, cell.column, cell.row);
  };
  for (int universe = 1; universe <= codec.universe_count(); ++universe) {
    const int plane = (universe - 1) / 3;
    for (Address channel = 1; channel <= codec.slot_count(universe); ++channel) {
      const auto read = fixtures::vrsl_reads(universe, channel, decode);
      const std::uint8_t* const pixel = read ? pixel_at(read->universe, read->channel) : nullptr;
      if (pixel == nullptr) continue;
      float value = 0;
      if (nine) {
        value = static_cast<float>(pixel[plane]) / 255.0f;
      } else {
        for (std::size_t c = 0; c < 3; ++c) {
          value += static_cast<float>(drivers::kVrslLuma[c]) * static_cast<float>(pixel[c]) / 255.0f;
        }
      }
      seen.values[static_cast<std::size_t>((universe - 1) * kSlotCountMax + channel - 1)] = value;
    }
  }
  for (int universe = 1; universe <= (is_horizontal(codec.format().layout) ? 3 : 1); ++universe) {
    const std::uint8_t* const pixel = pixel_at(universe, kGuardChannel);
    if (pixel != nullptr && *std::min_element(pixel, pixel + 3) / 255.0 >= kGuardValue) seen.guard_tripped = true;
  }
  return seen;
}

}  // namespace footlight::tools
