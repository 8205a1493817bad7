// What the tip of a slot says: its level, what it is for, who sets it, and how old that is. No Dear ImGui.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/footlight/monitor/slot_changes.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

struct SlotTip {
  std::string level;               // "1.17  level 128 (50 %)"
  std::vector<std::string> means;  // "Spot 1: Pan, byte 1 of 2: -32.5°", one a use; empty: nothing uses it
  std::string from;                // "console (priority 100)  44 /s", "taken over in this window"
  std::string ages;                // "last frame 0.1 s ago, changed 2.3 s ago"; may be empty
};

// changes: the levels that are shown, which may be frozen or kept from before; then the tip has no values in real
// units. now_ns: of them. universe: counts in CompiledRig::universes.
[[nodiscard]] SlotTip tip_of_slot(UiDesk& desk, const UiInput& input, std::size_t universe, std::size_t slot,
                                  const SlotChanges& changes, TimeNs now_ns);

}  // namespace footlight::tools
