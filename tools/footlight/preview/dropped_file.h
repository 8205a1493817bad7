// What a file is that was dropped on the window: by its content, and by its name where that does not tell. Knows no
// window.
#pragma once

#include <string>
#include <vector>

#include "sim/core/result.h"

namespace footlight::tools {

enum class DroppedKind {
  kDefinition,  // of a fixture: GDTF, QXF, Open Fixture Library, Footlight's own
  kRig,         // MVR, QLC+, VRSL, Footlight's own
  kLog,         // .dmxlog, or a capture
};
// Reads the head of the file; of a TOML file all of it. Errors name the file and what can be dropped.
[[nodiscard]] Result<DroppedKind> kind_of_dropped(const std::string& path);

// What files do that were dropped together.
struct DroppedFiles {
  std::vector<std::string> definitions;
  std::string rig;             // the last one; empty: none
  std::string log;             // the last one; empty: none
  std::vector<Error> refused;  // those that are nothing, and rigs and logs that another one of the drop replaces
};
[[nodiscard]] DroppedFiles sort_dropped(const std::vector<std::string>& paths);

}  // namespace footlight::tools
