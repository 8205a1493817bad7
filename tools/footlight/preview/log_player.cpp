#include "tools/footlight/preview/log_player.h"

#include <algorithm>
#include <utility>

#include "render/passes/tonemap.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kLeapNs = kNsPerS;  // a moment this far ahead is taken instead of the steps to it
constexpr DurationNs kKeptNs = kNsPerS;  // a seek keeps a moment that is at most this much before its picture
constexpr DurationNs kStrideNs = kNsPerS / 4;  // log time between two readings of the clock
constexpr DurationNs kQuickPartNs = 200 * kNsPerMs;  // a part of a seek that a drag follows

// `step`, and the frame's steps are carried out before too many wait. `flushed`: how that went.
Timeline::Step flushing(const Timeline::Step& step, render::Frame& frame, Status& flushed) {
  return [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    step(levels, dt_ns, new_exposure);
    if (frame.steps_are_due() && flushed) flushed = frame.run_steps();
  };
}

}  // namespace

Status advance_frame(Timeline& timeline, render::Frame& frame, TimeNs until_ns, DurationNs exposure_ns,
                     const Timeline::Step& step) {
  Status flushed;
  FL_TRY(timeline.advance(until_ns, exposure_ns, flushing(step, frame, flushed)));
  return flushed;
}

void extend(LightCurve& curve, const SeekIndex& index) {
  const TimeNs last_ns = curve.points().empty() ? -1 : curve.points().back().at_ns;
  for (const SeekIndex::Moment& moment : index.after(last_ns)) {
    curve.add(moment.position.now_ns, moment.position.levels);
  }
}

void extend(LightStrips& strips, const SeekIndex& index, std::size_t moments_max) {
  const TimeNs last_ns = strips.times().empty() ? -1 : strips.times().back();
  std::size_t added = 0;
  for (const SeekIndex::Moment& moment : index.after(last_ns)) {
    if (added++ == moments_max) return;
    strips.add(moment.position.now_ns, moment.position.levels);
  }
}

LogPlayer::LogPlayer(std::function<Timeline()> read, Clock& clock) : read_(std::move(read)), clock_(clock) {
  timeline_.emplace(read_());
  if (timeline_->can_go()) index_.emplace(read_());
}

Status LogPlayer::advance(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) {
  const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    levels_.assign(levels.begin(), levels.end());
    driven.step(levels, dt_ns, new_exposure);
  };
  exposed_ns_ = std::min(exposure_ns, until_ns - timeline_->now_ns());
  if (driven.holds_steps) return timeline_->advance(until_ns, exposure_ns, step);
  return advance_frame(*timeline_, driven.frame, until_ns, exposure_ns, step);
}

// advance(); from states that follow from the whole log, with a moment on the way for the next seek.
Status LogPlayer::replay(TimeNs until_ns, DurationNs exposure_ns, bool exact, const Driven& driven) {
  if (timeline_->can_go() && exact) {
    Status flushed;
    const TimeNs last_ns = until_ns - exposure_ns;
    FL_TRY(timeline_->advance_to_change(last_ns - kKeptNs, last_ns, flushing(driven.step, driven.frame, flushed)));
    FL_TRY(flushed);
    Timeline::Position position = timeline_->position();
    if (position.stepped) {
      FL_ASSIGN(render::FrameState state, driven.frame.save_state());
      kept_ = {std::move(position), std::move(state)};
    }
  }
  return advance(until_ns, exposure_ns, driven);
}

Status LogPlayer::show(TimeNs until_ns, const Driven& driven) {
  return replay(std::clamp<TimeNs>(until_ns, 0, duration_ns()), kExposureNs, !driven.taken_over, driven);
}

Status LogPlayer::show_soon(TimeNs until_ns, const Driven& driven) {
  const TimeNs start_ns = until_ns - kQuickLogNs;
  if (timeline_->can_go() && start_ns > 0) {
    FL_TRY(timeline_->start_at(start_ns));
    // Clouds of haze drift by the time alone.
    FL_ASSIGN(render::FrameState state, driven.frame.save_state());
    state.time_ns = start_ns;
    FL_TRY(driven.frame.load_state(state));
    return advance(std::min(until_ns, duration_ns()), kExposureNs, driven);
  }
  return show(until_ns, driven);
}

const SeekIndex::Moment* LogPlayer::known_before(TimeNs time_ns, const Driven& driven) const {
  if (driven.taken_over) return nullptr;
  const SeekIndex::Moment* known = index_ ? index_->before(time_ns) : nullptr;
  const bool kept = kept_ && kept_->position.now_ns <= time_ns;
  return kept && (known == nullptr || known->position.now_ns < kept_->position.now_ns) ? &*kept_ : known;
}

