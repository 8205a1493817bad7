// Pictures: a grid with damage, or any pixels. The search and the decoder must hold what their headers state.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "drivers/vrsl/grid_find.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight::drivers;
using footlight::kSlotCountMax;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  for (std::uint8_t format = 0; format < 96; format = static_cast<std::uint8_t>(format + 7)) {
    std::vector<std::uint8_t> bytes = {format, 0};
    for (int i = 0; i < 200; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 73 + format));
    seeds.add("whole" + std::to_string(format), bytes);
    bytes[1] = 3;  // with damage
    seeds.add("damaged" + std::to_string(format), bytes);
  }
  seeds.add("pixels", std::vector<std::uint8_t>(300, 0xA5));
}

namespace {

constexpr std::size_t kLevels = std::size_t{9} * kSlotCountMax;

GridFormat format_of(std::uint8_t byte) {
  GridFormat format;
  format.layout = static_cast<GridLayout>(byte % 4);
  format.planes = static_cast<GridPlanes>(byte / 4 % 2);
  format.range = static_cast<GridRange>(byte / 8 % 2);
  format.transfer = static_cast<GridTransfer>(byte / 16 % 3);
  format.flipped = byte / 48 % 2 != 0;
  format.check_row = byte >= 96;
  format.width = 640;
  format.height = 360;
  return format;
}

// Rectangles of one colour: left, top, width, height in 40ths, red, green, blue.
void damage(Picture& picture, const std::uint8_t* data, std::size_t size, int count) {
  for (int i = 0; i < count && size >= 7; ++i, data += 7, size -= 7) {
    const int left = data[0] % 40 * picture.width / 40, top = data[1] % 40 * picture.height / 40;
    const int right = std::min(left + data[2] + 1, picture.width), bottom = std::min(top + data[3] + 1, picture.height);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) std::copy_n(data + 4, 3, picture.at(x, y));
    }
  }
}

void check_reading(const GridReading& reading, int universes) {
  for (int i = 0; i < universes; ++i) {
    const float confidence = reading.confidence[static_cast<std::size_t>(i)];
    require(confidence >= 0 && confidence <= 1);
  }
}

void check_finding(const Picture& picture) {
  const auto found = find_grid(picture.view());
  if (!found) return require(!found.error().message.empty());
  require(found->confidence >= kGridConfidenceMin && found->confidence <= 1);
  const auto codec = GridCodec::make(found->format);
  require(codec.has_value());
  std::vector<std::uint8_t> levels(kLevels);
  GridReading reading;
  require(codec->decode(picture.view(), levels, reading).has_value());
  check_reading(reading, codec->universe_count());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  Picture picture;
  if (data[0] == 0xFF) {  // pixels, enlarged
    picture.clear(640, 360);
    for (int y = 0; y < 360; ++y) {
      for (int x = 0; x < 640; ++x) {
        const std::size_t at = 1 + static_cast<std::size_t>(y / 5 * 128 + x / 5) % (size - 1);
        std::fill_n(picture.at(x, y), 3, data[at]);
      }
    }
    check_finding(picture);
    return 0;
  }
  const auto codec = GridCodec::make(format_of(data[0]));
  require(codec.has_value());
  std::vector<std::uint8_t> sent(kLevels);
  for (std::size_t i = 0; i < kLevels; ++i)
    sent[i] = static_cast<std::uint8_t>(data[2 + i % (size - 2)] + i / 512 * 31);
  codec->encode(sent, picture, data[1]);
  damage(picture, data + 2, size - 2, data[1] % 8);
  std::vector<std::uint8_t> got(kLevels);
  GridReading reading;
  require(codec->decode(picture.view(), got, reading).has_value());
  check_reading(reading, codec->universe_count());
  if (data[1] % 8 == 0) {
    for (int universe = 1; universe <= codec->universe_count(); ++universe) {
      for (int slot = 0; slot < codec->slot_count(universe); ++slot) {
        const auto at = static_cast<std::size_t>((universe - 1) * kSlotCountMax + slot);
        require(got[at] == codec->through(sent[at]));
      }
    }
    require(!codec->format().check_row || (reading.sequence == data[1] && !reading.damaged));
  }
  if (data[1] % 3 == 0) check_finding(picture);
  return 0;
}
