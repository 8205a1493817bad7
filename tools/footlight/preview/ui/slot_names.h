// What a slot is for, in words: fixtures with their channels, and pixels of displays.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "tools/footlight/preview/ui/rig_index.h"

namespace footlight::tools {

struct SlotName {
  std::string fixture;    // empty: a display, which is named in `parameter`
  std::string parameter;  // "Pan, byte 1 of 2"
  int index = -1;         // of the fixture in the rig; -1: a display
};

// In the order of the rig; empty: nothing uses the slot. universe: counts in CompiledRig::universes.
[[nodiscard]] std::vector<SlotName> names_of_slot(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                                  const RigIndex& index, std::size_t universe, std::size_t slot);
// "Spot 1: Pan | Spot 2: Pan"; empty: nothing uses the slot.
[[nodiscard]] std::string text_of(const std::vector<SlotName>& names);

}  // namespace footlight::tools
