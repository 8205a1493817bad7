// Replaces vrsl_window.cpp in a build without GLFW.
#include "tools/footlight/vrsl/vrsl_window.h"

namespace footlight::tools {

Result<std::unique_ptr<drivers::PictureOutput>> open_window_output(const drivers::PictureTarget& target) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no windows; install libglfw3-dev and libgl-dev and build again, or use a pipe or a "
              "device: vrsl:1-9@/dev/video9",
              target.endpoint);
}

}  // namespace footlight::tools
