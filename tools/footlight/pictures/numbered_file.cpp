#include "tools/footlight/pictures/numbered_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "sim/file_kind.h"

namespace footlight::tools {

Status write_picture(const std::string& path, std::span<const std::byte> bytes) {
  FL_TRY(refuse_pipe_output(path));
  const std::string part = path + ".part";
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (file == nullptr) {
    return fail(ErrorCode::kIo, "{}: cannot be written ({}); choose an existing folder with write permission", path,
                std::strerror(errno));
  }
  errno = 0;
  bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() && std::fflush(file) == 0;
  int reason = written ? 0 : errno;  // of the write: closing and removing may change it
  if (std::fclose(file) != 0 && written) {
    written = false;
    reason = errno;
  }
  if (!written) {
    std::remove(part.c_str());
    return fail(ErrorCode::kIo, "{}: writing failed ({}); is the disk full?", path, std::strerror(reason));
  }
  std::error_code trouble;
  std::filesystem::rename(part, path, trouble);
  if (trouble) return fail(ErrorCode::kIo, "{}: cannot be renamed from {}: {}", path, part, trouble.message());
  return {};
}

namespace {

// Finds %d, %4d or %04d; `at` is npos if there is none or more than one.
struct Place {
  std::size_t at = std::string::npos;
  std::size_t length = 0;
  int width = 0;
};

Place find_place(const std::string& path) {
  Place place;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] != '%') continue;
    std::size_t j = i + 1;
    int width = 0;
    while (j < path.size() && path[j] >= '0' && path[j] <= '9' && width < 100) width = width * 10 + (path[j++] - '0');
    if (j >= path.size() || path[j] != 'd' || place.length > 0) return {};
    place = {i, j + 1 - i, width};
    i = j;
  }
  return place;
}

}  // namespace

bool is_numbered(const std::string& path) { return find_place(path).length > 0; }

Result<std::string> numbered_path(const std::string& path, int number) {
  const Place place = find_place(path);
  if (place.length == 0) {
    return fail(ErrorCode::kBadInput, "{}: expected one placeholder for the picture's number, such as frame_%04d.png",
                path);
  }
  return path.substr(0, place.at) + fmt::format("{:0{}d}", number, place.width) + path.substr(place.at + place.length);
}

}  // namespace footlight::tools
