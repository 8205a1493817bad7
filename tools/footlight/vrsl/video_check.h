// 'footlight vrsl check' for videos.
#pragma once

#include <string>

#include "sim/core/result.h"

namespace footlight::tools {

// Reads the whole video and prints what it is, its grid, the confidence of its universes and how many pictures were
// damaged. `format`: as for open_video_log(). Returns the exit code: 0 if every picture was used, 1 if some were left
// out. kBadInput if no picture has a grid.
[[nodiscard]] Result<int> check_video(const std::string& path, const std::string& format, bool json);

}  // namespace footlight::tools
