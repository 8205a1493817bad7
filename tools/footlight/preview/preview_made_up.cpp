// Inputs of the preview that come and go while it runs: patterns and models of devices, to play with.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/rig_pattern.h"

namespace footlight::tools {

// again: while it runs, when a device that is unplugged is no reason to stop.
Result<std::unique_ptr<Source>> Preview::open_input(const std::string& text, bool again) {
  FL_ASSIGN(const Endpoint endpoint, parse_port(text));
  if (plays_pattern(endpoint)) {  // on the fixtures of the rig; a bridge, which has none, plays it on slots
    FL_ASSIGN(const Pattern pattern, pattern_of(endpoint.target));
    const bool all = text.find('=') == std::string::npos;
    std::vector<Universe> universes = all ? framed_->compiled.universes : endpoint.show_universes();
    std::sort(universes.begin(), universes.end());
    auto source =
        std::make_unique<PatternSource>(text, pattern, rig_pattern(framed_->rig, framed_->compiled, universes));
    patterns_.push_back(source.get());
    return source;
  }
  InOptions in;
  in.hear_preview = true;  // such frames are meant for visualisers like this one
  in.yields = true;        // a bridge keeps its unicast frames
  in.wait_for_device = again;
  const std::lock_guard lock(opener_mutex_);
  return opener_.open_source(endpoint, in);
}

// After an edit that leaves the universes as they are.
void Preview::follow_patterns() {
  for (PatternSource* pattern : patterns_) {
    pattern->play(rig_pattern(framed_->rig, framed_->compiled, pattern->universes()));
  }
}

// Once a picture: what there is, and what the user asks for.
void Preview::follow_made_up() {
  MadeUpView& view = made_up_view_;
  if (const auto text = std::exchange(view.add, std::nullopt)) add_input(*text);
  if (const auto text = std::exchange(view.remove, std::nullopt)) remove_input(*text);
  view.inputs.clear();
  for (const std::string& text : ins_) {
    const auto endpoint = parse_port(text);
    if (endpoint && is_made_up(*endpoint)) view.inputs.push_back(text);
  }
  view.why_not = player_ != nullptr       ? "A log drives the rig; start the window without it."
                 : outputs_view_.any_on() ? "Disarm the outputs first: real lamps would follow it."
                                          : "";
}

void Preview::add_input(const std::string& text) {
  if (player_ != nullptr || outputs_view_.any_on() || std::find(ins_.begin(), ins_.end(), text) != ins_.end()) return;
  if (live_) {
    Result<std::unique_ptr<Source>> source = open_input(text, true);
    if (!source) return tell(source.error().message);
    live_->add(std::move(*source));
    ins_.push_back(text);
  } else {
    if (hand_) resting_hand_ = std::make_unique<HandLevels>(*hand_);
    resting_scene_ = framed_;
    ins_.push_back(text);
    open_inputs_again(*framed_);
    if (!live_) return ins_.pop_back();
  }
  tell(fmt::format("{} is made up: no console sends it; F6 removes it", text));
}

void Preview::remove_input(const std::string& text) {
  const auto at = std::find(ins_.begin(), ins_.end(), text);
  if (at == ins_.end()) return;
  ins_.erase(at);
  if (!ins_.empty()) return open_inputs_again(*framed_);
  close_inputs();
  hand_ = resting_hand_ ? moved_hand(*resting_hand_, *resting_scene_, *framed_)
                        : std::make_unique<HandLevels>(framed_->rig, framed_->compiled);
  resting_hand_.reset();
  resting_scene_.reset();
  frame_->settle_machine_air(hand_->levels());
  if (outputs_ && outputs_view_.any_on()) outputs_->black_out();  // real lamps must not follow faders at once
  tell("faders drive the rig again");
}

void Preview::close_inputs() {
  live_timeline_.reset();
  patterns_.clear();
  live_.reset();
  facts_.status = {};
}

}  // namespace footlight::tools
