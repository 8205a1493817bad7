// The subcommands of `footlight rig` with files of their own.
#pragma once

#include <string>
#include <vector>

#include "fixtures/files/import/import_rig.h"
#include "sim/core/result.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

void add_rig_edit(Arguments& arguments);

// Reads a rig, with its progress and its number of warnings on standard error. `library`: folders to search in, empty:
// the installed libraries.
[[nodiscard]] Result<fixtures::ImportedRig> open_rig(const std::string& path, const std::vector<std::string>& library);

}  // namespace footlight::tools
