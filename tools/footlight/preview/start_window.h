// The window of `footlight preview` without a rig.
#pragma once

#include <optional>

#include "tools/footlight/preview/preview.h"

namespace footlight::tools {

// True if no rig is asked for.
[[nodiscard]] bool needs_start(const PreviewOptions& options);

struct StartEnd {
  std::optional<PreviewOptions> options;  // with the rig that the user chose; nothing: the window was closed
  double seconds = 0;                     // that it was open
};
// Shows the start screen until the user has chosen, or closes the window. Main thread. Errors: those of Window.
[[nodiscard]] Result<StartEnd> run_start_window(const PreviewOptions& options);

}  // namespace footlight::tools
