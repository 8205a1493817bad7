// The part of the universes panel that compares two moments: a row of buttons, and the list of slots that differ. Dear
// ImGui only.
#pragma once

#include <cstddef>
#include <optional>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

class CompareView {
 public:
  // Compares anew, unless `frozen`: then what was compared last stays, until A or B is another one. True: it is frozen
  // and compared anew.
  bool take(const UiDesk& desk, const UiInput& input, bool frozen);
  // The buttons, while there is a moment A; `universe` is the one that is shown.
  void draw_row(UiDesk& desk, const UiInput& input, Universe universe);
  // The slots that differ. A click on one selects its fixture and shows its universe, an index into those of the rig.
  void draw_list(UiDesk& desk, float height, std::size_t& shown) const;

  [[nodiscard]] const MomentDifference& difference() const { return difference_; }

 private:
  [[nodiscard]] static MomentDifference of(const KeptLevels& a, const LevelView& b);

  MomentDifference difference_;
  std::optional<LevelMoment> a_;  // that was compared with now last; nothing: B was a kept moment, or there was no A
};

}  // namespace footlight::tools
