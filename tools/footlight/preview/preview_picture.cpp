// What the user changes of the preview's picture while it runs: haze, harmful flashes, and quality as error or time.
#include <chrono>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "sim/core/no_signals.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/knob_curves.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

// The window may hang for longer than outputs wait.
const char* const kArmedUnmeasured =
    tr_mark("this machine is not measured yet, and outputs are armed: disarm them first");

void Preview::take_picture_requests() {
  if (const auto haze = std::exchange(controls_.haze_per_m, std::nullopt)) {
    picture_haze_per_m_ = *haze;
    if (haze_is_rig_) {
      if (const Status edited = desk_->edit(fixtures::set_haze(desk_->edited(), *haze)); !edited) tell(edited.error());
    }
  }
  if (const auto mode = std::exchange(controls_.flashes, std::nullopt)) desk_->set_flashes(*mode);
  facts_.flashes = desk_->flashes();
  if (const auto quality = std::exchange(controls_.quality, std::nullopt)) ask_for_quality(*quality);
}

// Scattering of the room's haze in the picture.
double Preview::haze_per_m() const {
  return haze_is_rig_ ? desk_->edited().haze.scattering_per_m : picture_haze_per_m_;
}

// Between two pictures: what the GPU reads for flashes can be made anew.
Status Preview::follow_flashes() {
  const FlashMode mode = desk_->flashes();
  const bool limits = mode == FlashMode::kLimit;
  bool changes = false;
  for (int i = 0; i < kViewsMax; ++i) {
    View& view = views_[static_cast<std::size_t>(i)];
    const bool wanted = mode != FlashMode::kOff && i < views();
    if (wanted ? view.flashes && view.flashes->limits() == limits : !view.flashes) continue;
    view.flashes_held = false;
    changes = true;
    if (wanted && view.flashes) {
      view.flashes->set_limits(limits);  // it remembers the flashes that were shown
      continue;
    }
    view.flashes.reset();
    if (!wanted) continue;
    FL_ASSIGN(view.flashes, PreviewFlashes::make(*device_, limits));
  }
  if (changes) tell_flashes(false);  // the marks of the other views stay
  return {};
}

// Between two pictures: after the first one, which is there soon because it is rough, the pipelines of whole pictures
// are compiled beside rough ones.
void Preview::follow_first_picture(const PixelRect& where) {
  if (!is_rough_ || times_.count() == 0) return;
  if (!std::exchange(compiles_whole_, true)) frame_->compile_ahead(frame_settings(where, false));
  if (!times_out_ && !device_->pipelines().finished()) return;
  is_rough_ = false;
  for (View& view : views_) view.pictures = 0;  // those that count
}

// True once a frame of other settings can begin. Other threads compile what its pictures need, and the one before goes
// on meanwhile.
bool Preview::is_compiled(const PixelRect& where) {
  return coming_.come(
      frame_settings(where, is_rough_), [this](const render::FrameSettings& wanted) { frame_->compile_ahead(wanted); },
      [this] { return times_out_ || device_->pipelines().finished(); });
}

Busy Preview::busy() const {
  BusyWork work;
  if (reading_curves_.valid()) work.knobs_share = curves_share_.load();
  // From the edit to its first picture: one may be in flight, and drivers compile some shaders while they draw.
  const bool waits = edited_->scene() != framed_ && edited_->scene() != failed_;
  work.makes_frame = making_.valid() || first_of_edit_ || waits;
  work.undone = making_.valid() && edited_->scene() == framed_;
  work.can_undo = desk_->edited_last();
  if (player_) work.seeking = player_->seeking();
  if (!work.seeking) work.seeking = both_.seeking();
  work.compiles = coming_.waits();
  if (reading_compared_.valid()) work.reads_log = compared_path_;
  return busy_of(work);
}

// What the mark shows.
void Preview::cancel_busy() {
  const Busy now = busy();
  if (!now.can_cancel) return;
  if (now.with == BusyWith::kKnobs) ask_for_quality({});
  if (now.with == BusyWith::kEdit) step_history(true);
  if (now.with != BusyWith::kSeek) return;
  controls_.transport.cancels_seek = player_ && player_->seeking();
  if (!controls_.transport.cancels_seek) set_stage_compare(StageCompare::kOff);
}

