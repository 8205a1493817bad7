// What `footlight preview` was asked for. The window itself is in preview_window.cpp; a build without GLFW or Dear
// ImGui has no_preview_window.cpp in its place.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "tools/footlight/pictures/flash_mode.h"
#include "tools/footlight/pictures/scene_files.h"

namespace footlight::tools {

struct PreviewOptions {
  SceneFiles files;
  std::vector<std::string> ins;  // endpoints; with any, no log drives the rig
  std::string size = "1280x720";
  std::string camera;
  std::string device;
  std::string screenshot;               // PNG of the last frame; empty: none
  DurationNs at_ns = 0;                 // where in the log to begin
  double seconds = 0;                   // closes by itself after this time; 0: stays open
  std::optional<double> work_light_lx;  // else work_light_lx() where the rig is driven by hand, else 0
  int nodes = 3;
  FlashMode flashes = FlashMode::kWarn;
  bool json = false;
};

// Opens the window and returns an ExitCode when it is closed.
[[nodiscard]] Result<int> run_preview(const PreviewOptions& options);

}  // namespace footlight::tools
