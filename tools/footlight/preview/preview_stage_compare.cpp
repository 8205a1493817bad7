// A and B of the preview's comparison on the stage (decision 0165).
#include <algorithm>
#include <utility>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/draw_stage_compare.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kAsideIndexNs = 2 * kNsPerMs;  // for the index of the other log, each picture of it

}  // namespace

// Without anything that is compared, A is this moment.
void Preview::set_stage_compare(StageCompare mode) {
  if (mode != StageCompare::kOff && !desk_->comparison().a) keep_this_moment();
  if (mode != StageCompare::kOff && !desk_->comparison().a) return;  // a rig without a universe
  cancel_drags();
  compared_view_ = static_cast<int>(StageComparison::kB);
  both_.set_mode(mode);
  for (View& view : views_) view.pictures = 0;
}

// Once a turn, after panels and keys may have changed what is compared.
void Preview::follow_stage_compare() {
  const StageCompare before = both_.mode();
  both_.follow(desk_->comparison(), [this] {
    return compared_ ? make_player(framed_, compared_->again()) : nullptr;
  });
  if (both_.mode() != before) cancel_drags();
}

// Levels of universes that are in no log, since they were made up for faders, are those of now.
LogPlayer::Driven Preview::driven_aside() {
  const auto step = [this, own = logged_universes(*framed_)](std::span<const std::uint8_t> levels, std::int64_t dt_ns,
                                                             bool new_exposure) {
    const auto& universes = framed_->compiled.universes;
    if (own.size() == universes.size()) return frame_->step(levels, dt_ns, new_exposure);
    aside_levels_.assign(levels.begin(), levels.end());
    const LevelView now(universes, newest_levels());
    for (std::size_t i = 0; i < universes.size(); ++i) {
      if (std::binary_search(own.begin(), own.end(), universes[i])) continue;
      const auto of = now.of(universes[i]);
      std::copy(of.begin(), of.end(), aside_levels_.begin() + static_cast<std::ptrdiff_t>(i * kSlotCountMax));
    }
    frame_->step(aside_levels_, dt_ns, new_exposure);
  };
  return {*device_, *frame_, false, step, [] {}, false};
}

// Which picture is begun, and the fixtures for it. Without a camera there is none yet: a log is sought.
Status Preview::begin_compared() {
  const std::size_t side = both_.next_side();
  const DurationNs offset_ns = desk_->comparison().a ? desk_->comparison().a->offset_ns : 0;
  both_.begin(desk_->state().camera, compared_time_ns(), player_ ? player_->exposed_ns() : LogPlayer::kExposureNs);
  drawn_camera_ = both_.camera();
  drawn_view_ = both_.mode() == StageCompare::kBeside ? static_cast<int>(side) : 0;
  drawn_main_ = side == StageComparison::kB;
  AsideStage* const aside = both_.aside(side);
  if (aside == nullptr) return {};
  FL_ASSIGN(const bool there,
            aside->enter(both_.log_ns() + offset_ns, both_.exposure_ns(), framed_->compiled.universes,
                         driven_aside()));
  if (there) {
    both_.hold_steps();
    return aside->work_at_index(kAsideIndexNs, driven_aside());
  }
  drawn_camera_.reset();
  picture_since_ns_ = -1;
  return aside->leave(*frame_);
}

// Of two pictures one is the stage's own or B, and the other A.
Status Preview::take_difference(const HostPicture& picture) {
  if (drawn_main_) {
    both_.take_b(picture);
    return {};
  }
  const std::size_t stretches = both_.watch() != nullptr ? both_.watch()->stretches().size() : 0;
  const bool shows = both_.take_a(picture, desk_->flashes(), last_ns_ - start_ns_);
  tell_flashes(both_.watch() != nullptr && both_.watch()->stretches().size() > stretches);
  if (!shows) return {};
  ++views_[0].pictures;
  views_[0].shown = drawn_camera_;
  shows_rough_ = is_rough_;
  return window_->set_picture(0, both_.picture());
}

void Preview::draw_compared() {
  if (!both_.on() || !desk_->comparison().a) return;
  const double scale = static_cast<double>(window_->pixels_per_unit());
  for (int view = 0; view < views(); ++view) {
    const PixelRect where = place_of(view);
    const CompareTagPlace place{static_cast<float>(where.x / scale), static_cast<float>(where.y / scale),
                                static_cast<float>(where.width / scale)};
    if (both_.mode() == StageCompare::kDifference) {
      draw_difference_tag(both_.difference(), place, window_->ui_scale());
    } else {
      draw_compare_tag(desk_->comparison(), static_cast<std::size_t>(view) == StageComparison::kA, place,
                       window_->ui_scale());
    }
  }
}

}  // namespace footlight::tools
