// The outputs of the preview to real lamps: what they get of the picture, and what the user asks of them.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/core/counted.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kLookNs = 2 * kNsPerS;  // for devices that are plugged in

}  // namespace

// Adds outputs, and opens none of them.
Status Preview::open_outputs(std::span<const std::string> texts) {
  if (texts.empty()) return {};
  FL_ASSIGN(OutputPlan plan, plan_outputs(texts, *edited_->scene()));
  for (const std::string& warning : plan.warnings) fmt::print(stderr, "footlight: {}\n", warning);
  if (options_.flashes == FlashMode::kLimit) {
    fmt::print(stderr,
               "footlight: --flashes limit holds back the picture, not outputs; 'footlight run' has it for them\n");
  }
  if (outputs_) {
    for (PlannedOutput& planned : plan.outputs) FL_TRY(outputs_->add(std::move(planned)));
  } else {
    const auto open = [this](const PlannedOutput& planned) {
      OutOptions out;
      out.source_name = "Footlight preview";  // so that it is another sender than a bridge of this machine
      const std::lock_guard lock(opener_mutex_);
      return opener_.open_sink(planned.endpoint, planned.universes, out);
    };
    FL_ASSIGN(outputs_, LiveOutputs::start(std::move(plan), open, clock_));
  }
  outputs_->follow(outputs_view_);
  return {};
}

// Those of the window before, as its user has left them; a message names each that does not fit this rig.
Status Preview::keep_outputs(std::span<const std::string> texts) {
  for (const std::string& text : texts) {
    if (const Status added = open_outputs({&text, 1}); !added) tell(added.error());
  }
  return {};
}

Status Preview::move_output(const OutputsView::Move& move) {
  const OutputRow* const row = outputs_view_.find(move.id);
  if (!outputs_ || row == nullptr) return {};
  FL_ASSIGN(const Endpoint endpoint, parse_port(row->endpoint));
  const auto text = moved_endpoint(endpoint, move.to);
  if (!text || *text == endpoint.text) return {};
  FL_ASSIGN(OutputPlan plan, plan_outputs({&*text, 1}, *edited_->scene()));
  return outputs_->replace(move.id, std::move(plan.outputs.front()));
}

// Once a turn, also while the picture stands still: the newest levels, and what the user asks for.
void Preview::drive_outputs() {
  // While a frame of an edited rig is being made, the levels are still in the places of the rig from before.
  const auto& before = framed_->own_universes;
  const auto& now = edited_->scene()->own_universes;
  auto& sendable = outputs_view_.universes;
  sendable.clear();
  std::set_intersection(before.begin(), before.end(), now.begin(), now.end(), std::back_inserter(sendable));
  if (std::exchange(outputs_view_.looks, false) && clock_.now_ns() - looked_ns_ >= kLookNs) {
    outputs_view_.devices = plugged_devices(drivers::find_devices());
    looked_ns_ = clock_.now_ns();
  }
  if (const auto endpoint = std::exchange(outputs_view_.add, std::nullopt)) {
    const Status added = open_outputs({&*endpoint, 1});
    outputs_view_.refusal = added ? "" : tr_known(added.error().message);
  }
  if (const auto move = std::exchange(outputs_view_.move, std::nullopt)) {
    const Status moved = move_output(*move);
    outputs_view_.refusal = moved ? "" : tr_known(moved.error().message);
  }
  if (!outputs_) return;
  if (live_) live_->take();
  const auto levels = panel_levels();
  outputs_->give(desk_->compiled().universes, levels, sendable);
  outputs_->hold(window_->holds_live_key() && !window_->minimised());
  outputs_->follow(outputs_view_);
  if (picture_ns_ >= 0 && !std::exchange(outputs_told_, true)) {
    tell(trf_n("{} output, not armed: F6", "{} outputs, not armed: F6", outputs_view_.rows.size(),
               outputs_view_.rows.size()));
  }
  for (std::string& notice : outputs_->notices()) {
    // Without exceptions, since standard error may be gone: outputs go on.
    std::fputs(("footlight: " + notice + "\n").c_str(), stderr);
    std::string words = tr_known(notice);
    tell(words, notice.starts_with("not armed"));
    outputs_view_.notice = std::move(words);
  }
  (void)end_without_outputs(outputs_, outputs_view_);
}

// There are two blackouts, and Shift+B ends one of them: what to do where it is the other one that is on.
std::string Preview::why_still_dark(const UiCall& call) const {
  const bool ends_none = call.action == UiAction::kEndBlackout && !is_blackout(outputs_view_.darkness);
  return ends_none && inputs_view_.dark_by_hand ? hand_blackout_end() : "";
}

// True if the call was for outputs.
bool Preview::call_outputs(const UiCall& call) {
  const bool is_blackout = call.action == UiAction::kBlackout;
  if (call.action == UiAction::kHoldToLive) {
    outputs_view_.needs_hold = !outputs_view_.needs_hold;
    tell(outputs_view_.needs_hold ? trf("lamps are live only while {} is held", tr(kHoldKeyName))
                                  : std::string(tr("lamps are live without a key that is held")));
    return true;
  }
  if (!is_blackout && call.action != UiAction::kEndBlackout && call.action != UiAction::kDisarm) return false;
  if (!outputs_) {
    tell(tr("there is no output to real lamps; F6 or --output ENDPOINT adds one"));
  } else if (is_blackout) {
    outputs_->black_out();
  } else if (call.action == UiAction::kEndBlackout) {
    outputs_->lift();
  } else {
    outputs_view_.disarm_all();
  }
  return true;
}

}  // namespace footlight::tools
