#include "tools/footlight/vrsl/png_pictures.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include "fixtures/files/import/text.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/gobos/png.h"
#include "sim/file_kind.h"
#include "tools/footlight/pictures/numbered_file.h"

namespace footlight::tools {
namespace {

constexpr std::uintmax_t kPictureBytesMax = 64u << 20;
constexpr int kNumberMax = 9'999'999;

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

class PngOutput final : public drivers::PictureOutput {
 public:
  PngOutput(std::string path, bool numbered, bool overwrite)
      : path_(std::move(path)), numbered_(numbered), overwrite_(overwrite) {}

  Status show(const drivers::Picture& picture, DurationNs /*time_ns*/) override {
    if (!numbered_) return write_picture_file(path_, picture.view());
    if (number_ > kNumberMax) return fail(ErrorCode::kIo, "{}: more than {} pictures", path_, kNumberMax);
    FL_ASSIGN(const std::string path, numbered_path(path_, number_));
    if (!overwrite_ && exists(path)) {
      return fail(ErrorCode::kIo, "{} exists; choose another name, or add ?overwrite=yes", path);
    }
    FL_TRY(write_picture_file(path, picture.view()));
    ++number_;
    return {};
  }

 private:
  const std::string path_;
  const bool numbered_;
  const bool overwrite_;
  int number_ = 0;
};

class NumberedInput final : public drivers::PictureInput {
 public:
  NumberedInput(std::string path, int first, double pictures_hz)
      : path_(std::move(path)), first_(first), number_(first), pictures_hz_(pictures_hz) {}

  Result<drivers::PictureStep> next(drivers::Picture& picture, std::optional<DurationNs>& time_ns,
                                    DurationNs /*wait_ns*/) override {
    FL_ASSIGN(const std::string path, numbered_path(path_, number_));
    if (!exists(path)) return drivers::PictureStep::kEnd;
    time_ns = std::llround((number_ - first_) * 1e9 / pictures_hz_);
    ++number_;
    FL_TRY(read_picture_file(path, picture));
    return drivers::PictureStep::kPicture;
  }

 private:
  const std::string path_;
  const int first_;
  int number_;
  const double pictures_hz_;
};

class StillInput final : public drivers::PictureInput {
 public:
  StillInput(std::string path, double pictures_hz) : path_(std::move(path)), pictures_hz_(pictures_hz) {}

  Result<drivers::PictureStep> next(drivers::Picture& picture, std::optional<DurationNs>& time_ns,
                                    DurationNs /*wait_ns*/) override {
    std::error_code trouble;
    const auto changed = std::filesystem::last_write_time(path_, trouble);
    if (trouble) return fail(ErrorCode::kIo, "{}: {}", path_, trouble.message());
    time_ns = std::llround(static_cast<double>(count_++) * 1e9 / pictures_hz_);
    if (changed_ != changed) {
      const Status read = read_picture_file(path_, picture);
      if (!read) return tl::unexpected(Error{ErrorCode::kIo, read.error().message});
      changed_ = changed;
    }
    return drivers::PictureStep::kPicture;
  }

