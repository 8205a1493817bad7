// Two moments that the window compares: one that was kept, or another log at the time of the window, and now or another
// one that was kept. Not an edit: it is lost when the window closes, and undo does not change it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "tools/footlight/monitor/level_moment.h"

namespace footlight::tools {

struct KeptLevels {
  LevelMoment moment;  // that the fixtures got
  std::string when;    // time of the log, or of the day
  std::optional<TimeNs> log_ns;
  std::string log;           // name of another log whose levels these are, at any time; empty: a moment that was kept
  DurationNs offset_ns = 0;  // then: its time minus that of the window
  std::uint64_t number = 0;  // of next_kept_number(): another one is another moment or log
};

struct LevelComparison {
  std::optional<KeptLevels> a;  // nothing: nothing is compared
  std::optional<KeptLevels> b;  // nothing: now
};

[[nodiscard]] std::uint64_t next_kept_number();

// log_ns: the time of the log that plays; nothing: there is none.
[[nodiscard]] KeptLevels keep_levels(const std::vector<Universe>& universes, std::span<const std::uint8_t> levels,
                                     std::optional<TimeNs> log_ns);

}  // namespace footlight::tools
