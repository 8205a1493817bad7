#include "tools/footlight/preview/ui/thumbnails.h"

#include <algorithm>
#include <cstdlib>

#include "sim/core/check.h"

namespace footlight::tools {
namespace {

// The order of parts: 0, 1/2, 1/4, 3/4, 1/8 ... of the log, so that few pictures are already spread over it.
std::size_t part_of(std::size_t number) {
  std::size_t part = 0;
  for (std::size_t bit = 1, back = Thumbnails::kCountMax / 2; back > 0; bit *= 2, back /= 2) {
    if ((number & bit) != 0) part += back;
  }
  return part;
}

}  // namespace

void Thumbnails::add(TimeNs at_ns, std::span<const std::uint8_t> rgba) {
  FL_CHECK_EQ(rgba.size(), std::size_t{4} * kWidth * kHeight);
  Picture picture;
  picture.at_ns = at_ns;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    picture.pixels.push_back(0xff000000u | static_cast<std::uint32_t>(rgba[i + 2]) << 16 |
                             static_cast<std::uint32_t>(rgba[i + 1]) << 8 | rgba[i]);
  }
  for (std::size_t y = 0; y < kHeight; y += 2) {
    for (std::size_t x = 0; x < kWidth; x += 2) {
      std::uint32_t mean = 0xff000000u;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const auto at = [&](std::size_t column, std::size_t row) {
          return std::uint32_t{rgba[4 * (row * kWidth + column) + channel]};
        };
        mean |= (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1) + 2) / 4 << 8 * channel;
      }
      picture.half.push_back(mean);
    }
  }
  const auto place = std::lower_bound(pictures_.begin(), pictures_.end(), at_ns,
                                      [](const Picture& one, TimeNs time_ns) { return one.at_ns < time_ns; });
  if (place != pictures_.end() && place->at_ns == at_ns) {
    *place = std::move(picture);
  } else {
    pictures_.insert(place, std::move(picture));
  }
}

const Thumbnails::Picture* Thumbnails::nearest(TimeNs at_ns, DurationNs reach_ns) const {
  const Picture* found = nullptr;
  DurationNs least_ns = reach_ns;
  for (const Picture& picture : pictures_) {
    const DurationNs away_ns = std::abs(picture.at_ns - at_ns);
    if (away_ns > least_ns) continue;
    least_ns = away_ns;
    found = &picture;
  }
  return found;
}

std::optional<TimeNs> Thumbnails::next(DurationNs duration_ns, TimeNs known_ns) const {
  const DurationNs each_ns = duration_ns / static_cast<DurationNs>(kCountMax);
  for (std::size_t number = 0; number < kCountMax; ++number) {
    const TimeNs at_ns = each_ns * static_cast<DurationNs>(part_of(number));
    if (at_ns > known_ns) continue;
    const bool passed = std::find(passed_.begin(), passed_.end(), at_ns) != passed_.end();
    if (!passed) return at_ns;
  }
  return std::nullopt;
}

}  // namespace footlight::tools
