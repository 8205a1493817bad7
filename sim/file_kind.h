// Checks of a path before its file is opened. Opening a pipe blocks, and renaming onto a device or a file replaces it.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "sim/core/result.h"

namespace footlight {

// Follows links.
[[nodiscard]] inline bool is_pipe_or_device(const std::string& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return std::filesystem::is_other(status);
}

// For a file that will be read. Passes if the path does not exist: opening it then gives the reason.
[[nodiscard]] inline Status refuse_pipe_input(const std::string& path) {
  if (!is_pipe_or_device(path)) return {};
  return fail(ErrorCode::kBadInput, "{}: is a pipe or a device; expected a file", path);
}

// For a file that will be written and then renamed to `path`.
[[nodiscard]] inline Status refuse_pipe_output(const std::string& path) {
  if (!is_pipe_or_device(path)) return {};
  return fail(ErrorCode::kBadInput, "{}: is a pipe or a device; expected a name for a file", path);
}

// For a file or a folder that will be written.
[[nodiscard]] inline Status refuse_existing(const std::string& path, bool overwrite) {
  std::error_code ignored;
  if (overwrite || !std::filesystem::exists(path, ignored)) return {};
  return fail(ErrorCode::kBadInput, "{}: exists; choose another name or allow overwriting", path);
}

}  // namespace footlight
