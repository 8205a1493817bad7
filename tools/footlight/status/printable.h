// Text of others, such as names from files and the network, made printable.
#pragma once

#include <string>
#include <string_view>

namespace footlight::tools {

// Makes text printable: valid UTF-8, with control characters replaced by U+FFFD. Names come from the network; an escape
// sequence in one must not reach a terminal.
[[nodiscard]] std::string printable_utf8(std::string_view text);
// The same for one line. Of a line beyond 1,900 bytes it keeps the beginning and the end, with "[...]" between. A file
// may contain names of 100 kB.
[[nodiscard]] std::string printable_line(std::string_view text);
// The same for several lines, with their line ends.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace footlight::tools
