// What the report panel of the preview shows, while it is open.
#include <chrono>
#include <utility>

#include "render/memory_groups.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/knob_curves.h"
#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {

// Of a picture that is done.
void Preview::read_report(double gpu_ms) {
  ++report_.picture;
  report_.passes = facts_.passes;
  report_.picture_ms = gpu_ms;
  report_.error = facts_.error;
}

// Between two pictures: what follows from the frame, and what the user asks for.
void Preview::follow_report() {
  report_.measures = facts_.measures_knobs;
  if (!reports()) return;
  report_.bytes = frame_->bytes();
  report_.memory = render::memory_groups(*frame_);
  read_left_out();
  if (!curves_ && !std::exchange(looked_for_curves_, true)) {
    curves_ = read_knob_curves(knob_curves_path(cache_folder(), device_->facts()), device_->facts(), curves_program());
  }
  const fixtures::Needs& needs = framed_->compiled.needs;
  report_.target = facts_.quality;
  report_.present.reset();
  report_.ladder.clear();
  if (curves_) {
    report_.ladder = ladder_.empty() ? render::ladder_of(*curves_, needs) : ladder_;
    render::Knobs drawn = render::knobs_of(frame_->settings());
    drawn.divisor = controls_.divisor;
    report_.present = ladder_.empty() ? render::predicted(*curves_, needs, drawn) : facts_.chosen;
  }
  report_.why_not_measure = outputs_ && outputs_view_.any_on() ? kArmedUnmeasured : "";
  if (!std::exchange(report_.measure, false) || curves_ || !report_.why_not_measure.empty()) return;
  wants_curves_ = facts_.measures_knobs = report_.measures = true;
}

// On a thread of its own: in a large rig it takes longer than a turn of the window.
void Preview::read_left_out() {
  if (reading_left_out_.valid()) {
    if (reading_left_out_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    report_.left_out = reading_left_out_.get();
    report_.has_left_out = true;
  }
  if (left_out_scene_ == framed_ && left_out_settings_ == frame_->settings()) return;
  left_out_scene_ = framed_;
  left_out_settings_ = frame_->settings();
  report_.has_left_out = false;
  const NoSignals no_signals;
  reading_left_out_ = std::async(std::launch::async, [scene = framed_, settings = frame_->settings()] {
    const fixtures::Needs needs = render::drawn_needs(scene->compiled.needs, scene->rig.haze, settings);
    return plan_left_out({scene->rig, scene->compiled, needs, settings});
  });
}

}  // namespace footlight::tools