// The curves of this machine, which take seconds to measure the first time. Any thread.
Result<render::KnobCurves> Preview::read_curves() {
  KnobCurveOptions curve_options = suited_curve_options(*device_);
  curves_share_ = 0;
  curve_options.go_on = [this](double done, double all) {
    curves_share_ = all > 0 ? done / all : 0;
    return !closed_ && !stops_curves_;
  };
  return machine_knob_curves(*device_, cache_folder(), curve_options, [this] {
    if (!options_.json) fmt::print(stderr, "footlight: measuring the knobs of {}\n", device_->name());
  });
}

render::FrameSettings Preview::table_settings(const PixelRect& where) const {
  render::FrameSettings settings = settings_with(render::with_everything(knobs_), where);
  settings.probes = options_.probes;
  return settings;
}

// For an error, the knobs that keep it. For a time, those that fit it after the time of the last picture; without one,
// those nearest the default ones, or on a CPU, which may take seconds for these, the cheapest.
std::size_t Preview::first_place(const render::KnobCurves& curves) const {
  const render::QualityRequest& request = facts_.quality;
  if (request.error > 0) return render::choose(ladder_, request);
  const fixtures::Needs& needs = framed_->compiled.needs;
  if (frame_ && gpu_ms_ > 0) {
    const auto drawn = render::predicted(curves, needs, render::knobs_of(frame_->settings()));
    const double pixels = controls_.divisor * controls_.divisor;
    if (drawn) return render::choose(ladder_, request, pixels * gpu_ms_ / drawn->ms);
  }
  if (device_->is_software()) return ladder_.size() - 1;
  const auto usual = render::predicted(curves, needs, {});
  return usual ? render::nearest(ladder_, usual->ms) : 0;
}

// The knobs that follow from the curves and what is asked for.
void Preview::take_curves(const render::KnobCurves& curves) {
  const render::QualityRequest& request = facts_.quality;
  ladder_ = render::ladder_of(curves, framed_->compiled.needs, request);
  if (ladder_.empty()) return;
  const std::size_t start = first_place(curves);
  if (request.ms > 0) keeper_.emplace(ladder_, request.ms, start);
  follow_knobs(ladder_[start]);
}

void Preview::ask_for_quality(const render::QualityRequest& request) {
  const bool asks = request.any();
  facts_.measures_knobs = facts_.measures_knobs && reading_curves_.valid();
  if (asks && !curves_) {
    curves_ = read_knob_curves(knob_curves_path(cache_folder(), device_->facts()), device_->facts(), curves_program());
  }
  if (asks && !curves_ && outputs_ && outputs_view_.any_on()) return tell(tr(kArmedUnmeasured), true);
  facts_.quality = request;
  facts_.chosen.reset();
  keeper_.reset();
  ladder_.clear();
  wants_curves_ = false;
  // A measurement goes on for the new request, or ends by itself.
  stops_curves_ = !asks;
  stopped_curves_ = stopped_curves_ || !asks;
  if (!asks) {
    knobs_ = {};
    knobs_.tile_error = options_.tile_error;
    knobs_.body_error_px = options_.body_error_px;
    return;
  }
  if (curves_) return take_curves(*curves_);
  if (reading_curves_.valid()) return;
  facts_.measures_knobs = true;  // once no frame is being made
}

// True while the picture stands still: the GPU measures how long knobs take.
Result<bool> Preview::follow_quality() {
  if (facts_.measures_knobs && !reading_curves_.valid() && !making_.valid()) {
    const NoSignals no_signals;
    stops_curves_ = stopped_curves_ = false;
    reading_curves_ = std::async(std::launch::async, [this] { return read_curves(); });
  }
  if (!reading_curves_.valid()) return false;
  if (reading_curves_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return true;
  auto curves = reading_curves_.get();
  if (!curves && device_->lost()) return tl::unexpected<Error>(std::move(curves).error());
  const bool asks = facts_.quality.any();
  const bool wants = std::exchange(wants_curves_, false);
  facts_.measures_knobs = false;
  if (curves) {
    curves_ = std::move(*curves);
    if (asks) take_curves(*curves_);
  } else if (asks && stopped_curves_) {  // asked for again while it was ending
    facts_.measures_knobs = true;
  } else if (asks) {
    facts_.quality = {};
    tell(trf("{}; nodes and pixels are chosen by hand", tr_known(curves.error().message)), true);
  } else if (wants) {
    tell(curves.error());
  }
  return false;
}

// Waits for curves that are being measured, and leaves them.
void Preview::drop_curves() {
  stops_curves_ = true;
  if (reading_curves_.valid()) (void)reading_curves_.get();
  facts_.measures_knobs = false;
}

}  // namespace footlight::tools
