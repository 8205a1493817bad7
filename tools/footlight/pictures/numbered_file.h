// Files that are written whole, and names with a number in them.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "sim/core/result.h"

namespace footlight::tools {

// Writes the bytes as `path`.part and renames that file: there is never a half-written picture. kIo with the reason
// where the folder is missing or the disk is full; then `path` is as it was.
Status write_picture(const std::string& path, std::span<const std::byte> bytes);
// Checks for exactly one printf placeholder for a number in `path` ("frame_%04d.png"); returns the name with that
// number.
[[nodiscard]] bool is_numbered(const std::string& path);
[[nodiscard]] Result<std::string> numbered_path(const std::string& path, int number);

}  // namespace footlight::tools
