// Actions of keys, menus and the list of actions that need no window: what they do to the desk. No Dear ImGui.
#pragma once

#include <optional>
#include <string>

#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {

struct ActionNews {
  std::string text;  // empty: what it did is seen
  bool wrong = false;
};
// Runs an action that is possible (why_not() of actions.h). Nothing: it belongs to the window.
[[nodiscard]] std::optional<ActionNews> run_on_desk(UiDesk& desk, const UiCall& call);

}  // namespace footlight::tools
