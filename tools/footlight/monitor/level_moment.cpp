#include "tools/footlight/monitor/level_moment.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "tools/footlight/duration.h"

namespace footlight::tools {

std::span<const std::uint8_t> LevelView::of(Universe universe) const {
  const auto at = std::lower_bound(universes.begin(), universes.end(), universe);
  if (at == universes.end() || *at != universe) return {};
  const auto from = static_cast<std::size_t>(at - universes.begin()) * kSlotCountMax;
  return from + kSlotCountMax <= levels.size() ? levels.subspan(from, kSlotCountMax) : std::span<const std::uint8_t>();
}

bool MomentDifference::equal() const { return slots.empty(); }

int MomentDifference::slots_of(Universe universe) const {
  const auto at = std::lower_bound(universes.begin(), universes.end(), universe,
                                   [](const Count& one, Universe wanted) { return one.universe < wanted; });
  return at != universes.end() && at->universe == universe ? at->slots : 0;
}

LevelMoment only_of(const LevelView& moment, std::span<const Universe> universes) {
  LevelMoment kept;
  for (const Universe universe : universes) {
    const auto levels = moment.of(universe);
    if (levels.empty()) continue;
    kept.universes.push_back(universe);
    kept.levels.insert(kept.levels.end(), levels.begin(), levels.end());
  }
  return kept;
}

MomentDifference compare_moments(const LevelView& a, const LevelView& b, int tolerance) {
  static constexpr std::array<std::uint8_t, kSlotCountMax> kDark{};
  MomentDifference difference;
  std::vector<Universe> all;
  std::set_union(a.universes.begin(), a.universes.end(), b.universes.begin(), b.universes.end(),
                 std::back_inserter(all));
  for (const Universe universe : all) {
    const auto of_a = a.of(universe);
    const auto of_b = b.of(universe);
    MomentDifference::Count count{universe, 0, !of_a.empty(), !of_b.empty()};
    const std::span<const std::uint8_t> from = of_a.empty() ? std::span(kDark) : of_a;
    const std::span<const std::uint8_t> to = of_b.empty() ? std::span(kDark) : of_b;
    if (!std::equal(from.begin(), from.end(), to.begin())) {
      for (int slot = 0; slot < kSlotCountMax; ++slot) {
        const std::uint8_t level_a = from[static_cast<std::size_t>(slot)];
        const std::uint8_t level_b = to[static_cast<std::size_t>(slot)];
        if (std::abs(level_a - level_b) <= tolerance) continue;
        ++count.slots;
        difference.slots.push_back({universe, slot + 1, level_a, level_b});
      }
    }
    difference.universes.push_back(count);
  }
  return difference;
}

Result<LevelMoment> moment_of(LogReader& reader, DurationNs at_ns) {
  if (at_ns > reader.info().duration_ns) {
    return fail(ErrorCode::kBadInput, "{}: {} lies after its end; expected a time up to {}", reader.info().path,
                show_duration(at_ns), show_duration(reader.info().duration_ns));
  }
  FL_TRY(reader.seek(at_ns));
  LevelMoment moment;
  for (const LogSnapshot& one : reader.snapshot()) {
    moment.universes.push_back(one.universe);
    moment.levels.insert(moment.levels.end(), one.levels.begin(), one.levels.end());
  }
  return moment;
}

}  // namespace footlight::tools
