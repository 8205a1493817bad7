// Finds the running bridge or window for a command without --socket.
#pragma once

#include <string>
#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

// The socket of the only bridge that answers on this machine; without a bridge, that of the only window of 'footlight
// preview' (with_windows). So a window that is opened beside a bridge takes no commands away from it. kNotFound if
// there is none; the message ends with `otherwise`. kBadInput if there are several; the message lists them as
// 'footlight COMMAND --socket FILE'.
[[nodiscard]] Result<std::string> find_bridge(std::string_view command, std::string_view otherwise = {},
                                              bool with_windows = true);

}  // namespace footlight::tools
