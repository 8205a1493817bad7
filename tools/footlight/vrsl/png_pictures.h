// Pictures as files: PNG out; PNG and JPEG in.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "drivers/vrsl/picture_port.h"
#include "sim/core/result.h"

namespace footlight::tools {

// True for names that end in .png, .jpg or .jpeg.
[[nodiscard]] bool is_picture_file(std::string_view name);

// kNotFound, kPermission or kIo if the file cannot be read; kProtocol if it is no PNG or JPEG, or damaged.
Status read_picture_file(const std::string& path, drivers::Picture& picture);
// Writes `path`.part and renames it: a reader never sees half a picture.
Status write_picture_file(const std::string& path, const drivers::PictureView& picture);

// "frame_%05d.png": a file for each picture, numbered from 0. "show.png": the newest picture, replaced each time.
// kBadInput if the first file exists and target.overwrite is false.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_png_output(const drivers::PictureTarget& target);

// "frame_%05d.png": the files from the lowest number on, target.pictures_hz a second; it ends with the first number
// that is missing. "show.png": one picture, over and over, read again whenever the file has changed.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_picture_files(const drivers::PictureTarget& target);

}  // namespace footlight::tools
