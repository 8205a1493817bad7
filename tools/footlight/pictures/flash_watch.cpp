#include "tools/footlight/pictures/flash_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "fixtures/model/srgb.h"

namespace footlight::tools {
namespace {

constexpr int kColumns = 16;
constexpr int kRows = 9;
constexpr double kWhiteCdM2 = 200;

// Linear light of each sRGB byte.
const std::array<double, 256>& linear_bytes() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (int i = 0; i < 256; ++i) values[static_cast<std::size_t>(i)] = fixtures::linear_of_srgb(i / 255.0);
    return values;
  }();
  return table;
}

std::uint8_t srgb_byte(double light) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(fixtures::srgb_of_linear(light) * 255), 0L, 255L));
}

std::vector<TileLight> tiles_of(const render::ScreenImage& picture) {
  std::vector<TileLight> tiles(std::size_t{kColumns} * kRows);
  std::vector<int> counts(tiles.size());
  const auto& linear = linear_bytes();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
      const auto at = static_cast<std::size_t>(y * kRows / picture.height * kColumns + x * kColumns / picture.width);
      tiles[at].red += linear[picture.rgba[4 * pixel]];
      tiles[at].green += linear[picture.rgba[4 * pixel + 1]];
      tiles[at].blue += linear[picture.rgba[4 * pixel + 2]];
      ++counts[at];
    }
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    TileLight& tile = tiles[i];
    const double count = std::max(counts[i], 1);
    tile.red /= count;
    tile.green /= count;
    tile.blue /= count;
    // Luminance of Rec. 709 primaries.
    tile.luminance_cd_m2 = kWhiteCdM2 * (0.2126 * tile.red + 0.7152 * tile.green + 0.0722 * tile.blue);
  }
  return tiles;
}

std::vector<double> equal_areas() {
  return std::vector<double>(std::size_t{kColumns} * kRows, 1.0 / (kColumns * kRows));
}

}  // namespace

FlashWatch::FlashWatch(bool limit) : limit_(limit), guard_({}, equal_areas()), input_({}, equal_areas()) {}

bool FlashWatch::note(DurationNs at_ns, const render::ScreenImage& picture) {
  tiles_ = tiles_of(picture);
  const FlashVerdict input = input_.measure(at_ns, tiles_);
  const bool begins = input.harmful && !harmful_;
  harmful_ = input.harmful;
  if (begins) stretches_.push_back({.from_ns = at_ns});
  if (harmful_) {
    FlashStretch& stretch = stretches_.back();
    stretch.until_ns = at_ns;
    stretch.flashes = std::max({stretch.flashes, input.flashes, input.red_flashes});
    stretch.area = std::max({stretch.area, input.area, input.red_area});
    stretch.red = stretch.red || input.red_area > input.area;
  }
  return begins;
}

bool FlashWatch::must_wait(DurationNs at_ns, const render::ScreenImage& picture) {
  note(at_ns, picture);
  PhotosensitiveGuard trial = guard_;
  if (trial.limit(at_ns, tiles_, gains_).least_gain < 1) {
    guard_.measure(at_ns, shown_);
    least_gain_ = 0;
    return true;
  }
  guard_ = std::move(trial);
  shown_ = tiles_;
  return false;
}

void FlashWatch::hold_from_here() {
  guard_ = input_;
  shown_ = tiles_;
}

bool FlashWatch::check(DurationNs at_ns, render::ScreenImage& picture) {
  const bool begins = note(at_ns, picture);
  if (limit_) {
    const FlashVerdict shown = guard_.limit(at_ns, tiles_, gains_);
    least_gain_ = std::min(least_gain_, shown.least_gain);
    if (shown.least_gain < 1) darken(picture);
  }
  return begins;
}

void FlashWatch::darken(render::ScreenImage& picture) const {
  const auto gain_at = [&](int column, int row) {
    return gains_[static_cast<std::size_t>(std::clamp(row, 0, kRows - 1) * kColumns +
                                           std::clamp(column, 0, kColumns - 1))];
  };
  const auto& linear = linear_bytes();
  for (int y = 0; y < picture.height; ++y) {
    const double v = (y + 0.5) * kRows / picture.height - 0.5;
    const int row = static_cast<int>(std::floor(v));
    for (int x = 0; x < picture.width; ++x) {
      const double u = (x + 0.5) * kColumns / picture.width - 0.5;
      const int column = static_cast<int>(std::floor(u));
      const double a = std::lerp(gain_at(column, row), gain_at(column + 1, row), u - column);
      const double b = std::lerp(gain_at(column, row + 1), gain_at(column + 1, row + 1), u - column);
      const double gain = std::lerp(a, b, v - row);
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        std::uint8_t& byte = picture.rgba[4 * pixel + channel];
        byte = srgb_byte(linear[byte] * gain);
      }
    }
  }
}

}  // namespace footlight::tools
