// Inputs of the preview that come and go while it runs: patterns and models of devices, to play with.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/rig_pattern.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

// again: while it runs, when a device that is unplugged is no reason to stop.
Result<std::unique_ptr<Source>> Preview::open_input(const std::string& text, bool again) {
  FL_ASSIGN(const Endpoint endpoint, parse_port(text));
  if (plays_pattern(endpoint)) {  // on the fixtures of the rig; a bridge, which has none, plays it on slots
    FL_ASSIGN(const Pattern pattern, pattern_of(endpoint.target));
    const bool all = text.find('=') == std::string::npos;
    std::vector<Universe> universes = all ? framed_->compiled.universes : endpoint.show_universes();
    std::sort(universes.begin(), universes.end());
    auto source = std::make_unique<PatternSource>(
        text, pattern, rig_pattern(framed_->rig, framed_->compiled, universes), opener_.tempo);
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
void Preview::follow_inputs() {
  InputsView& view = inputs_view_;
  if (const auto text = std::exchange(view.add, std::nullopt)) {
    const Status added = add_input(*text);
    view.refusal = added ? "" : tr_known(added.error().message);
  }
  if (const auto text = std::exchange(view.remove, std::nullopt)) remove_input(*text);
  if (const auto move = std::exchange(view.move, std::nullopt)) {
    const Status moved = move_input(*move);
    view.refusal = moved ? "" : tr_known(moved.error().message);
  }
  view.inputs = inputs();
  view.made_up.clear();
  view.movable.clear();
  for (const std::string& text : view.inputs) {
    const auto endpoint = parse_port(text);
    if (endpoint && is_made_up(*endpoint)) view.made_up.push_back(text);
    if (endpoint && moved_endpoint(*endpoint, 1)) view.movable.push_back(text);
  }
  view.why_not = why_no_input();
}

std::vector<std::string> Preview::inputs() const {
  std::vector<std::string> all = ins_;
  all.insert(all.end(), controls_in_.begin(), controls_in_.end());
  return all;
}

// Empty: an input of levels can be added now.
std::string Preview::why_no_input() const {
  if (player_) {
    return tr("A log drives the rig; start the window without it to add inputs of levels. Controls can be added.");
  }
  if (outputs_view_.any_on()) return tr("Disarm the outputs to add inputs: real lamps would follow them.");
  return "";
}

Status Preview::add_input(const std::string& text) {
  const std::vector<std::string> there = inputs();
  if (std::find(there.begin(), there.end(), text) != there.end()) {
    return fail(ErrorCode::kBadInput, "{}: it is in the list already", text);
  }
  FL_ASSIGN(const bool control, is_control(text));
  const std::string why_not = control ? "" : why_no_input();  // of this moment: an output may just have been armed
  if (!why_not.empty()) return fail(ErrorCode::kBadInput, "{}", why_not);
  FL_ASSIGN(std::unique_ptr<Source> source, open_input(text, false));
  if (control) {
    layer_->add_control(std::move(source));
    controls_in_.push_back(text);
    tell(trf("{} sets levels by hand", text));
    return {};
  }
  if (live_) {
    live_->add(std::move(source));
  } else {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::move(source));
    if (const Status started = start_live(std::move(sources)); !started) {
      close_inputs();
      FL_TRY(rest_hand());
      return started;
    }
    resting_hand_ = std::move(hand_);
    resting_scene_ = framed_;
  }
  ins_.push_back(text);
  const bool made_up = is_made_up(*parse_port(text));
  tell(made_up ? trf("{} is made up: no console sends it", text) : trf("{} drives the rig", text));
  return {};
}

// All inputs are opened again: a device has one opener at a time.
Status Preview::move_input(const InputsView::Move& move) {
  const auto at = std::find(ins_.begin(), ins_.end(), move.input);
  if (at == ins_.end()) return {};
  FL_ASSIGN(const Endpoint endpoint, parse_port(move.input));
  const auto moved = moved_endpoint(endpoint, move.to);
  if (!moved || *moved == move.input) return {};
  if (std::find(ins_.begin(), ins_.end(), *moved) != ins_.end()) {
    return fail(ErrorCode::kBadInput, "{}: it is in the list already", *moved);
  }
  if (const std::string why_not = why_no_input(); !why_not.empty()) return fail(ErrorCode::kBadInput, "{}", why_not);
  *at = *moved;
  open_inputs_again(*framed_);
  if (live_) tell(trf("{} drives the rig", *moved));  // else it has said why not
  return {};
}

void Preview::remove_input(const std::string& text) {
  if (std::erase(controls_in_, text) > 0) return layer_->remove_control(text);
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
  if (const Status rests = rest_hand(); !rests) tell(rests.error());
  tell(tr("faders drive the rig again"));
}

void Preview::close_inputs() {
  layer_->leave();
  live_timeline_.reset();
  patterns_.clear();
  live_.reset();
  unpatched_.clear();
  facts_.status = {};
}

}  // namespace footlight::tools
