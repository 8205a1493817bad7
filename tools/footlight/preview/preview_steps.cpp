// What drives the fixtures of the preview: a log, live inputs or faders, and over them what the user takes over.
#include <algorithm>

#include <fmt/format.h>

#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kExposureMaxNs = 20 * kNsPerMs;  // as `footlight render --at`; less if the frame is shorter
constexpr DurationNs kWireDelayNs = 2 * kNsPerMs;     // live pictures are that late: looks may be on their way

}  // namespace

// VRSL's processing of the levels, from its start; nothing if the rig does not use it.
std::optional<fixtures::VrslReplay> Preview::vrsl_replay(const PreviewScene& scene) {
  if (!scene.written) return std::nullopt;
  return fixtures::VrslReplay(*scene.written, scene.compiled);
}

// Seeks to a time of the log, from its start if that is earlier. Then every fixture starts again, so that the picture
// is the one that `footlight render` makes of this moment.
Status Preview::replay_to(DurationNs until_ns, DurationNs exposure_ns) {
  until_ns = std::clamp<DurationNs>(until_ns, 0, timeline_->duration_ns());
  if (until_ns < timeline_->now_ns()) {
    FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options_.files));
    if (!log) return fail(ErrorCode::kIo, "{}: the log can no longer be read", options_.files.log);
    timeline_ = std::make_unique<Timeline>(std::move(*log), framed_->compiled, vrsl_replay(*framed_));
    FL_TRY(frame_->run_steps());
    FL_TRY(device_->run_once([&](VkCommandBuffer commands) { render::forget_states(commands, frame_->resources()); }));
    frame_->forget_air();
    panels_.restart();
  }
  return advance(*timeline_, until_ns, exposure_ns);
}

Status Preview::advance(Timeline& timeline, TimeNs until_ns, DurationNs exposure_ns) {
  Status flushed;
  FL_TRY(timeline.advance(until_ns, exposure_ns,
                          [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                            if (timeline_) log_levels_.assign(levels.begin(), levels.end());
                            give(levels, dt_ns, new_exposure);
                            if (frame_->pending_steps() >= kStepsHeldMax && flushed) flushed = frame_->run_steps();
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
    if (controls_.seek_s) {
      moves_in_pause_ = false;
      FL_TRY(replay_to(static_cast<DurationNs>(*controls_.seek_s * 1e9), kExposureMaxNs));
      controls_.seek_s.reset();
    } else if (controls_.playing) {
      DurationNs until_ns = timeline_->now_ns() + dt_ns;
      if (until_ns > timeline_->duration_ns() && controls_.loop) until_ns = 0;
      FL_TRY(replay_to(until_ns, std::min(dt_ns, kExposureMaxNs)));
      moves_in_pause_ = false;
    } else {
      // What is taken over moves in a pause, and goes back when it is released; then all fixtures go on.
      moves_in_pause_ = moves_in_pause_ || desk_->overlays();
      if (moves_in_pause_ && !log_levels_.empty()) give(log_levels_, dt_ns, true);
    }
    facts_.time_s = static_cast<double>(timeline_->now_ns()) * 1e-9;
  }
  return {};
}

// Several steps may come in one frame.
void Preview::seek(double by_s) {
  if (timeline_) controls_.seek_s = std::clamp(controls_.seek_s.value_or(facts_.time_s) + by_s, 0.0, facts_.duration_s);
}

}  // namespace footlight::tools
