// What a pump did, for people.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sim/core/dmx.h"
#include "sim/pump.h"

namespace footlight::tools {

// One line: each port with its rate over the last second, and what went wrong.
[[nodiscard]] std::string status_line(const PumpStatus& status);
// Some lines with ends: one for each port, over the whole run.
[[nodiscard]] std::string summary_text(const PumpStatus& status, DurationNs elapsed_ns);

// "1-9", "1-3,7": ascending numbers.
[[nodiscard]] std::string show_universes(std::span<const Universe> universes);
[[nodiscard]] const char* name_of(PortState state);

// What may be shown to people and programs: valid UTF-8 without control characters, which become U+FFFD. Names come
// from the wire; one that holds an escape sequence must not drive a terminal.
[[nodiscard]] std::string printable_utf8(std::string_view text);
// The same of a line for people: of one beyond 1,900 bytes the begin and the end, with "[...]" between them. A file may
// hold names of 100 kB.
[[nodiscard]] std::string printable_line(std::string_view text);
// The same of many lines: their ends stay.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace footlight::tools
