#include "drivers/capture/sigrok_file.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <zip.h>

#include "sim/file_kind.h"

namespace footlight::drivers {
namespace {

struct ArchiveCloser {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct FileCloser {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using Archive = std::unique_ptr<zip_t, ArchiveCloser>;
using File = std::unique_ptr<zip_file_t, FileCloser>;

constexpr std::size_t kPieceBytes = 64u << 10;

std::string text_of(zip_error_t error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

// Reads a whole small entry.
Result<std::string> read_text(zip_t* archive, const char* name, std::size_t bytes_max, const std::string& path) {
  const File file(zip_fopen(archive, name, 0));
  if (!file) {
    return fail(ErrorCode::kBadInput, "{}: a zip without '{}'; expected a capture written by sigrok or PulseView", path,
                name);
  }
  std::string text(bytes_max + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const zip_int64_t got = zip_fread(file.get(), text.data() + size, text.size() - size);
    if (got < 0) return fail(ErrorCode::kBadInput, "{}: '{}' in it is damaged", path, name);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > bytes_max) {
    return fail(ErrorCode::kBadInput, "{}: '{}' in it is longer than {} bytes", path, name, bytes_max);
  }
  text.resize(size);
  return text;
}

}  // namespace

struct SigrokFile::Impl {
  Impl(Archive archive_in, std::string path_in) : archive(std::move(archive_in)), path(std::move(path_in)) {}

  Status open() {
    FL_ASSIGN(const std::string text, read_text(archive.get(), "metadata", kSigrokMetadataBytesMax, path));
    FL_ASSIGN(metadata, parse_sigrok_metadata(text, path));
    if (find(metadata.capture_file) < 0 && find(metadata.capture_file + "-1") < 0) {
      return fail(ErrorCode::kBadInput, "{}: the samples are missing: neither '{}' nor '{}-1' is in it", path,
                  metadata.capture_file, metadata.capture_file);
    }
    buffer.resize(kPieceBytes);
    return {};
  }

  [[nodiscard]] zip_int64_t find(const std::string& name) const {
    return zip_name_locate(archive.get(), name.c_str(), 0);
  }

  // Opens the file with the next samples; false if there is none.
  bool open_next() {
    std::string name = metadata.capture_file;
    if (find(name) >= 0) {
      if (chunk > 0) return false;
    } else {
      name += "-" + std::to_string(chunk + 1);
      if (find(name) < 0) return false;
    }
    ++chunk;
    file.reset(zip_fopen(archive.get(), name.c_str(), 0));
    if (!file) trouble = "'" + name + "' in it cannot be read: " + zip_strerror(archive.get());
    return file != nullptr;
  }

  std::span<const std::uint8_t> read() {
    // A sample may be divided by the end of a chunk or of a file.
    std::size_t size = std::exchange(left_over, 0);
    std::memmove(buffer.data(), buffer.data() + left_over_at, size);
    while (size < metadata.unit_size && trouble.empty()) {
      if (!file && !open_next()) break;
      if (bytes_read >= kSigrokSampleBytesMax) {
        trouble = "more than 16 GiB of samples; the rest is not read";
        break;
      }
      const zip_int64_t got = zip_fread(file.get(), buffer.data() + size, buffer.size() - size);
      if (got < 0) {
        trouble = "the samples are damaged";
      } else if (got == 0) {
        file.reset();
      } else {
        size += static_cast<std::size_t>(got);
        bytes_read += static_cast<std::uint64_t>(got);
      }
    }
    left_over = size % metadata.unit_size;
    left_over_at = size - left_over;
    return std::span(buffer).first(left_over_at);
  }

  void rewind() {
    file.reset();
    chunk = 0;
    bytes_read = 0;
    left_over = left_over_at = 0;
    trouble.clear();
  }

  Archive archive;
  std::string path;
  SigrokMetadata metadata;
  File file;
  int chunk = 0;  // number of sample files opened
  std::uint64_t bytes_read = 0;
  std::vector<std::uint8_t> buffer;
  std::size_t left_over = 0;
  std::size_t left_over_at = 0;
  std::string trouble;
};

SigrokFile::SigrokFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SigrokFile::SigrokFile(SigrokFile&&) noexcept = default;
SigrokFile::~SigrokFile() = default;

Result<SigrokFile> SigrokFile::open(const std::string& path) {
  FL_TRY(refuse_pipe_input(path));
  int code = 0;
  Archive archive(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (!archive) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    return fail(ErrorCode::kBadInput, "{}: not a sigrok capture: {}", path, text_of(error));
  }
  auto impl = std::make_unique<Impl>(std::move(archive), path);
  FL_TRY(impl->open());
  return SigrokFile(std::move(impl));
}

Result<SigrokFile> SigrokFile::open_bytes(std::span<const std::uint8_t> bytes, const std::string& name) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  Archive archive(source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY, &error));
  if (!archive) {
    if (source != nullptr) zip_source_free(source);
    return fail(ErrorCode::kBadInput, "{}: not a sigrok capture: {}", name, text_of(error));
  }
  zip_error_fini(&error);
  auto impl = std::make_unique<Impl>(std::move(archive), name);
  FL_TRY(impl->open());
  return SigrokFile(std::move(impl));
}

const SigrokMetadata& SigrokFile::metadata() const { return impl_->metadata; }
std::span<const std::uint8_t> SigrokFile::read() { return impl_->read(); }
void SigrokFile::rewind() { impl_->rewind(); }
const std::string& SigrokFile::trouble() const { return impl_->trouble; }

}  // namespace footlight::drivers
