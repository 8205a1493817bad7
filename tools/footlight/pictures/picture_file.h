// Pictures as files.
#pragma once

#include <string>

#include "render/image.h"
#include "sim/core/result.h"
#include "tools/footlight/pictures/numbered_file.h"

namespace footlight::tools {

// The keyword of the text in a PNG that states how it was computed, and the attribute of an OpenEXR file.
inline constexpr const char* kSettingsKeyword = "footlight/settings";
// settings: ASCII, for kSettingsKeyword; empty: none.
Status write_png(const std::string& path, const render::ScreenImage& image, const std::string& settings = {});

}  // namespace footlight::tools
