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

// Makes text printable: valid UTF-8, with control characters replaced by U+FFFD. Names come from the network; an escape
// sequence in one must not reach a terminal.
[[nodiscard]] std::string printable_utf8(std::string_view text);
// The same for one line. Of a line beyond 1,900 bytes it keeps the beginning and the end, with "[...]" between. A file
// may contain names of 100 kB.
[[nodiscard]] std::string printable_line(std::string_view text);
// The same for several lines, with their line ends.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace footlight::tools
