// Where the levels that fixtures get come from, in words. No Dear ImGui.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

enum class SourceKind {
  kTaken,      // the user took the channel over
  kHighlight,  // Highlight or Locate
  kLog,
  kFaders,  // of the window
  kNobody,  // a live universe without a frame so far
  kLive,
  kMadeUp,  // pixels or others without an address
};

struct LevelSource {
  SourceKind kind = SourceKind::kFaders;
  std::string brief;      // "console", for a column
  std::string words;      // "console (priority 100), 1 outranked  44 /s", for a line
  bool silent = false;    // of kLive: for kSilentNs or longer
  bool rarely = false;    // of kLive: set by hand, which is sent when it changes
  DurationNs age_ns = 0;  // of kLive: of the newest frame
};

// Of a universe, by its index in CompiledRig::universes. Several senders may win, each some slots: with a slot, from 0,
// only those that have set it.
[[nodiscard]] LevelSource source_of_universe(const UiDesk& desk, const UiInput& input, std::size_t universe,
                                             std::optional<std::size_t> slot = std::nullopt);
// Whether an input that sends all the time has sent nothing for kSilentNs or longer, though its port works.
[[nodiscard]] bool is_silent(const PortStatus& port, const PumpStatus& status);
// Of a channel.
[[nodiscard]] LevelSource source_of_channel(UiDesk& desk, const UiInput& input, ChannelKey key);

}  // namespace footlight::tools
