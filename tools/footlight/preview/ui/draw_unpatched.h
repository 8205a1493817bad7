// Universes that arrive and that the rig does not use, in the panel of universes: a list, and the levels of one. Dear
// ImGui only.
#pragma once

#include <optional>

#include "tools/footlight/monitor/slot_changes.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

class UnpatchedView {
 public:
  // A list to choose from; nothing is drawn if nothing arrives, or without live inputs.
  void draw_choice(const UiInput& input);
  // One was chosen, and draw() shows it. frozen: as it was.
  [[nodiscard]] bool shows() const { return shown_.has_value(); }
  void draw(const UiInput& input, bool frozen);
  void leave() { shown_.reset(); }

 private:
  std::optional<Universe> shown_;
  bool fresh_ = true;
  SlotChanges changes_;
};

}  // namespace footlight::tools
