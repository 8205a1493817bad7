// Nine universes at once, as maps of their levels: a part of the universes panel. Dear ImGui only.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tools/footlight/monitor/slot_changes.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

// The tip of a slot under the mouse. more: a line below the others; empty: none.
void draw_slot_tip(UiDesk& desk, const UiInput& input, std::size_t universe, std::size_t slot,
                   const SlotChanges& changes, TimeNs now_ns, const std::string& more);

class UniverseMaps {
 public:
  static constexpr std::size_t kOnPage = 9;

  // Of the page with this universe. `universe` counts in CompiledRig::universes.
  void turn_to(std::size_t universe) { first_ = universe / kOnPage * kOnPage; }
  [[nodiscard]] std::size_t first() const { return first_; }
  // Returns the universe that was clicked. frozen: the levels stay as they are, while the page has the same universes.
  [[nodiscard]] std::optional<std::size_t> draw(UiDesk& desk, const UiInput& input, bool frozen,
                                                const MomentDifference& difference);

 private:
  struct Place;
  void take(const UiDesk& desk, const UiInput& input, bool frozen);
  void draw_map(UiDesk& desk, const UiInput& input, std::size_t index, const Place& place) const;

  std::size_t first_ = 0;
  std::optional<std::vector<Universe>> taken_;  // that maps_ are of; nothing: of a kept moment
  std::vector<SlotChanges> maps_;
  TimeNs now_ns_ = 0;  // of maps_
};

}  // namespace footlight::tools