Status LogPlayer::seek(TimeNs until_ns, const Driven& driven) {
  before_.reset();
  if (std::exchange(seeking_, std::nullopt)) {  // its steps may be of a frame that is gone
    asked_ = true;
    FL_TRY(begin_going_back(std::clamp<TimeNs>(until_ns, 0, duration_ns()), kExposureNs, driven));
  } else {
    FL_TRY(begin_seek(until_ns, kExposureNs, driven));
  }
  while (seeking_) FL_TRY(work_at_seek(INT64_MAX, driven));
  return {};
}

// Whether a seek can go on from where the fixtures are. While something is taken over no states are those of the log,
// so going on is as good as going back, and sooner. So it is in a seek that has not yet come as far.
bool LogPlayer::goes_further(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) const {
  if (until_ns < timeline_->now_ns() + exposure_ns) return false;
  if (driven.taken_over) return true;
  const SeekIndex::Moment* known = known_before(until_ns - exposure_ns, driven);
  return seeking_ && exact_ && (known == nullptr || known->position.now_ns <= timeline_->now_ns());
}

Status LogPlayer::begin_seek(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) {
  until_ns = std::clamp<TimeNs>(until_ns, 0, duration_ns());
  asked_ = true;
  if (!goes_further(until_ns, exposure_ns, driven)) return begin_going_back(until_ns, exposure_ns, driven);
  if (!seeking_) FL_TRY(keep_before(driven));
  exact_ = seeking_ && exact_ && !driven.taken_over;
  exposure_ns_ = exposure_ns;
  seeking_ = {timeline_->now_ns(), timeline_->now_ns(), until_ns};
  return {};
}

// Whether steps from now on lead to this time: it is not earlier, and no moment is near it and far ahead of now.
bool LogPlayer::goes_on(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) const {
  const SeekIndex::Moment* known = known_before(until_ns - exposure_ns, driven);
  const bool leaps = known != nullptr && known->position.now_ns > now_ns() + kLeapNs;
  return until_ns >= now_ns() && !leaps;
}

// Else from a moment or the start.
Status LogPlayer::play_to(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) {
  asked_ = false;
  if (!goes_on(until_ns, exposure_ns, driven)) return begin_going_back(until_ns, exposure_ns, driven);
  moves_in_pause_ = false;
  return advance(until_ns, exposure_ns, driven);
}

Status LogPlayer::play_on(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) {
  FL_CHECK(!seeking_);
  asked_ = false;
  return advance(std::min(until_ns, duration_ns()), exposure_ns, driven);
}

bool LogPlayer::can_hold(const Transport& transport, DurationNs dt_ns, const Driven& driven) const {
  if (transport.seek_ns || seeking_ || driven.frame.steps_are_due()) return false;
  if (!transport.playing) return true;
  dt_ns = std::max<DurationNs>(dt_ns - sought_ns_, 0);
  Transport now = transport;
  now.now_ns = now_ns();
  const TimeNs next_ns = now.next_ns(dt_ns);
  return next_ns == now_ns() || goes_on(next_ns, std::min(dt_ns, kExposureNs), driven);
}

// For cancel_seek().
Status LogPlayer::keep_before(const Driven& driven) {
  before_.reset();
  moved_before_ = moves_in_pause_;
  if (!timeline_->can_go()) return {};
  FL_ASSIGN(render::FrameState state, driven.frame.save_state());
  before_ = {timeline_->position(), std::move(state)};
  return {};
}

// From the last moment before this time, else from the start of the log.
Status LogPlayer::begin_going_back(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) {
  const TimeNs begun_ns = clock_.now_ns();
  const SeekIndex::Moment* known = known_before(until_ns - exposure_ns, driven);
  const TimeNs from_ns = known != nullptr ? known->position.now_ns : 0;
  if (!seeking_) FL_TRY(keep_before(driven));
  driven.restart();
  if (known != nullptr) {
    FL_TRY(timeline_->go_to(known->position));
    FL_TRY(driven.frame.load_state(known->state));
  } else {
    timeline_.emplace(read_());
    FL_TRY(driven.frame.run_steps());
    FL_TRY(driven.device.run_once(
        [&](VkCommandBuffer commands) { render::forget_states(commands, driven.frame.resources()); }));
    driven.frame.forget_air();
  }
  exact_ = !driven.taken_over;
  exposure_ns_ = exposure_ns;
  seeking_ = {from_ns, from_ns, until_ns};
  sought_ns_ += clock_.now_ns() - begun_ns;
  return {};
}

