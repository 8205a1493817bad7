// Pictures as files.
#pragma once

#include <string>

#include "render/image.h"
#include "sim/core/result.h"

namespace footlight::tools {

// Writes a PNG under a temporary name beside `path`, then gives it its name: no half-written picture is ever seen.
Status write_png(const std::string& path, const render::ScreenImage& image);

// Whether `path` has exactly one printf place for a number ("frame_%04d.png"), and the name with that number.
[[nodiscard]] bool is_numbered(const std::string& path);
[[nodiscard]] Result<std::string> numbered_path(const std::string& path, int number);

}  // namespace footlight::tools
