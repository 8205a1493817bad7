#include "sim/photosensitive.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace footlight {

namespace {

constexpr std::int64_t kNeverNs = std::numeric_limits<std::int64_t>::min();
constexpr double kNoDark = std::numeric_limits<double>::infinity();
constexpr double kRedScale = 320;
constexpr double kJustBelow = 1 - 1e-6;  // just too small to count as a change

double light_or_dark(double value) { return value > 0 && value < 1e12 ? value : 0; }

std::int64_t window_begin(std::int64_t now_ns, std::int64_t window_ns) {
  return now_ns < kNeverNs + window_ns ? kNeverNs : now_ns - window_ns;
}

}  // namespace

int PhotosensitiveGuard::Swing::changes_since(std::int64_t from_ns) const {
  int changes = 0;
  for (std::size_t i = 0; i < count; ++i) changes += changes_ns[i] > from_ns ? 1 : 0;
  return changes;
}

bool PhotosensitiveGuard::Swing::rises(double value, double change, double dark) const {
  return seen && last != 1 && low < dark && value - low >= change;
}

void PhotosensitiveGuard::Swing::take(std::int64_t now_ns, double value, double change, double dark) {
  if (!seen) {
    seen = true;
    low = high = value;
    return;
  }
  const bool up = rises(value, change, dark);
  const bool down = !up && last != -1 && value < dark && high - value >= change;
  if (up || down) {
    changes_ns[next] = now_ns;
    next = (next + 1) % kChangesMost;
    count = std::min(count + 1, kChangesMost);
    last = up ? 1 : -1;
    low = high = value;
  } else {
    low = std::min(low, value);
    high = std::max(high, value);
  }
}

PhotosensitiveGuard::PhotosensitiveGuard(const FlashLimits& limits, std::vector<double> areas)
    : limits_(limits),
      tiles_(std::max<std::size_t>(areas.size(), 1)),
      last_ns_(kNeverNs),
      flashing_since_ns_(kNeverNs) {
  limits_.flashes = std::clamp(limits_.flashes, 1, static_cast<int>(kChangesMost / 2) - 1);
  for (std::size_t i = 0; i < areas.size(); ++i) tiles_[i].area = light_or_dark(areas[i]);
}

double PhotosensitiveGuard::red_value(const TileLight& light) const {
  const double red = light_or_dark(light.red), green = light_or_dark(light.green), blue = light_or_dark(light.blue);
  if (!(red > 0) || red < limits_.red_share * (red + green + blue)) return 0;
  return std::max((red - green - blue) * kRedScale, 0.0);
}

void PhotosensitiveGuard::restart_if_back(std::int64_t now_ns) {
  if (now_ns < last_ns_) {
    for (Tile& tile : tiles_) {
      tile.luminance = Swing();
      tile.red = Swing();
    }
    flashing_since_ns_ = kNeverNs;
  }
  last_ns_ = now_ns;
}

FlashVerdict PhotosensitiveGuard::verdict(std::int64_t now_ns) {
  const std::int64_t from_ns = window_begin(now_ns, limits_.window_ns);
  FlashVerdict verdict;
  double any_area = 0;
  for (const Tile& tile : tiles_) {
    const int changes = tile.luminance.changes_since(from_ns);
    const int red_changes = tile.red.changes_since(from_ns);
    verdict.flashes = std::max(verdict.flashes, changes / 2.0);
    verdict.red_flashes = std::max(verdict.red_flashes, red_changes / 2.0);
    if (changes > 2 * limits_.flashes) verdict.area += tile.area;
    if (red_changes > 2 * limits_.flashes) verdict.red_area += tile.area;
    if (std::max(changes, red_changes) >= 2) any_area += tile.area;
  }
  verdict.harmful = verdict.area > limits_.area || verdict.red_area > limits_.area;
  if (!(any_area > limits_.area)) {
    flashing_since_ns_ = kNeverNs;
  } else if (flashing_since_ns_ == kNeverNs) {
    flashing_since_ns_ = now_ns;
  }
  verdict.long_sequence = flashing_since_ns_ != kNeverNs && flashing_since_ns_ < window_begin(now_ns, limits_.long_ns);
  return verdict;
}

FlashVerdict PhotosensitiveGuard::measure(std::int64_t now_ns, std::span<const TileLight> tiles) {
  restart_if_back(now_ns);
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const TileLight light = i < tiles.size() ? tiles[i] : TileLight();
    tiles_[i].luminance.take(now_ns, light_or_dark(light.luminance_cd_m2), limits_.change_cd_m2, limits_.dark_cd_m2);
    tiles_[i].red.take(now_ns, red_value(light), limits_.red_change, kNoDark);
  }
  return verdict(now_ns);
}

FlashVerdict PhotosensitiveGuard::limit(std::int64_t now_ns, std::span<const TileLight> tiles,
                                        std::vector<double>& gains) {
  restart_if_back(now_ns);
  gains.assign(tiles_.size(), 1.0);
  const std::int64_t from_ns = window_begin(now_ns, limits_.window_ns);
  // A tile at risk has used all but one of its flashes and rises again, or is at its limit. Tiles at risk may go on
  // while their total area is small.
  const auto at_risk = [&](const Swing& swing, double value, double change, double dark) {
    const int changes = swing.changes_since(from_ns);
    return changes >= 2 * limits_.flashes || (changes >= 2 * limits_.flashes - 1 && swing.rises(value, change, dark));
  };
  const auto held = [&](const Swing& swing, double value, double change, double dark) {
    return swing.rises(value, change, dark) && at_risk(swing, value, change, dark)
               ? (swing.low + change * kJustBelow) / value
               : 1.0;
  };
  double area = 0, red_area = 0;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const TileLight light = i < tiles.size() ? tiles[i] : TileLight();
    const double luminance = light_or_dark(light.luminance_cd_m2);
    if (at_risk(tiles_[i].luminance, luminance, limits_.change_cd_m2, limits_.dark_cd_m2)) area += tiles_[i].area;
    if (at_risk(tiles_[i].red, red_value(light), limits_.red_change, kNoDark)) red_area += tiles_[i].area;
  }
  double held_area = 0, least = 1;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    Tile& tile = tiles_[i];
    const TileLight light = i < tiles.size() ? tiles[i] : TileLight();
    const double luminance = light_or_dark(light.luminance_cd_m2);
    const double red = red_value(light);
    double gain = 1;
    if (area > limits_.area) gain = held(tile.luminance, luminance, limits_.change_cd_m2, limits_.dark_cd_m2);
    if (red_area > limits_.area) gain = std::min(gain, held(tile.red, red, limits_.red_change, kNoDark));
    gains[i] = gain;
    if (gain < 1) held_area += tile.area;
    least = std::min(least, gain);
    tile.luminance.take(now_ns, luminance * gain, limits_.change_cd_m2, limits_.dark_cd_m2);
    tile.red.take(now_ns, red * gain, limits_.red_change, kNoDark);
  }
  FlashVerdict result = verdict(now_ns);
  result.held_area = held_area;
  result.least_gain = least;
  return result;
}

}  // namespace footlight
