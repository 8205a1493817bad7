#include "tools/footlight/preview/aside_stage.h"

#include <algorithm>
#include <utility>

#include "render/passes/tonemap.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kPlayOnNs = 2 * kNsPerS;  // a log that is behind by more is sought

}  // namespace

AsideStage::AsideStage(std::unique_ptr<LogPlayer> player) : player_(std::move(player)) {
  transport_.duration_ns = player_->duration_ns();
}

Result<bool> AsideStage::enter(TimeNs time_ns, DurationNs exposure_ns, std::span<const Universe> universes,
                               const LogPlayer::Driven& driven) {
  FL_CHECK(!entered_);
  FL_ASSIGN(shown_, driven.frame.save_state());
  entered_ = true;
  moved_ = false;
  const bool begins = !state_;
  if (state_) FL_TRY(driven.frame.load_state(*state_));
  if (player_) return go_to(std::clamp<TimeNs>(time_ns, 0, player_->duration_ns()), exposure_ns, driven);
  if (begins) FL_TRY(show_levels(universes, driven));
  return true;
}

// True: the log is there.
Result<bool> AsideStage::go_to(TimeNs time_ns, DurationNs exposure_ns, const LogPlayer::Driven& driven) {
  const TimeNs open_ns = time_ns - exposure_ns;
  const TimeNs now_ns = player_->now_ns();  // of a seek that is under way: its end
  const bool seeks = player_->seeking().has_value();
  if (state_ && !seeks && now_ns == time_ns) return true;  // it stands still
  moved_ = true;
  if (state_ && !seeks && now_ns <= open_ns && now_ns >= open_ns - kPlayOnNs) {
    FL_TRY(player_->play_on(time_ns, exposure_ns, driven));
    return true;
  }
  transport_.playing = false;
  if (!seeks || now_ns != time_ns) transport_.seek_ns = time_ns;
  FL_TRY(player_->turn(transport_, 0, driven, exposure_ns));
  return !player_->seeking();
}

// As at the start of a show: heads are where their levels are.
Status AsideStage::show_levels(std::span<const Universe> universes, const LogPlayer::Driven& driven) {
  FL_TRY(driven.frame.run_steps());
  FL_TRY(driven.device.run_once(
      [&](VkCommandBuffer commands) { render::forget_states(commands, driven.frame.resources()); }));
  driven.frame.forget_air();
  const LevelView view(moment_);
  std::vector<std::uint8_t> levels(universes.size() * kSlotCountMax);
  for (std::size_t i = 0; i < universes.size(); ++i) {
    const auto own = view.of(universes[i]);
    std::copy(own.begin(), own.end(), levels.begin() + static_cast<std::ptrdiff_t>(i * kSlotCountMax));
  }
  moved_ = true;
  driven.frame.step(levels, 0, true);
  return driven.frame.run_steps();
}

Status AsideStage::leave(render::Frame& frame) {
  if (!std::exchange(entered_, false)) return {};
  if (moved_) {
    FL_ASSIGN(state_, frame.save_state());
  }
  return frame.load_state(std::exchange(shown_, {}));
}

Status AsideStage::work_at_index(DurationNs budget_ns, const LogPlayer::Driven& driven) {
  return player_ ? player_->work_at_index(budget_ns, driven) : Status{};
}

}  // namespace footlight::tools
