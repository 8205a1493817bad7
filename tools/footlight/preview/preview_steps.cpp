// What drives the fixtures of the preview: a log, live inputs or faders, and over them what the user takes over.
#include <algorithm>

#include <fmt/format.h>

#include "fixtures/displays/pixel_slots.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kIndexNs = 2 * kNsPerMs;  // for the index of a log, each picture
constexpr std::size_t kStripMomentsMax = 4;    // each picture
constexpr DurationNs kIndexPausedNs = 10 * kNsPerMs;
constexpr DurationNs kMeanwhileNs = 22 * kNsPerMs;  // from step to step while a picture is in flight: 45 a second
constexpr DurationNs kWireDelayNs = 2 * kNsPerMs;   // live pictures are that late: looks may be on their way

}  // namespace

// VRSL's processing of the levels, from its start; nothing if the rig does not use it.
std::optional<fixtures::VrslReplay> Preview::vrsl_replay(const PreviewScene& scene) {
  if (!scene.written) return std::nullopt;
  return fixtures::VrslReplay(*scene.written, scene.compiled);
}

// The log is the file that was opened, whatever has become of its name since. Any thread.
std::unique_ptr<LogPlayer> Preview::make_player(SharedScene scene, const LogReader& log) {
  const auto read = [reader = std::make_shared<const LogReader>(log.again()), scene = std::move(scene)] {
    Timeline timeline(reader->again(), scene->compiled, vrsl_replay(*scene));
    timeline.pass_over(fixtures::pixel_universes(scene->rig, scene->compiled));
    return timeline;
  };
  return std::make_unique<LogPlayer>(read, clock_);
}

LogPlayer::Driven Preview::driven() {
  return {*device_, *frame_, overlays(),
          [this](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
            give(levels, dt_ns, new_exposure);
          },
          [this] { panels_.restart(); }};
}

// After curve_: a selection of some fixtures has a curve of its own.
void Preview::follow_selected_curve() {
  const std::vector<int>& which = desk_->state().selection.fixtures;
  if (which.empty() || which.size() >= framed_->rig.fixtures.size()) {
    selected_curve_.reset();
    return;
  }
  if (!selected_curve_ || curve_selection_ != which) {
    curve_selection_ = which;
    selected_curve_.emplace(framed_->rig, RigIndex(framed_->rig, framed_->compiled), which);
  }
  extend(*selected_curve_, *player_->index());
}

// What of a log is left out, once.
void Preview::tell_damage(std::optional<DamageWatch>& watch) {
  if (!watch) return;
  const std::string news = watch->take_news();
  if (news.empty()) return;
  if (!options_.json) fmt::print(stderr, "footlight: {}\n", printable_line(news));
  tell(tr_known(news), true);
}

Status Preview::work_at_index() {
  if (picture_ns_ < 0) return {};  // the first picture comes first
  FL_TRY(player_->work_at_index(controls_.transport.playing ? kIndexNs : kIndexPausedNs, driven()));
  if (std::string news = player_->take_news(); !news.empty()) tell(tr_known(news), true);
  tell_damage(log_watch_);
  if (player_->index() == nullptr || !panels_.any_open()) return {};
  if (!curve_) {
    curve_.emplace(framed_->rig, RigIndex(framed_->rig, framed_->compiled));
    selected_curve_.reset();
    strips_.reset();
  }
  extend(*curve_, *player_->index());
  follow_selected_curve();
  if (!strips_) strips_ = std::make_unique<Strips>(framed_);
  extend(strips_->strips, *player_->index(), kStripMomentsMax);
  return {};
}

// A small picture of the log in place of one of the stage, while the timeline may be open.
Status Preview::begin_thumbnail() {
  if (!player_ || !panels_.any_open() || is_rough_ || picture_ns_ < 0) return {};
  if (outputs_ && outputs_view_.any_on()) return {};  // nothing steps meanwhile, and lamps would stand still
  const bool paused = !controls_.transport.playing;
  if (!thumbnails_.is_due(last_ns_, player_->index(), player_->duration_ns(), paused)) return {};
  if (desk_->cameras().empty()) return {};
  const double work_lx = controls_.work_light ? static_cast<double>(controls_.work_light_lx) : 0;
  FL_TRY(thumbnails_.begin(last_ns_, *device_, *frame_, *player_->index(), player_->duration_ns(),
                           {desk_->cameras().front(), work_lx}));
  picture_since_ns_ = -1;
  return {};
}

Status Preview::take_thumbnail() {
  if (!thumbnails_.in_flight()) return {};
  FL_ASSIGN(const bool done, thumbnails_.done(times_out_ ? StagePicture::kForeverNs : 0));
  return done ? thumbnails_.finish(clock_.now_ns(), *frame_) : Status{};
}

bool Preview::overlays() const { return desk_->overlays() || layer_->overlays(); }

// In this order: a blackout by hand is over what was taken over.
void Preview::lay_over(std::span<const Universe> universes, std::span<std::uint8_t> levels) {
  layer_->overlay(universes, levels);
  desk_->overlay(levels);
  layer_->darken(universes, levels);
}

