#include "tools/footlight/preview/unpatched_levels.h"

#include <algorithm>

namespace footlight::tools {

void UnpatchedLevels::receive(const FrameView& frame) {
  if (frame.start_code != kStartCodeLevels || std::binary_search(patched_.begin(), patched_.end(), frame.universe)) {
    return;
  }
  const std::lock_guard lock(mutex_);
  auto at = std::lower_bound(universes_.begin(), universes_.end(), frame.universe,
                             [](const UnpatchedUniverse& one, Universe wanted) { return one.universe < wanted; });
  const bool known = at != universes_.end() && at->universe == frame.universe;
  if (frame.terminated) {
    if (known) universes_.erase(at);
    fresh_ = fresh_ || known;
    return;
  }
  if (!known && universes_.size() == kUniversesMax) {
    const auto oldest = std::min_element(
        universes_.begin(), universes_.end(),
        [](const UnpatchedUniverse& a, const UnpatchedUniverse& b) { return a.stamp_ns < b.stamp_ns; });
    if (frame.stamp_ns - oldest->stamp_ns < kForgottenNs) return;
    const auto gone = oldest - universes_.begin();
    const auto place = at - universes_.begin();
    universes_.erase(oldest);
    at = universes_.begin() + (gone < place ? place - 1 : place);
  }
  if (!known) at = universes_.insert(at, UnpatchedUniverse{.universe = frame.universe});
  std::copy(frame.slots.begin(), frame.slots.end(), at->levels.begin());
  at->sender = name_of_(frame);
  at->priority = frame.priority;
  at->stamp_ns = frame.stamp_ns;
  ++at->frames;
  fresh_ = true;
}

void UnpatchedLevels::take(std::vector<UnpatchedUniverse>& into) {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(fresh_, false)) return;
  into = universes_;
}

}  // namespace footlight::tools
