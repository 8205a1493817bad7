#include "tools/footlight/mvr/received_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "fixtures/files/export/write_file.h"
#include "sim/file_kind.h"
#include "tools/footlight/mvr/shared_file.h"

namespace footlight::tools {
namespace {

// Fails with EEXIST if `to` exists. Some file systems have no such renaming, but links.
bool rename_new(const std::string& from, const std::string& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
  return ::link(from.c_str(), to.c_str()) == 0 && ::unlink(from.c_str()) == 0;
}

}  // namespace

ReceivedFile::ReceivedFile(std::string path, const Options& options)
    : path_(std::move(path)),
      part_(fixtures::part_name(path_) + ".mvr"),
      overwrite_(options.overwrite),
      shows_(options.shows && ::isatty(STDERR_FILENO) != 0) {}

ReceivedFile::~ReceivedFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (part_exists_) std::remove(part_.c_str());
}

Status ReceivedFile::open() {
  std::remove(part_.c_str());  // of a program that was killed, and had the same process number
  file_ = std::fopen(part_.c_str(), "wbx");
  part_exists_ = file_ != nullptr;
  if (part_exists_) return {};
  return fail(ErrorCode::kIo, "{}: cannot be written ({}); choose a folder that exists and is yours", path_,
              std::strerror(errno));
}

Status ReceivedFile::write(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) return failed();
  bytes_ += bytes.size();
  const int percent = static_cast<int>(bytes_ * 100 / std::max<std::uint64_t>(total_bytes, 1));
  if (shows_ && percent != percent_) fmt::print(stderr, "\rfootlight: {} %\033[K", percent);
  if (shows_ && percent == 100) fmt::print(stderr, "\r\033[K");
  percent_ = percent;
  return {};
}

Result<std::string> ReceivedFile::finish() {
  const bool written = std::fflush(file_) == 0 && ::fsync(::fileno(file_)) == 0;
  if (std::fclose(std::exchange(file_, nullptr)) != 0 || !written) return failed();
  FL_ASSIGN(std::string line, check_mvr(part_, path_));
  FL_TRY(take_name());
  part_exists_ = false;
  return line;
}

Status ReceivedFile::take_name() {
  const bool named = overwrite_ ? std::rename(part_.c_str(), path_.c_str()) == 0 : rename_new(part_, path_);
  if (named) return {};
  if (!overwrite_ && errno == EEXIST) return refuse_existing(path_, overwrite_);
  return fail(ErrorCode::kIo, "{}: cannot be written: {}", path_, std::strerror(errno));
}

tl::unexpected<Error> ReceivedFile::failed() const {
  return fail(ErrorCode::kIo, "{}: writing failed ({}); is the disk full?", path_, std::strerror(errno));
}

}  // namespace footlight::tools
