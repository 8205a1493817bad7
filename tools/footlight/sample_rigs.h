// Rigs of `footlight samples` with light that is no fixture's, and their images. Each function writes one file.
#pragma once

#include <string>

#include "sim/core/result.h"

namespace footlight::tools {

// A chapel with stained glass in the sun, and the glass.
[[nodiscard]] Status write_chapel_rig(const std::string& path);
[[nodiscard]] Status write_glass_image(const std::string& path);
// A stage with LED walls, and the image that they show.
[[nodiscard]] Status write_wall_rig(const std::string& path);
[[nodiscard]] Status write_wall_image(const std::string& path);

}  // namespace footlight::tools