// One step of the fixtures and of what the panels follow, with what the user has set and taken over.
void Preview::give(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure) {
  if (overlays()) {
    overlaid_.assign(levels.begin(), levels.end());
    lay_over(framed_->compiled.universes, overlaid_);
    levels = overlaid_;
  }
  // Pictures of the rig from before an edit go on while the first ones are rough, and if no frame of the edited rig can
  // be made.
  if (edited_->scene() != framed_) {
    if (levels.data() != overlaid_.data()) overlaid_.assign(levels.begin(), levels.end());
    darken_deleted(*framed_, *edited_->scene(), overlaid_);
    levels = overlaid_;
  }
  if (recording_ && !player_) recording_->take(step_ns_, framed_->compiled.universes, levels);
  step_ns_ += dt_ns;
  if (both_.holds_steps()) {
    both_.hold(levels, dt_ns, new_exposure);
  } else {
    frame_->step(levels, dt_ns, new_exposure);
  }
  panels_.step(levels, dt_ns, new_exposure);
}

// As they came, of the rig of the frame.
std::span<const std::uint8_t> Preview::newest_levels() const {
  return live_ ? live_->levels() : hand_ ? hand_->levels() : player_->levels();
}

// The newest levels, as the panels show them.
std::span<const std::uint8_t> Preview::panel_levels() {
  const std::span<const std::uint8_t> newest = newest_levels();
  const auto& universes = desk_->compiled().universes;
  const auto& given = framed_->compiled.universes;
  if (!overlays() && universes == given) return newest;
  // The rig may have been edited since, and its frame is not yet there.
  panel_levels_.assign(universes.size() * kSlotCountMax, 0);
  for (std::size_t i = 0; i < universes.size(); ++i) {
    const auto at = std::lower_bound(given.begin(), given.end(), universes[i]);
    const auto from = static_cast<std::size_t>(at - given.begin()) * kSlotCountMax;
    if (at == given.end() || *at != universes[i] || from + kSlotCountMax > newest.size()) continue;
    std::copy_n(newest.begin() + static_cast<std::ptrdiff_t>(from), kSlotCountMax,
                panel_levels_.begin() + static_cast<std::ptrdiff_t>(i * kSlotCountMax));
  }
  lay_over(universes, panel_levels_);
  return panel_levels_;
}

// At the time of the log; without one at that since the preview began.
void Preview::show_videos() {
  const Status shown = videos_.show(player_ ? player_->now_ns() : last_ns_ - start_ns_, *frame_);
  std::vector<std::string> news = videos_.take_news();
  if (!shown) {
    const std::string line = shown.error().message + "; its displays keep their last picture";
    if (!options_.json) fmt::print(stderr, "footlight: {}\n", printable_utf8(line));
    tell(tr_known(line), true);
  }
  for (const std::string& line : news) {
    if (!options_.json) fmt::print(stderr, "footlight: {}\n", printable_utf8(line));
    tell(tr_known(line));
  }
}

// Up to this turn, between two pictures.
Status Preview::step_levels() {
  const DurationNs dt_ns = last_ns_ - std::exchange(stepped_ns_, last_ns_);
  frame_->adapt_for(dt_ns);  // also while the log is paused
  if (live_) {
    live_->take();
    const TimeNs until_ns = std::max(last_ns_ - kWireDelayNs, live_timeline_->now_ns());
    step_ns_ = live_timeline_->now_ns();
    return advance_frame(*live_timeline_, *frame_, until_ns, std::min(dt_ns, LogPlayer::kExposureNs), driven().step);
  }
  if (hand_) {
    step_ns_ = last_ns_ - dt_ns;
    give(hand_->levels(), dt_ns, true);
    return {};
  }
  FL_TRY(turn_log(dt_ns, driven()));
  return work_at_index();
}

// A log that can no longer be read stands still, and may be played or sought again.
Status Preview::turn_log(DurationNs dt_ns, const LogPlayer::Driven& driven) {
  const Status turned = player_->turn(controls_.transport, dt_ns, driven);
  if (turned || device_->lost()) return turned;
  player_->stop(controls_.transport);
  const std::string& line = turned.error().message;
  if (!options_.json) fmt::print(stderr, "footlight: {}\n", printable_line(line));
  tell(tr_known(line), true);
  return {};
}

// Up to this turn, while a picture is in flight: for panels and outputs. The steps wait in the frame for the next
// picture. What needs the GPU waits for the end of this one: seeks, a log that repeats, too many steps, and edits.
Status Preview::step_meanwhile() {
  if (thumbnails_.in_flight()) return {};  // the frame has the states of another time
  const DurationNs dt_ns = last_ns_ - stepped_ns_;
  const bool edited = edited_->scene() != framed_ && edited_->scene() != failed_;
  if (edited || dt_ns < kMeanwhileNs || steps_wait()) return {};
  LogPlayer::Driven holding = driven();
  holding.holds_steps = true;
  if (player_ && !player_->can_hold(controls_.transport, dt_ns, holding)) return {};
  stepped_ns_ = last_ns_;
  frame_->adapt_for(dt_ns);
  if (player_) {
    FL_TRY(turn_log(dt_ns, holding));
    keep_recording();
    return {};
  }
  if (hand_) {
    step_ns_ = last_ns_ - dt_ns;
    give(hand_->levels(), dt_ns, true);
    return {};
  }
  live_->take();
  const TimeNs until_ns = std::max(last_ns_ - kWireDelayNs, live_timeline_->now_ns());
  step_ns_ = live_timeline_->now_ns();
  return live_timeline_->advance(until_ns, std::min(dt_ns, LogPlayer::kExposureNs), holding.step);
}

}  // namespace footlight::tools