 private:
  const std::string path_;
  const double pictures_hz_;
  std::int64_t count_ = 0;
  std::optional<std::filesystem::file_time_type> changed_;
};

}  // namespace

bool is_picture_file(std::string_view name) {
  const std::string end = fixtures::lower(name);
  return end.ends_with(".png") || end.ends_with(".jpg") || end.ends_with(".jpeg");
}

Status read_picture_file(const std::string& path, drivers::Picture& picture) {
  FL_TRY(refuse_pipe_input(path));
  std::error_code trouble;
  const std::uintmax_t size = std::filesystem::file_size(path, trouble);
  std::ifstream file(path, std::ios::binary);
  if (trouble || !file) {
    const int reason = trouble ? trouble.value() : errno;
    const ErrorCode code = reason == ENOENT   ? ErrorCode::kNotFound
                           : reason == EACCES ? ErrorCode::kPermission
                                              : ErrorCode::kIo;
    return fail(code, "{}: {}", path, std::strerror(reason));
  }
  if (size > kPictureBytesMax) {
    return fail(ErrorCode::kProtocol, "{}: {} bytes; expected a picture of at most {}", path, size, kPictureBytesMax);
  }
  fixtures::Bytes bytes(static_cast<std::size_t>(size));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (file.gcount() != static_cast<std::streamsize>(bytes.size())) {
    return fail(ErrorCode::kIo, "{}: cannot be read to its end", path);
  }
  auto image = fixtures::rgb_of_file(bytes, path);
  if (!image) return fail(ErrorCode::kProtocol, "{}", image.error().message);
  picture.width = image->width;
  picture.height = image->height;
  picture.rgb = std::move(image->rgb);
  return {};
}

Status write_picture_file(const std::string& path, const drivers::PictureView& picture) {
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(picture.width);
  std::span<const std::uint8_t> pixels(picture.pixels, row_bytes * static_cast<std::size_t>(picture.height));
  std::vector<std::uint8_t> packed;
  if (picture.stride_bytes != row_bytes) {
    for (int y = 0; y < picture.height; ++y) packed.insert(packed.end(), picture.row(y), picture.row(y) + row_bytes);
    pixels = packed;
  }
  const fixtures::Bytes png = fixtures::png_of(picture.width, picture.height, 3, pixels);
  if (png.empty()) return fail(ErrorCode::kIo, "{}: no memory for the picture", path);
  return write_picture(path, png);
}

Result<std::unique_ptr<drivers::PictureOutput>> open_png_output(const drivers::PictureTarget& target) {
  if (!target.options.empty()) return drivers::unused_option(target, target.options.front().key);
  if (!fixtures::lower(target.name).ends_with(".png")) {
    return fail(ErrorCode::kBadInput, "{}: JPEG changes levels; expected a name such as frame_%05d.png",
                target.endpoint);
  }
  const bool numbered = is_numbered(target.name);
  std::string first = target.name;
  if (numbered) {
    FL_ASSIGN(first, numbered_path(target.name, 0));
  } else if (target.name.find('%') != std::string::npos) {
    return fail(ErrorCode::kBadInput, "{}: expected one placeholder for the picture's number, such as frame_%05d.png",
                target.endpoint);
  }
  if (!target.overwrite && exists(first)) {
    return fail(ErrorCode::kBadInput, "{}: {} exists; choose another name, or add ?overwrite=yes", target.endpoint,
                first);
  }
  const std::filesystem::path folder = std::filesystem::path(first).parent_path();
  if (!folder.empty() && !exists(folder.string())) {
    return fail(ErrorCode::kNotFound, "{}: the folder {} does not exist; create it first", target.endpoint,
                folder.string());
  }
  return std::make_unique<PngOutput>(target.name, numbered, target.overwrite);
}

Result<std::unique_ptr<drivers::PictureInput>> open_picture_files(const drivers::PictureTarget& target) {
  if (!target.options.empty()) return drivers::unused_option(target, target.options.front().key);
  if (!is_numbered(target.name)) {
    if (!exists(target.name)) {
      return fail(ErrorCode::kNotFound, "{}: {} does not exist", target.endpoint, target.name);
    }
    return std::make_unique<StillInput>(target.name, target.pictures_hz);
  }
  constexpr int kFirstMax = 100'000;
  for (int number = 0; number <= kFirstMax; ++number) {
    FL_ASSIGN(const std::string path, numbered_path(target.name, number));
    if (exists(path)) return std::make_unique<NumberedInput>(target.name, number, target.pictures_hz);
  }
  return fail(ErrorCode::kNotFound, "{}: there is no picture with a number from 0 to {}", target.endpoint, kFirstMax);
}

}  // namespace footlight::tools
