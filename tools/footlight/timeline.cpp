#include "tools/footlight/timeline.h"

#include <algorithm>

namespace footlight::tools {

Timeline::Timeline(LogReader reader, const fixtures::CompiledRig& compiled, std::optional<fixtures::VrslReplay> vrsl)
    : reader_(std::move(reader)),
      vrsl_(std::move(vrsl)),
      universes_(compiled.universes),
      levels_(compiled.universes.size() * kSlotCountMax),
      next_levels_(kSlotCountMax) {}

// The next frame that changes something the rig listens to.
Status Timeline::fetch() {
  fetched_ = true;
  LogFrame frame;
  while (true) {
    FL_ASSIGN(const bool more, reader_.next(frame));
    if (!more) {
      next_universe_ = -1;
      return {};
    }
    if (frame.terminated || frame.changes.empty()) continue;
    const auto at = std::lower_bound(universes_.begin(), universes_.end(), frame.universe);
    if (at == universes_.end() || *at != frame.universe) continue;
    next_universe_ = static_cast<int>(at - universes_.begin());
    next_ns_ = frame.time_ns;
    std::copy(frame.levels.begin(), frame.levels.end(), next_levels_.begin());
    return {};
  }
}

void Timeline::apply() {
  std::copy(next_levels_.begin(), next_levels_.end(), levels_.begin() + std::ptrdiff_t{next_universe_} * kSlotCountMax);
}

void Timeline::give(DurationNs dt_ns, bool new_exposure, const Step& step) {
  if (vrsl_) {
    vrsl_->step(levels_, dt_ns, new_exposure, step);
  } else {
    step(levels_, dt_ns, new_exposure);
  }
}

Status Timeline::advance_to(DurationNs until_ns, bool new_exposure, const Step& step) {
  if (!fetched_) FL_TRY(fetch());
  while (next_universe_ >= 0 && next_ns_ <= until_ns) {
    if (next_ns_ > now_ns_) {
      give(next_ns_ - now_ns_, new_exposure, step);
      new_exposure = false;
      stepped_ = true;
      now_ns_ = next_ns_;
    }
    apply();
    FL_TRY(fetch());
  }
  if (until_ns > now_ns_ || !stepped_) {
    give(until_ns - now_ns_, new_exposure, step);
    stepped_ = true;
    now_ns_ = until_ns;
  }
  return {};
}

Status Timeline::advance(DurationNs until_ns, DurationNs exposure_ns, const Step& step) {
  const DurationNs open_ns = std::max(until_ns - exposure_ns, now_ns_);
  if (open_ns > now_ns_) FL_TRY(advance_to(open_ns, true, step));
  return advance_to(until_ns, true, step);
}

}  // namespace footlight::tools
