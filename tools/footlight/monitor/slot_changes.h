// The levels of one universe and when each of them last changed, for displays: the monitor and the preview's window.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"

namespace footlight::tools {

inline constexpr DurationNs kChangeShownNs = kNsPerS;      // how long a change is marked
inline constexpr DurationNs kSilentNs = 2'500 * kNsPerMs;  // E1.31-2018 section 6.7.1

struct SlotChanges {
  Slots levels{};
  std::array<TimeNs, kSlotCountMax> changed_ns{};  // time of the last change of each level; 0: none

  // first: there were no levels before, so nothing has changed. Slots past the end of `now` stay as they are.
  void take(std::span<const std::uint8_t> now, TimeNs now_ns, bool first) {
    for (std::size_t i = 0; i < levels.size() && i < now.size(); ++i) {
      if (now[i] != levels[i] && !first) changed_ns[i] = now_ns;
      levels[i] = now[i];
    }
  }
  // How recent the last change of a slot is: 1 just now, down to 0 after kChangeShownNs and for a slot without one.
  [[nodiscard]] float heat(std::size_t slot, TimeNs now_ns) const {
    const DurationNs age_ns = now_ns - changed_ns[slot];
    if (changed_ns[slot] == 0 || age_ns >= kChangeShownNs) return 0;
    return 1 - static_cast<float>(age_ns < 0 ? 0 : age_ns) / static_cast<float>(kChangeShownNs);
  }
};

}  // namespace footlight::tools
