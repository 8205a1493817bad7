#include "tools/footlight/preview/ui/stage_box.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace footlight::tools {

Selection boxed(const Selection& selection, const std::vector<int>& inside, BoxMode mode) {
  Selection next;
  const auto& old = selection.fixtures;
  const auto out = std::back_inserter(next.fixtures);
  switch (mode) {
    case BoxMode::kOnlyThese: next.fixtures = inside; break;
    case BoxMode::kAdds: std::set_union(old.begin(), old.end(), inside.begin(), inside.end(), out); break;
    case BoxMode::kTakesAway: std::set_difference(old.begin(), old.end(), inside.begin(), inside.end(), out); break;
  }
  next.lead = next.has(selection.lead) ? selection.lead : next.fixtures.empty() ? -1 : next.fixtures.front();
  return next;
}

bool StageBox::take(UiDesk& desk, const StagePick& pick, const BoxInput& input) {
  if (input.pressed) {
    cancel();
    if (!input.over_stage || !(input.ctrl || input.shift)) return false;
    from_ = to_ = input.mouse;
    mode_ = input.ctrl && input.shift ? BoxMode::kTakesAway : input.ctrl ? BoxMode::kAdds : BoxMode::kOnlyThese;
    return false;
  }
  if (!from_) return false;
  to_ = input.mouse;
  drawn_ = drawn_ || glm::length(to_ - *from_) >= kClickUnits;
  if (input.down) return drawn_;
  const bool ends = drawn_;
  if (ends) desk.select(boxed(desk.state().selection, pick.fixtures_in(input.place, low(), high()), mode_));
  cancel();
  return ends;
}

}  // namespace footlight::tools
