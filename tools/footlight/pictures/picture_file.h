// Pictures as files.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "render/image.h"
#include "sim/core/result.h"

namespace footlight::tools {

// Writes the bytes as `path`.part and renames that file: there is never a half-written picture. kIo with the reason
// where the folder is missing or the disk is full; then `path` is as it was.
Status write_picture(const std::string& path, std::span<const std::byte> bytes);
// The keyword of the text in a PNG that states how it was computed, and the attribute of an OpenEXR file.
inline constexpr const char* kSettingsKeyword = "footlight/settings";
// settings: ASCII, for kSettingsKeyword; empty: none.
Status write_png(const std::string& path, const render::ScreenImage& image, const std::string& settings = {});

// Checks for exactly one printf placeholder for a number in `path` ("frame_%04d.png"); returns the name with that
// number.
[[nodiscard]] bool is_numbered(const std::string& path);
[[nodiscard]] Result<std::string> numbered_path(const std::string& path, int number);

}  // namespace footlight::tools
