// The wheels of the selected fixture in the inspector: a button for each slot, with its gobo or its colour, that takes
// the channel over. Dear ImGui only.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/wheel_slots.h"

namespace footlight::tools {

class InspectorWheels {
 public:
  // Of the fixture that was selected last; buttons set all selected ones. Nothing where it has no wheel.
  void draw(UiDesk& desk, const UiInput& input, int lead);

 private:
  std::vector<WheelChoice> choices_;
  int lead_ = -1;  // of choices_, as of shown_count_
  std::uint64_t shown_count_ = 0;
};

}  // namespace footlight::tools
