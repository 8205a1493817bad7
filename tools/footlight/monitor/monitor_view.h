// The display of the monitor: turns a state into lines of text. A pure function; keys are in monitor.cpp, terminal
// output in terminal.h.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/footlight/monitor/level_moment.h"
#include "tools/footlight/monitor/monitor_state.h"

namespace footlight::tools {

// The levels of all universes at a moment that the user kept, to compare them.
struct MonitorMoment {
  LevelMoment levels;
  TimeNs at_ns = 0;  // MonitorState::now_ns of it
};
// Of now. A universe without a frame so far is not in it.
[[nodiscard]] MonitorMoment keep_moment(const MonitorState& state);

struct MonitorView {
  int columns = 80;
  int rows = 24;
  Universe selected = 0;  // shown in full; the first one if it does not exist
  std::string filter;     // "1-9": those universes; other text: universes with a sender of such a name
  bool typing = false;    // the filter is being typed
  bool paused = false;
  bool colour = false;  // true: SGR sequences; false: plain text
  // The slot of the selected universe that is explained, while there is a rig: 0 to 511.
  bool explains = false;
  int slot = 0;
  std::string meaning;  // of it; empty: nothing uses it
  // Two moments that are compared; b: nothing: now. Without a nothing is compared.
  std::optional<MonitorMoment> a;
  std::optional<MonitorMoment> b;
};

// The universe that is shown in full; nullptr: there is none.
[[nodiscard]] const MonitorUniverse* shown_universe(const MonitorState& state, const MonitorView& view);
// Universes that pass the filter, ascending.
[[nodiscard]] std::vector<Universe> shown_universes(const MonitorState& state, std::string_view filter);

// Exactly view.rows lines of at most view.columns columns, without line ends. Any size from 1 x 1.
[[nodiscard]] std::vector<std::string> draw_monitor(const MonitorState& state, const MonitorView& view);

// The width of a printable text on a terminal, and its longest prefix that fits into a number of columns. A text that
// was cut ends in "…".
[[nodiscard]] int columns_of(std::string_view text);
[[nodiscard]] std::string cut_to(std::string_view text, int columns);

}  // namespace footlight::tools
