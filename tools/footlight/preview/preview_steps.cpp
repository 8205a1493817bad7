// What drives the fixtures of the preview: a log, live inputs or faders, and over them what the user takes over.
#include <algorithm>

#include <fmt/format.h>

#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kExposureMaxNs = 20 * kNsPerMs;  // as `footlight render --at`; less if the frame is shorter
constexpr DurationNs kIndexNs = 2 * kNsPerMs;         // for the index of a log, each picture
constexpr DurationNs kIndexPausedNs = 10 * kNsPerMs;
constexpr DurationNs kLeapNs = kNsPerS;            // a moment this far ahead is taken instead of the steps to it
constexpr DurationNs kWireDelayNs = 2 * kNsPerMs;  // live pictures are that late: looks may be on their way

}  // namespace

// VRSL's processing of the levels, from its start; nothing if the rig does not use it.
std::optional<fixtures::VrslReplay> Preview::vrsl_replay(const PreviewScene& scene) {
  if (!scene.written) return std::nullopt;
  return fixtures::VrslReplay(*scene.written, scene.compiled);
}

// The log from its start, once more, for a scene.
Result<std::unique_ptr<Timeline>> Preview::read_log(const PreviewScene& scene) const {
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options_.files));
  if (!log) return fail(ErrorCode::kIo, "{}: the log can no longer be read", options_.files.log);
  auto timeline = std::make_unique<Timeline>(std::move(*log), scene.compiled, vrsl_replay(scene));
  timeline->pass_over(fixtures::pixel_universes(scene.rig, scene.compiled));
  return timeline;
}

// A second reading of the log, which runs ahead between pictures.
Status Preview::make_index() {
  index_.reset();
  curve_.reset();
  curved_ = 0;
  if (!timeline_->can_go()) return {};
  FL_ASSIGN(const std::unique_ptr<Timeline> timeline, read_log(*framed_));
  index_.emplace(std::move(*timeline));
  return {};
}

Status Preview::work_at_index() {
  Transport& transport = controls_.transport;
  if (picture_ns_ < 0) return {};  // the first picture comes first
  if (index_ && !index_->done()) FL_TRY(index_->work(*frame_, clock_, transport.playing ? kIndexNs : kIndexPausedNs));
  if (index_) transport.known_ns = index_->known_ns();
  if (!index_ || !panels_.any_open()) return {};
  if (!curve_) curve_.emplace(framed_->rig, RigIndex(framed_->rig, framed_->compiled));
  const auto& moments = index_->moments();
  curved_ = std::min(curved_, moments.size());  // some were dropped
  for (; curved_ < moments.size(); ++curved_) {
    const Timeline::Position& position = moments[curved_].position;
    curve_->add(position.now_ns, position.levels);
  }
  return {};
}

// Moments lack what the user has taken over.
const SeekIndex::Moment* Preview::known_before(TimeNs time_ns) const {
  return index_ && !desk_->overlays() ? index_->before(time_ns) : nullptr;
}

// Plays or seeks to a time of the log. If that is earlier, or far ahead, every fixture takes the states of the last
// known moment before it, or starts again: the picture is the one that `footlight render` makes of this time.
Status Preview::replay_to(TimeNs until_ns, DurationNs exposure_ns) {
  until_ns = std::clamp<TimeNs>(until_ns, 0, timeline_->duration_ns());
  const SeekIndex::Moment* known = known_before(until_ns - exposure_ns);
  const bool leaps = known != nullptr && known->position.now_ns > timeline_->now_ns() + kLeapNs;
  if (until_ns < timeline_->now_ns() || leaps) return go_back(until_ns, exposure_ns);
  return advance(*timeline_, until_ns, exposure_ns);
}

