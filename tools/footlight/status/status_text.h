// The status of a pump as text.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sim/core/dmx.h"
#include "sim/pump.h"

namespace footlight::tools {

// One line: each port with its rate over the last second, and its errors.
[[nodiscard]] std::string status_line(const PumpStatus& status);
// Several lines with line ends: one for each port, over the whole run.
[[nodiscard]] std::string summary_text(const PumpStatus& status, DurationNs elapsed_ns);

// "1-9", "1-3,7": ascending numbers.
[[nodiscard]] std::string show_universes(std::span<const Universe> universes);
[[nodiscard]] const char* name_of(PortState state);

}  // namespace footlight::tools
