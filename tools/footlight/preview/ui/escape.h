// What Esc closes.
#pragma once

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

// Closes the menu, list or popup that was opened last; without one, the list of keys; without that, selects nothing.
// False: nothing of this was there. After the panels of this picture are drawn.
[[nodiscard]] bool close_topmost(UiPanels& open, UiDesk& desk);

}  // namespace footlight::tools
