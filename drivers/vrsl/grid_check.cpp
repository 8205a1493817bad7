#include "drivers/vrsl/grid_check.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/vrsl/grid.h"

namespace footlight::drivers {
namespace {

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB8'8320u : 0);
    table[i] = crc;
  }
  return table;
}
constexpr auto kCrcTable = make_crc_table();

struct Block {
  int left = 0, top = 0, right = 0, bottom = 0;  // pixels
};

// Within the picture: a place may reach half a pixel beyond its edge.
Block block_of(const GridFormat& format, const GridPlace& place, int index, int width, int height) {
  double left = place.left;
  double top = place.top;
  if (is_horizontal(format.layout)) {
    left += index * place.cell_width;
    top += format.layout == GridLayout::kHorizontalBottom ? -place.cell_height : kGridColumns * place.cell_height;
  } else {
    left += format.layout == GridLayout::kVerticalLeft ? kGridColumns * place.cell_width : -place.cell_width;
    top += (kGridRowsVertical - 1 - index) * place.cell_height;
  }
  const auto px = [](double at, int size) { return std::clamp(static_cast<int>(std::lround(at)), 0, size); };
  return {px(left, width), px(top, height), px(left + place.cell_width, width), px(top + place.cell_height, height)};
}

}  // namespace

std::uint32_t crc32_of(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  crc = ~crc;
  for (const std::uint8_t byte : bytes) crc = kCrcTable[(crc ^ byte) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

std::uint32_t GridCodec::check_sum(std::span<const std::uint8_t> levels, std::uint16_t sequence) const {
  const std::uint8_t number[] = {static_cast<std::uint8_t>(sequence >> 8), static_cast<std::uint8_t>(sequence)};
  std::uint32_t crc = crc32_of(number);
  for (int universe = 1; universe <= universe_count(); ++universe) {
    Slots slots{};
    const std::size_t first = static_cast<std::size_t>(universe - 1) * kSlotCountMax;
    std::size_t count = 0;
    while (count < slots.size() && carries(universe, static_cast<Address>(count) + 1)) {
      slots[count] = through(first + count < levels.size() ? levels[first + count] : 0);
      ++count;
    }
    crc = crc32_of(std::span(slots).first(count), crc);
  }
  return crc;
}

void GridCodec::draw_check(std::span<const std::uint8_t> levels, Picture& picture, std::uint16_t sequence) const {
  const std::uint64_t bits =
      std::uint64_t{kGridCheckMark} << 48 | std::uint64_t{sequence} << 32 | check_sum(levels, sequence);
  for (int i = 0; i < kGridCheckBlocks; ++i) {
    const Block block = block_of(format_, place_, i, picture.width, picture.height);
    const std::uint8_t code = code_of_[(bits >> (kGridCheckBlocks - 1 - i) & 1) != 0 ? 255 : 0];
    for (int y = block.top; y < block.bottom; ++y) {
      std::fill_n(picture.at(block.left, y), 3 * (block.right - block.left), code);
    }
  }
}

void GridCodec::read_check(const PictureView& picture, std::span<const std::uint8_t> levels,
                           GridReading& reading) const {
  reading.damaged = true;
  const int half = (code_of_[0] + code_of_[255]) / 2;
  std::uint64_t bits = 0;
  for (int i = 0; i < kGridCheckBlocks; ++i) {
    const Block block = block_of(format_, place_, i, picture.width, picture.height);
    const int quarter_x = (block.right - block.left) / 4, quarter_y = (block.bottom - block.top) / 4;
    int sum = 0, count = 0;
    for (int y = block.top + quarter_y; y < block.bottom - quarter_y; ++y) {
      for (int x = block.left + quarter_x; x < block.right - quarter_x; ++x, ++count) sum += picture.at(x, y)[1];
    }
    bits = bits << 1 | (sum > half * count ? 1u : 0u);
  }
  if (bits >> 48 != kGridCheckMark) return;
  const auto sequence = static_cast<std::uint16_t>(bits >> 32);
  reading.sequence = sequence;
  reading.damaged = static_cast<std::uint32_t>(bits) != check_sum(levels, sequence);
}

}  // namespace footlight::drivers
