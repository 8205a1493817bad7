// Finds the running bridge for a command without --socket.
#pragma once

#include <string>
#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

// The socket of the only bridge that answers on this machine. kNotFound if there is none; the message ends with
// `otherwise`. kBadInput if there are several; the message lists them as 'footlight COMMAND --socket FILE'.
[[nodiscard]] Result<std::string> find_bridge(std::string_view command, std::string_view otherwise = {});

}  // namespace footlight::tools
