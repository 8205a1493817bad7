#include "tools/footlight/preview/ui/transport.h"

#include <algorithm>
#include <numeric>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace footlight::tools {

TimeNs Transport::next_ns(DurationNs dt_ns) const {
  const TimeNs next = now_ns + static_cast<DurationNs>(std::llround(static_cast<double>(dt_ns) * speed));
  const TimeNs start = from_ns.value_or(0);
  const TimeNs end = to_ns && now_ns <= *to_ns ? *to_ns : duration_ns;
  if (next <= end) return next;
  if (!repeats && !from_ns && !to_ns) return duration_ns;
  return end > start ? start + (next - start) % (end - start) : start;
}

void Transport::repeat_from(TimeNs time_ns) {
  if (time_ns > duration_ns - kRepeatMinNs) return;
  from_ns = time_ns;
  if (to_ns && *to_ns < time_ns + kRepeatMinNs) to_ns.reset();
}

void Transport::repeat_to(TimeNs time_ns) {
  if (time_ns < kRepeatMinNs) return;
  to_ns = time_ns;
  if (from_ns && *from_ns > time_ns - kRepeatMinNs) from_ns.reset();
}

void Transport::change_speed(int by) {
  const auto at = std::lower_bound(std::begin(kSpeeds), std::end(kSpeeds), speed) - std::begin(kSpeeds);
  speed = kSpeeds[std::clamp<std::ptrdiff_t>(at + by, 0, std::ssize(kSpeeds) - 1)];
}

void Transport::seek_by(DurationNs by_ns) {
  seek_ns = std::clamp<TimeNs>(seek_ns.value_or(now_ns) + by_ns, 0, duration_ns);
}

std::string time_text(TimeNs time_ns) {
  const std::int64_t tenths = time_ns / (100 * kNsPerMs);
  const std::int64_t minutes = tenths / 600;
  const std::string rest = fmt::format("{:02}.{}", tenths / 10 % 60, tenths % 10);
  return minutes < 60 ? fmt::format("{}:{}", minutes, rest)
                      : fmt::format("{}:{:02}:{}", minutes / 60, minutes % 60, rest);
}

LightCurve::LightCurve(const fixtures::Rig& rig, const RigIndex& index, std::span<const int> which) {
  const auto count = static_cast<int>(rig.fixtures.size());
  std::vector<int> fixtures(which.begin(), which.end());
  if (fixtures.empty()) {
    fixtures.resize(rig.fixtures.size());
    std::iota(fixtures.begin(), fixtures.end(), 0);
  }
  std::vector<std::uint32_t> all;
  for (const int fixture : fixtures) {
    if (fixture < 0 || fixture >= count) continue;
    for (std::size_t c = 0; c < index.channel_count(fixture); ++c) {
      const ChannelKey key{fixture, static_cast<int>(c)};
      const auto place = index.place(key);
      if (!place) continue;
      all.push_back(place->slots[0]);
      const auto& functions = index.channel(key).functions;
      const bool dims = std::any_of(functions.begin(), functions.end(),
                                    [](const auto& function) { return function.attribute == "Dimmer"; });
      if (dims) slots_.push_back(place->slots[0]);
    }
  }
  if (slots_.empty()) slots_ = std::move(all);
}

void LightCurve::add(TimeNs at_ns, std::span<const std::uint8_t> levels) {
  if (!points_.empty() && at_ns <= points_.back().at_ns) return;
  double sum = 0;
  for (const std::uint32_t slot : slots_) sum += levels[slot];
  const double light = slots_.empty() ? 0 : sum / 255 / static_cast<double>(slots_.size());
  points_.push_back({at_ns, static_cast<float>(light)});
}

}  // namespace footlight::tools
