// Levels by hand over what drives the rig: commands of the socket, and controls.
#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "sim/core/counted.h"
#include "tools/footlight/hand/learn.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

Preview::Preview(const PreviewOptions& options)
    : options_(options),
      opener_(clock_),
      starts_without_inputs_(std::all_of(options.ins.begin(), options.ins.end(), sets_levels_by_hand)) {
  outputs_view_.needs_hold = options.hold_to_live;
  for (const std::string& text : options.ins) (sets_levels_by_hand(text) ? controls_in_ : ins_).push_back(text);
}

Status Preview::open_hand() {
  HandLayer::Options hand;
  hand.socket = options_.socket;
  hand.tempo = opener_.tempo;
  if (!options_.files.rig.empty()) {
    std::error_code unknown;  // then names of fixtures need --rig
    hand.rig = std::filesystem::canonical(options_.files.rig, unknown).string();
  }
  FL_ASSIGN(layer_, HandLayer::open(hand, clock_));
  opener_.hand_link = layer_->link();
  for (const std::string& text : controls_in_) {
    FL_ASSIGN(std::unique_ptr<Source> source, open_input(text, false));
    layer_->add_control(std::move(source));
  }
  return {};
}

// A log or faders drive the rig.
Status Preview::rest_hand() {
  const std::string log = options_.files.log.empty() ? "demo" : "log:" + options_.files.log;
  return layer_->rest_on(player_ ? log : "faders", framed_->compiled.universes,
                         hand_     ? hand_->levels()
                         : player_ ? player_->levels()
                                   : std::span<const std::uint8_t>());
}

// Every turn: the newest of what is held, and what there is to say. A blackout by hand reaches lamps also while the
// picture stands still.
void Preview::follow_hand() {
  const std::span<const std::uint8_t> base = hand_     ? hand_->levels()
                                             : player_ ? player_->levels()
                                                       : std::span<const std::uint8_t>();
  layer_->follow(framed_->compiled.universes, base);
  InputsView& view = inputs_view_;
  if (std::exchange(view.release_hand, false)) layer_->command(HandAction::kReleaseAll);
  if (std::exchange(view.end_hand_blackout, false)) layer_->command(HandAction::kLift);
  const std::size_t held = layer_->held().held_count();
  view.by_hand = held == 0 ? "" : trf_n("{} slot by hand", "{} slots by hand", held, held);
  view.dark_by_hand = layer_->held().dark();
  if (std::exchange(view.tap, false)) tap();
  learn();
  view.has_patterns = !patterns_.empty();
  view.beats_a_minute = opener_.tempo->beats_a_minute();
  for (std::string& notice : layer_->notices()) {
    if (!options_.json) fmt::print(stderr, "footlight: {}\n", notice);
    tell(tr_known(notice));
  }
}

// A key or a button.
void Preview::tap() {
  opener_.tempo->tap(clock_.now_ns());
  if (patterns_.empty()) tell(tr("the tempo is that of made-up inputs, and there is none: F6 adds one"));
}

// The next control that moves is added to its map for what the user named.
void Preview::learn() {
  InputsView& view = inputs_view_;
  HandLearner& learner = layer_->link()->learner;
  view.has_controls = layer_->has_controls();
  if (std::exchange(view.stop_learning, false)) learner.end();
  if (auto target = std::exchange(view.learn, std::nullopt)) {
    learns_for_ = std::move(*target);
    learner.begin();
  }
  if (const auto moved = learner.moved()) {
    const Status added = add_learnt(*moved);
    view.refusal = added ? "" : tr_known(added.error().message);
  }
  view.learns = learner.waits();
}

Status Preview::add_learnt(const HandLearner::Moved& moved) {
  FL_ASSIGN(const Endpoint endpoint, parse_port(moved.port));
  std::error_code unknown;
  const std::string& rig = options_.files.rig;
  const LearnPlan plan = plan_learning(endpoint, rig.empty() ? "" : std::filesystem::absolute(rig, unknown).string());
  if (!endpoint.addresses.empty()) {  // a map has no address: the port would be open to the whole network
    return fail(ErrorCode::kBadInput, "{}: a control map has no address; add osc:{} without '@' to learn", moved.port,
                endpoint.udp_port);
  }
  bool closed = false;
  const Status learnt = learn_control(plan, moved.input, learns_for_, [&](const std::string& text) {
    closed = true;
    return reopen_control(moved.port, text);
  });
  if (!learnt && closed) {  // the map is as it was: so is the port
    if (const Status back = reopen_control(moved.port, moved.port); !back) tell(back.error());
  }
  FL_TRY(learnt);
  // A port without a map drives slots in their order; with one, what the map names.
  const bool first = !endpoint.target.ends_with(".toml") && endpoint.scheme == "midi";
  tell(trf("{}: '{}' controls {}", plan.map, moved.input, learns_for_) +
       (first ? tr("; other controls of this port need to be learnt, too") : ""));
  return {};
}

// Closes a control and opens another one in its place.
Status Preview::reopen_control(const std::string& before, const std::string& after) {
  layer_->remove_control(before);
  std::erase(controls_in_, before);
  FL_ASSIGN(std::unique_ptr<Source> source, open_input(after, true));
  layer_->add_control(std::move(source));
  controls_in_.push_back(after);
  return {};
}

}  // namespace footlight::tools
