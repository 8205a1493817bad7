#include "tools/footlight/preview/ui/level_comparison.h"

#include <atomic>
#include <ctime>

#include <fmt/chrono.h>

#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {

std::uint64_t next_kept_number() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

KeptLevels keep_levels(const std::vector<Universe>& universes, std::span<const std::uint8_t> levels,
                       std::optional<TimeNs> log_ns) {
  KeptLevels kept;
  kept.moment.universes = universes;
  kept.moment.levels.assign(levels.begin(), levels.end());
  kept.moment.levels.resize(universes.size() * kSlotCountMax);
  kept.when = log_ns ? time_text(*log_ns) : fmt::format("{:%H:%M:%S}", fmt::localtime(std::time(nullptr)));
  kept.log_ns = log_ns;
  kept.number = next_kept_number();
  return kept;
}

}  // namespace footlight::tools
