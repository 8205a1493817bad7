#include "tools/footlight/pictures/timeline.h"

#include <algorithm>
#include <utility>

#include "fixtures/displays/pixel_slots.h"
#include "sim/core/check.h"

namespace footlight::tools {

Timeline::Timeline(const fixtures::CompiledRig& compiled, std::optional<fixtures::VrslReplay> vrsl, TimeNs start_ns)
    : vrsl_(std::move(vrsl)), levels_(compiled.universes.size() * kSlotCountMax), now_ns_(start_ns) {}

Timeline::Timeline(LevelChanges& changes, const fixtures::CompiledRig& compiled,
                   std::optional<fixtures::VrslReplay> vrsl, TimeNs start_ns)
    : Timeline(compiled, std::move(vrsl), start_ns) {
  changes_ = &changes;
}

Timeline::Timeline(std::span<const std::uint8_t> held, const fixtures::CompiledRig& compiled)
    : Timeline(compiled, std::nullopt, 0) {
  hold(held);
}

void Timeline::hold(std::span<const std::uint8_t> levels) {
  FL_CHECK_EQ(levels.size(), levels_.size());
  levels_.assign(levels.begin(), levels.end());
}

void Timeline::pass_over(std::vector<bool> universes) {
  FL_CHECK_EQ(universes.size() * kSlotCountMax, levels_.size());
  // Without a fixture steps cost nothing but their levels, and advance_to_change() needs some.
  const bool all = std::find(universes.begin(), universes.end(), false) == universes.end();
  passed_over_ = all ? std::vector<bool>() : std::move(universes);
}

bool Timeline::makes_step() const {
  return passed_over_.empty() || !passed_over_[static_cast<std::size_t>(next_.universe)];
}

Result<DrivenRig> compile_driven(fixtures::Rig& rig, std::optional<LogReader> log) {
  std::optional<fixtures::Rig> vrsl_rig;  // as written
  if (rig.vrsl && log) vrsl_rig = std::exchange(rig, fixtures::vrsl_shown(rig));
  DrivenRig driven;
  FL_ASSIGN(driven.compiled, fixtures::compile(rig));
  if (!log) return driven;
  std::optional<fixtures::VrslReplay> vrsl;
  if (vrsl_rig) vrsl.emplace(*vrsl_rig, driven.compiled);
  driven.timeline.emplace(std::move(*log), driven.compiled, std::move(vrsl));
  driven.timeline->pass_over(fixtures::pixel_universes(rig, driven.compiled));
  return driven;
}

Timeline::Timeline(LogReader reader, const fixtures::CompiledRig& compiled, std::optional<fixtures::VrslReplay> vrsl)
    : Timeline(compiled, std::move(vrsl), 0) {
  duration_ns_ = reader.info().duration_ns;
  log_ = std::make_unique<LogChanges>(std::move(reader), compiled.universes);
  changes_ = log_.get();
}

void Timeline::give(DurationNs dt_ns, bool new_exposure, const Step& step) {
  if (vrsl_) {
    vrsl_->step(levels_, dt_ns, new_exposure, step);
  } else {
    step(levels_, dt_ns, new_exposure);
  }
}

// Afterwards next_ is the next change, or has no universe.
Status Timeline::read_next() {
  if (next_.universe >= 0 || changes_ == nullptr) return {};
  FL_ASSIGN(const bool more, changes_->next(next_));
  if (!more) next_.universe = -1;
  return {};
}

void Timeline::take_next() {
  std::copy(next_.levels.begin(), next_.levels.end(), levels_.begin() + std::ptrdiff_t{next_.universe} * kSlotCountMax);
  next_.universe = -1;
}

Status Timeline::advance_to(TimeNs until_ns, bool new_exposure, const Step& step) {
  while (true) {
    FL_TRY(read_next());
    if (next_.universe < 0 || next_.at_ns > until_ns) break;
    if (makes_step() && next_.at_ns > now_ns_) {
      give(next_.at_ns - now_ns_, new_exposure, step);
      new_exposure = false;
      stepped_ = true;
      now_ns_ = next_.at_ns;
    }
    take_next();
  }
  if (until_ns > now_ns_ || !stepped_) {
    give(until_ns - now_ns_, new_exposure, step);
    stepped_ = true;
    now_ns_ = until_ns;
  }
  return {};
}

Result<bool> Timeline::advance_to_change(TimeNs from_ns, TimeNs until_ns, const Step& step) {
  while (true) {
    FL_TRY(read_next());
    if (next_.universe < 0 || next_.at_ns > until_ns) return stepped_ && now_ns_ >= from_ns;
    if (makes_step() && next_.at_ns > now_ns_) {
      if (stepped_ && now_ns_ >= from_ns) return true;
      give(next_.at_ns - now_ns_, false, step);
      stepped_ = true;
      now_ns_ = next_.at_ns;
    }
    take_next();
  }
}

Status Timeline::go_to(const Position& position) {
  FL_CHECK(can_go());
  FL_CHECK_EQ(position.levels.size(), levels_.size());
  next_.universe = -1;
  now_ns_ = position.now_ns;
  levels_ = position.levels;
  stepped_ = position.stepped;
  return log_->seek(position.now_ns);
}

Status Timeline::start_at(TimeNs time_ns) {
  FL_CHECK(can_go());
  FL_TRY(log_->seek(time_ns));
  log_->read_levels(levels_);
  next_.universe = -1;
  now_ns_ = time_ns;
  stepped_ = false;
  return {};
}

Status Timeline::advance(TimeNs until_ns, DurationNs exposure_ns, const Step& step) {
  const TimeNs open_ns = std::max(until_ns - exposure_ns, now_ns_);
  if (open_ns > now_ns_) FL_TRY(advance_to(open_ns, true, step));
  return advance_to(until_ns, true, step);
}

}  // namespace footlight::tools
