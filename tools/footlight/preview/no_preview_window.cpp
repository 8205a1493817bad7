// Replaces preview_window.cpp if GLFW or Dear ImGui is missing.
#include "tools/footlight/preview/preview.h"

namespace footlight::tools {

Result<int> run_preview(const PreviewOptions&) {
  return fail(ErrorCode::kUnsupported,
              "this build has no window: 'sudo apt-get install libglfw3-dev libimgui-dev', then configure with "
              "-DFOOTLIGHT_WINDOW=ON and build again; 'footlight render' makes pictures without a window");
}

}  // namespace footlight::tools
