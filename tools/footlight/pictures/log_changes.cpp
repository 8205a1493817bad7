#include "tools/footlight/pictures/log_changes.h"

#include <algorithm>
#include <utility>

namespace footlight::tools {

LogChanges::LogChanges(LogReader reader, std::vector<Universe> universes)
    : reader_(std::move(reader)), universes_(std::move(universes)) {}

Result<bool> LogChanges::next(LevelChange& change) {
  LogFrame frame;
  while (true) {
    FL_ASSIGN(const bool more, reader_.next(frame));
    if (!more) return false;
    if (frame.terminated || frame.changes.empty()) continue;
    const auto at = std::lower_bound(universes_.begin(), universes_.end(), frame.universe);
    if (at == universes_.end() || *at != frame.universe) continue;
    change.at_ns = frame.time_ns;
    change.universe = static_cast<int>(at - universes_.begin());
    std::copy(frame.levels.begin(), frame.levels.end(), change.levels.begin());
    return true;
  }
}

void LogChanges::read_levels(std::span<std::uint8_t> levels) {
  std::fill(levels.begin(), levels.end(), std::uint8_t{0});
  for (const LogSnapshot& each : reader_.snapshot()) {
    const auto at = std::lower_bound(universes_.begin(), universes_.end(), each.universe);
    if (at == universes_.end() || *at != each.universe) continue;
    std::copy(each.levels.begin(), each.levels.end(), levels.begin() + (at - universes_.begin()) * kSlotCountMax);
  }
}

}  // namespace footlight::tools
