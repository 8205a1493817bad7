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

Result<bool> AsideStage::enter(TimeNs time_ns, std::span<const Universe> universes, const LogPlayer::Driven& driven) {
  FL_CHECK(!entered_);
  FL_ASSIGN(shown_, driven.frame.save_state());
  entered_ = true;
  moved_ = false;
  const bool begins = !state_;
  if (state_) FL_TRY(driven.frame.load_state(*state_));
  if (!player_) {
    if (begins) FL_TRY(show_levels(universes, driven));
    return true;
  }
  time_ns = std::clamp<TimeNs>(time_ns, 0, player_->duration_ns());
  if (begins) transport_.seek_ns = time_ns;
  FL_TRY(go_to(time_ns, driven));
  return !player_->seeking() && player_->now_ns() == time_ns;
}

Status AsideStage::go_to(TimeNs time_ns, const LogPlayer::Driven& driven) {
  const TimeNs now_ns = player_->now_ns();  // of a seek that is under way: its end
  transport_.playing = false;
  DurationNs dt_ns = 0;
  if (transport_.seek_ns || time_ns < now_ns || time_ns > now_ns + kPlayOnNs) {
    transport_.seek_ns = time_ns;
  } else if (time_ns > now_ns) {
    transport_.playing = true;
    dt_ns = time_ns - now_ns;
  } else if (!player_->seeking()) {
    return {};  // it stands still
  }
  moved_ = true;
  return player_->turn(transport_, dt_ns, driven);
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
