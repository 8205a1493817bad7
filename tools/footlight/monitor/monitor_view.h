// The picture of the monitor: a state becomes lines of text. A pure function; what is typed is in monitor.cpp, how it
// gets to the terminal in terminal.h.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/footlight/monitor/monitor_state.h"

namespace footlight::tools {

struct MonitorView {
  int columns = 80;
  int rows = 24;
  Universe selected = 0;  // shown in full; the first one where there is no such universe
  std::string filter;     // "1-9": those universes; other words: those with a sender of such a name
  bool typing = false;    // the filter is being typed
  bool paused = false;
  bool colour = false;  // SGR sequences; without, nothing but text
};

// Universes that the filter lets through, ascending.
[[nodiscard]] std::vector<Universe> shown_universes(const MonitorState& state, std::string_view filter);

// Just view.rows lines of at most view.columns columns each, without line ends. Any size, from 1 x 1 on.
[[nodiscard]] std::vector<std::string> draw_monitor(const MonitorState& state, const MonitorView& view);

// How many columns a printable text takes on a terminal, and its longest begin that fits into so many. A text that was
// cut ends in "…".
[[nodiscard]] int columns_of(std::string_view text);
[[nodiscard]] std::string cut_to(std::string_view text, int columns);

}  // namespace footlight::tools
