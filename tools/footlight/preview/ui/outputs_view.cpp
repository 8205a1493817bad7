#include "tools/footlight/preview/ui/outputs_view.h"

#include <algorithm>
#include <iterator>

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::vector<Universe> OutputRow::sent() const {
  std::vector<Universe> rest;
  std::set_difference(universes.begin(), universes.end(), left_out.begin(), left_out.end(), std::back_inserter(rest));
  return rest;
}

std::size_t OutputsView::live_count() const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const OutputRow& row) { return row.state == ArmState::kArmed; }));
}

bool OutputsView::any_on() const {
  return std::any_of(rows.begin(), rows.end(), [](const OutputRow& row) {
    return row.state == ArmState::kArmed || row.state == ArmState::kOpening;
  });
}

void OutputsView::disarm_all() {
  disarm.clear();
  for (const OutputRow& row : rows) disarm.push_back(row.id);
}

bool OutputsView::drop_requests() {
  const bool any = add || move || !remove.empty();
  add.reset();
  move.reset();
  remove.clear();
  return any;
}

const OutputRow* OutputsView::find(OutputId id) const {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const OutputRow& row) { return row.id == id; });
  return at == rows.end() ? nullptr : &*at;
}

std::vector<std::string> OutputsView::staying() const {
  std::vector<std::string> endpoints;
  for (const OutputRow& row : rows) {
    if (!row.leaves) endpoints.push_back(row.endpoint);
  }
  return endpoints;
}

std::string live_words(const OutputsView& view) {
  const std::size_t count = view.live_count();
  const bool real = std::any_of(view.rows.begin(), view.rows.end(),
                                [](const OutputRow& row) { return row.state == ArmState::kArmed && !row.made_up; });
  if (view.darkness == Darkness::kNotHeld && count == 0) return "";
  if (view.darkness == Darkness::kNone) {
    if (count == 0) return "";
    return real ? trf_n("LIVE: {} output", "LIVE: {} outputs", count, count)
                : trf_n("LIVE: {} output (made up)", "LIVE: {} outputs (made up)", count, count);
  }
  if (count == 0) return tr("BLACKOUT of outputs: none is armed");
  return trf_n("BLACKOUT of outputs: {} sends zeros", "BLACKOUT of outputs: {} send zeros", count, count);
}

std::string blackout_words(const OutputsView& view) {
  switch (view.darkness) {
    case Darkness::kNone: return "";
    case Darkness::kAsked: return tr("Shift+B ends the blackout of outputs");
    case Darkness::kSilence: return tr("The window gave no levels for 2.5 s. Shift+B ends the blackout of outputs");
    case Darkness::kNotHeld: return trf("Lamps are live while {} is held", tr(kHoldKeyName));
  }
  return "";
}

}  // namespace footlight::tools
