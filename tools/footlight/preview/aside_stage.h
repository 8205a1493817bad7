// Fixtures of another log, or of a moment that was kept, shown by the frame of the stage in place of its own (decision
// 0165).
//
//   FL_ASSIGN(const bool there, aside.enter(time_ns, exposure_ns, universes, driven));
//   if (there) ... a picture of the frame shows them ...
//   FL_TRY(aside.leave(frame));  // in either case, once that picture is done
//
// In enter() the states of the frame's fixtures are put aside, and come back in leave(), to the bit. Meanwhile nothing
// else may step the frame. Between pictures this has states of its own: as many bytes as FrameState::bytes().
// Needs no window. One thread.
#pragma once

#include <memory>
#include <optional>

#include "render/frame.h"
#include "tools/footlight/monitor/level_moment.h"
#include "tools/footlight/preview/log_player.h"

namespace footlight::tools {

class AsideStage {
 public:
  // A moment. Until keep() its fixtures are where its levels send them.
  explicit AsideStage(LevelMoment moment) : moment_(std::move(moment)) {}
  // A log, of the rig of the frames that are entered.
  explicit AsideStage(std::unique_ptr<LogPlayer> player);

  // The states of the moment.
  void keep(render::FrameState state) { state_ = std::move(state); }
  // The frames that follow are of another rig, whose states are others.
  void forget_states() { state_.reset(); }
  [[nodiscard]] bool is_log() const { return player_ != nullptr; }

  // Of a log: goes on to time_ns, which is clamped to the log, or seeks it, a part in each call, to the bit as
  // LogPlayer does. The last exposure_ns are the exposure of the picture, so that a strobe is lit as in a picture of
  // the frame's own fixtures with that exposure. False: it has not come there yet. universes: of the frame's rig, as
  // it orders them.
  [[nodiscard]] Result<bool> enter(TimeNs time_ns, DurationNs exposure_ns, std::span<const Universe> universes,
                                   const LogPlayer::Driven& driven);
  [[nodiscard]] bool entered() const { return entered_; }
  Status leave(render::Frame& frame);
  // In place of leave(): the frame is gone.
  void abandon() { entered_ = moved_ = false; }
  // Between enter() and leave(): makes moments of a log, for quick seeks, for about budget_ns.
  Status work_at_index(DurationNs budget_ns, const LogPlayer::Driven& driven);

  [[nodiscard]] const std::optional<Transport::Seeking>& seeking() const { return transport_.seeking; }
  // Of its states.
  [[nodiscard]] std::size_t bytes() const { return state_ ? state_->bytes() : 0; }

 private:
  Result<bool> go_to(TimeNs time_ns, DurationNs exposure_ns, const LogPlayer::Driven& driven);
  Status show_levels(std::span<const Universe> universes, const LogPlayer::Driven& driven);

  LevelMoment moment_;                 // without a log
  std::unique_ptr<LogPlayer> player_;  // null: a moment
  Transport transport_;
  std::optional<render::FrameState> state_;  // its own
  render::FrameState shown_;                 // of the frame, while entered
  bool entered_ = false;
  bool moved_ = false;  // since enter()
};

}  // namespace footlight::tools
