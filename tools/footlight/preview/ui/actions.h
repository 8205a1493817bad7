// Every action of keys and menus with what a list shows of it, from the tables that handle them (keys.h, panels.h).
#pragma once

#include <string>
#include <vector>

#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/outputs_view.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {

// "undo: set Pan of Spot 3"
[[nodiscard]] std::string label_of(const KeyRow& row, const UiDesk& desk);
// Why it would do nothing now, and what to do about that; empty: it would do something. has_log: a log plays. outputs:
// null without any.
[[nodiscard]] std::string why_not(const UiCall& call, const UiDesk& desk, bool has_log, const OutputsView* outputs);

struct UiActionItem {
  UiCall call;
  std::string label;
  std::string keys;     // empty: none
  std::string why_not;  // of why_not()
  [[nodiscard]] bool possible() const { return why_not.empty(); }
};
// In the order of the tables; a camera each, also without a key.
[[nodiscard]] std::vector<UiActionItem> action_items(const UiDesk& desk, bool has_log, const OutputsView* outputs);

}  // namespace footlight::tools
