// Which running bridge a command means that names none.
#pragma once

#include <string>
#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

// The socket of the one bridge that answers on this machine. kNotFound where there is none, whose message ends with
// `otherwise`; kBadInput where there are several, which lists them as 'footlight COMMAND --socket FILE'.
[[nodiscard]] Result<std::string> find_bridge(std::string_view command, std::string_view otherwise = {});

}  // namespace footlight::tools