// At least one stride of it.
Status LogPlayer::work_at_seek(DurationNs budget_ns, const Driven& driven) {
  const TimeNs begun_ns = clock_.now_ns();
  const TimeNs last_ns = seeking_->until_ns - exposure_ns_;
  exact_ = exact_ && !driven.taken_over;
  // replay() has the rest.
  for (bool more = true; more && timeline_->now_ns() < last_ns - kKeptNs;) {
    Status flushed;
    const TimeNs next_ns = std::min(timeline_->now_ns() + kStrideNs, last_ns - kKeptNs);
    FL_ASSIGN(more, timeline_->advance_to_change(next_ns, last_ns, flushing(driven.step, driven.frame, flushed)));
    FL_TRY(flushed);
    seeking_->at_ns = timeline_->now_ns();
    const DurationNs took_ns = clock_.now_ns() - begun_ns;
    if (more && took_ns >= budget_ns) {
      FL_TRY(driven.frame.run_steps());
      sought_ns_ += clock_.now_ns() - begun_ns;
      return {};
    }
  }
  FL_TRY(replay(seeking_->until_ns, exposure_ns_, exact_, driven));
  FL_TRY(driven.frame.run_steps());
  if (asked_) {
    FL_TRY(driven.device.run_once(
        [&](VkCommandBuffer commands) { render::forget_exposure(commands, driven.frame.resources()); }));
  }
  seeking_.reset();
  before_.reset();
  moves_in_pause_ = false;
  sought_ns_ += clock_.now_ns() - begun_ns;
  return {};
}

Result<bool> LogPlayer::cancel_seek(const Driven& driven) {
  if (!seeking_) return false;
  seeking_.reset();
  driven.restart();
  if (!before_) {
    FL_TRY(advance(timeline_->now_ns() + kExposureNs, kExposureNs, driven));
    return false;
  }
  FL_TRY(driven.frame.run_steps());
  FL_TRY(timeline_->go_to(before_->position));
  levels_ = before_->position.levels;
  FL_TRY(driven.frame.load_state(before_->state));
  before_.reset();
  moves_in_pause_ = moved_before_;
  return !asked_;
}

Status LogPlayer::turn(Transport& transport, DurationNs dt_ns, const Driven& driven, DurationNs exposure_ns) {
  FL_CHECK(!driven.holds_steps || can_hold(transport, dt_ns, driven));
  dt_ns = std::max<DurationNs>(dt_ns - std::exchange(sought_ns_, 0), 0);
  if (std::exchange(transport.cancels_seek, false)) {
    FL_ASSIGN(const bool stops, cancel_seek(driven));
    transport.playing = transport.playing && !stops;
  }
  transport.now_ns = now_ns();
  const TimeNs next_ns = transport.playing ? transport.next_ns(dt_ns) : now_ns();
  if (transport.seek_ns) {
    FL_TRY(begin_seek(*std::exchange(transport.seek_ns, std::nullopt), exposure_ns, driven));
  } else if (seeking_) {
    // The time of its parts is not played.
  } else if (next_ns != now_ns()) {
    FL_TRY(play_to(next_ns, std::min(dt_ns, kExposureNs), driven));
  } else {
    // What is taken over goes back when it is released; then all fixtures go on.
    moves_in_pause_ = moves_in_pause_ || driven.taken_over;
    if (moves_in_pause_ && !levels_.empty()) driven.step(levels_, dt_ns, true);
  }
  if (seeking_) {
    const bool quick = asked_ && transport.is_quick(seeking_->until_ns);
    FL_TRY(work_at_seek(quick ? kQuickPartNs : kPartNs, driven));
  }
  transport.seeking = seeking_;
  transport.now_ns = now_ns();
  transport.known_ns = index_ && !driven.taken_over ? index_->known_ns() : 0;
  return {};
}

void LogPlayer::stop(Transport& transport) {
  seeking_.reset();
  transport.seeking.reset();
  transport.seek_ns.reset();
  transport.playing = false;
  transport.now_ns = now_ns();
}

Status LogPlayer::work_at_index(DurationNs budget_ns, const Driven& driven) {
  if (!index_ || index_->done() || seeking_) return {};
  Status worked = index_->work(driven.frame, clock_, budget_ns);
  if (worked || driven.device.lost()) return worked;
  index_.reset();
  news_ = worked.error().message + "; seeks begin at the start of the log";
  return {};
}

}  // namespace footlight::tools