// From a known moment, else from the start of the log.
Status Preview::go_back(TimeNs until_ns, DurationNs exposure_ns) {
  panels_.restart();
  const SeekIndex::Moment* known = known_before(until_ns - exposure_ns);
  if (known != nullptr) {
    FL_TRY(timeline_->go_to(known->position));
    log_levels_ = known->position.levels;
    FL_TRY(frame_->load_state(known->state));
  } else {
    FL_ASSIGN(timeline_, read_log(*framed_));
    FL_TRY(frame_->run_steps());
    FL_TRY(device_->run_once([&](VkCommandBuffer commands) { render::forget_states(commands, frame_->resources()); }));
    frame_->forget_air();
  }
  return advance(*timeline_, until_ns, exposure_ns);
}

Status Preview::advance(Timeline& timeline, TimeNs until_ns, DurationNs exposure_ns) {
  Status flushed;
  FL_TRY(timeline.advance(until_ns, exposure_ns,
                          [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                            if (timeline_) log_levels_.assign(levels.begin(), levels.end());
                            give(levels, dt_ns, new_exposure);
                            if (frame_->steps_are_due() && flushed) flushed = frame_->run_steps();
                          }));
  return flushed;
}

// One step of the fixtures and of what the panels follow, with what the user has taken over.
void Preview::give(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure) {
  if (desk_->overlays()) {
    overlaid_.assign(levels.begin(), levels.end());
    desk_->overlay(overlaid_);
    levels = overlaid_;
  }
  frame_->step(levels, dt_ns, new_exposure);
  panels_.step(levels, dt_ns, new_exposure);
}

// The newest levels, as the panels show them.
std::span<const std::uint8_t> Preview::panel_levels() {
  const std::span<const std::uint8_t> newest = live_   ? live_->levels()
                                               : hand_ ? hand_->levels()
                                                       : std::span<const std::uint8_t>(log_levels_);
  const auto& universes = desk_->compiled().universes;
  const auto& given = framed_->compiled.universes;
  if (!desk_->overlays() && universes == given) return newest;
  // The rig may have been edited since, and its frame is not yet there.
  panel_levels_.assign(universes.size() * kSlotCountMax, 0);
  for (std::size_t i = 0; i < universes.size(); ++i) {
    const auto at = std::lower_bound(given.begin(), given.end(), universes[i]);
    const auto from = static_cast<std::size_t>(at - given.begin()) * kSlotCountMax;
    if (at == given.end() || *at != universes[i] || from + kSlotCountMax > newest.size()) continue;
    std::copy_n(newest.begin() + static_cast<std::ptrdiff_t>(from), kSlotCountMax,
                panel_levels_.begin() + static_cast<std::ptrdiff_t>(i * kSlotCountMax));
  }
  desk_->overlay(panel_levels_);
  return panel_levels_;
}

Status Preview::step_levels(DurationNs dt_ns) {
  if (live_) {
    live_->take();
    const TimeNs until_ns = std::max(last_ns_ - kWireDelayNs, live_timeline_->now_ns());
    FL_TRY(advance(*live_timeline_, until_ns, std::min(dt_ns, kExposureMaxNs)));
  } else if (hand_) {
    give(hand_->levels(), dt_ns, true);
  } else {
    Transport& transport = controls_.transport;
    if (transport.seek_ns) {
      moves_in_pause_ = false;
      FL_TRY(replay_to(*transport.seek_ns, kExposureMaxNs));
      transport.seek_ns.reset();
    } else if (transport.playing) {
      transport.now_ns = timeline_->now_ns();
      FL_TRY(replay_to(transport.next_ns(dt_ns), std::min(dt_ns, kExposureMaxNs)));
      moves_in_pause_ = false;
    } else {
      // What is taken over moves in a pause, and goes back when it is released; then all fixtures go on.
      moves_in_pause_ = moves_in_pause_ || desk_->overlays();
      if (moves_in_pause_ && !log_levels_.empty()) give(log_levels_, dt_ns, true);
    }
    transport.now_ns = timeline_->now_ns();
    FL_TRY(work_at_index());
  }
  return {};
}

}  // namespace footlight::tools
