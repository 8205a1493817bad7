#include "tools/footlight/pictures/picture_file.h"

#include <utility>

#include "fixtures/gobos/png.h"

namespace footlight::tools {

Status write_png(const std::string& path, const render::ScreenImage& image, const std::string& settings) {
  fixtures::Bytes png = fixtures::png_of(image.width, image.height, 4, image.rgba);
  if (png.empty()) return fail(ErrorCode::kIo, "{}: no memory for the picture; choose a smaller --size", path);
  if (!settings.empty()) png = fixtures::with_png_text(std::move(png), kSettingsKeyword, settings);
  return write_picture(path, png);
}

}  // namespace footlight::tools
