// The menu of the side panel, from the tables of keys and panels.
#pragma once

#include <optional>

#include "tools/footlight/mvr/exchange_view.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

// Between the begin and end of a menu bar. What was chosen. has_log: there is something to play. outputs: nullptr if
// there are none. exchange: rigs over the network; its second part may be changed; nullptr if there are none.
[[nodiscard]] std::optional<UiCall> draw_menu(const UiDesk& desk, const UiPanels& open, bool has_log,
                                              const OutputsView* outputs, ExchangeView* exchange = nullptr);

}  // namespace footlight::tools
