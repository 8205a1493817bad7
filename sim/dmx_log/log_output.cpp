#include "sim/dmx_log/log_output.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <tuple>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sim/file_kind.h"

namespace footlight::dmx_log {
namespace {

constexpr int kPartNamesMax = 1000;

std::string part_name(const std::string& path, int number) {
  return number == 1 ? path + ".part" : fmt::format("{}.part{}", path, number);
}

// The unfinished recording of this name that was written last; empty: none. A recording takes the lowest free number.
// So numbers may be missing, and the highest one may not be the newest.
std::string newest_part(const std::string& path) {
  std::string newest;
  timespec newest_time{};
  for (int number = 1; number <= kPartNamesMax; ++number) {
    const std::string part = part_name(path, number);
    struct stat info {};
    if (::stat(part.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) continue;
    const timespec& time = info.st_mtim;
    const bool older = std::tie(time.tv_sec, time.tv_nsec) < std::tie(newest_time.tv_sec, newest_time.tv_nsec);
    if (!newest.empty() && older) continue;
    newest = part;
    newest_time = time;
  }
  return newest;
}

// Writes the first `size` bytes of a file to a new one. errno says why it could not.
bool copy_to_new(int from, std::uint64_t size, const std::string& path) {
  const int to = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (to < 0) return false;
  std::array<std::uint8_t, 1u << 16> bytes;
  std::uint64_t done = 0;
  bool sound = true;
  while (sound && done < size) {
    const ssize_t read = ::pread(from, bytes.data(), std::min<std::uint64_t>(bytes.size(), size - done),
                                 static_cast<off_t>(done));
    if (read < 0 && errno == EINTR) continue;
    if (read == 0) errno = EIO;
    sound = read > 0;
    for (ssize_t at = 0; sound && at < read;) {
      const ssize_t count = ::write(to, bytes.data() + at, static_cast<std::size_t>(read - at));
      if (count < 0 && errno == EINTR) continue;
      if (count == 0) errno = ENOSPC;
      sound = count > 0;
      if (sound) at += count;
    }
    if (sound) done += static_cast<std::uint64_t>(read);
  }
  sound = sound && (::fdatasync(to) == 0 || errno == EINVAL);
  const int why = errno;
  const bool closed = ::close(to) == 0;
  if (!sound || !closed) {
    if (!sound) errno = why;
    const int error_number = errno;
    ::unlink(path.c_str());
    errno = error_number;
  }
  return sound && closed;
}

class FileOutput final : public LogOutput {
 public:
  FileOutput(int fd, std::string part_path, std::string path, bool overwrite)
      : fd_(fd), part_path_(std::move(part_path)), path_(std::move(path)), overwrite_(overwrite) {}
  FileOutput(const FileOutput&) = delete;
  FileOutput& operator=(const FileOutput&) = delete;
  ~FileOutput() override {
    ::close(fd_);
    if (size_ == 0) ::unlink(part_path_.c_str());  // refused before the first byte: nothing to recover
  }

  Status write(std::span<const std::uint8_t> bytes) override {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t count = ::pwrite(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(size_ + done));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        const int error_number = count < 0 ? errno : ENOSPC;
        // The bytes written would read as a torn block. Without them the file ends cleanly.
        if (::ftruncate(fd_, static_cast<off_t>(size_)) != 0) {
          // The reader skips the torn block.
        }
        return fail_errno(error_number, part_path_, "cannot write any more; what is in it so far can be read");
      }
      done += static_cast<std::size_t>(count);
    }
    size_ += done;
    return {};
  }

  Status sync() override {
    if (::fdatasync(fd_) != 0 && errno != EINVAL) return fail_errno(errno, part_path_, "cannot flush to the disk");
    return {};
  }

  Status finish() override {
    FL_TRY(sync());
    FL_TRY(find_part());
    if (!overwrite_) {
      // Unlike rename(), link() never replaces a file created meanwhile.
      if (::link(part_path_.c_str(), path_.c_str()) == 0) {
        ::unlink(part_path_.c_str());
        part_path_ = path_;
        return {};
      }
      if (errno == EEXIST) {
        return fail(ErrorCode::kIo, "{}: exists; the recording is complete under the name {}", path_, part_path_);
      }
      // Some file systems (FAT, many network ones) have no links: use rename().
    }
    if (std::rename(part_path_.c_str(), path_.c_str()) != 0) {
      return fail_errno(errno, path_, "cannot give the recording its name; it is complete under " + part_path_);
    }
    part_path_ = path_;
    return {};
  }

  void discard() override { ::unlink(part_path_.c_str()); }

  const std::string& path() const override { return part_path_; }

 private:
  // The file may have been deleted or renamed while it is open here. A deleted one is written once more.
  Status find_part() {
    struct stat own {};
    struct stat named {};
    if (::fstat(fd_, &own) != 0) return {};
    if (own.st_nlink > 0) {
      const bool there = ::stat(part_path_.c_str(), &named) == 0 && named.st_ino == own.st_ino &&
                         named.st_dev == own.st_dev;
      if (there) return {};
      return fail(ErrorCode::kIo, "{}: was renamed while it was recorded; the recording is complete under its new name",
                  part_path_);
    }
    const std::string deleted = part_path_;
    for (int number = 1; number <= kPartNamesMax; ++number) {
      part_path_ = part_name(path_, number);
      if (copy_to_new(fd_, size_, part_path_)) return {};
      if (errno != EEXIST) break;
    }
    return fail_errno(errno, deleted, "was deleted and cannot be written again: the recording is lost");
  }

  int fd_;
  std::string part_path_;
  std::string path_;
  bool overwrite_;
  std::uint64_t size_ = 0;
};

class MemoryOutput final : public LogOutput {
 public:
  MemoryOutput(Bytes& bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}
  Status write(std::span<const std::uint8_t> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
  }
  Status sync() override { return {}; }
  Status finish() override { return {}; }
  void discard() override { bytes_.clear(); }
  const std::string& path() const override { return name_; }

 private:
  Bytes& bytes_;
  std::string name_;
};

}  // namespace

tl::unexpected<Error> fail_errno(int error_number, const std::string& path, const std::string& doing) {
  ErrorCode code = ErrorCode::kIo;
  if (error_number == ENOENT || error_number == ENOTDIR) code = ErrorCode::kNotFound;
  if (error_number == EACCES || error_number == EPERM || error_number == EROFS) code = ErrorCode::kPermission;
  return fail(code, "{}: {}: {}", path, doing, std::generic_category().message(error_number));
}

tl::unexpected<Error> fail_open(int error_number, const std::string& path) {
  const std::string part = error_number == ENOENT ? newest_part(path) : "";
  if (part.empty()) return fail_errno(error_number, path, "cannot open");
  return fail(ErrorCode::kNotFound,
              "{0}: no such file, but {1} is there: its recorder was killed or still runs. Name {1} to read what it "
              "holds, or save that with 'footlight log convert {1} {0}' when no recorder runs",
              path, part);
}

Result<std::unique_ptr<LogOutput>> open_file_output(const std::string& path, bool overwrite) {
  FL_TRY(refuse_pipe_output(path));
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is a directory; name a file", path);
  }
  FL_TRY(refuse_existing(path, overwrite));
  for (int attempt = 1; attempt <= kPartNamesMax; ++attempt) {
    const std::string part_path = part_name(path, attempt);
    const int fd = ::open(part_path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0) return std::unique_ptr<LogOutput>(new FileOutput(fd, part_path, path, overwrite));
    if (errno != EEXIST) return fail_errno(errno, part_path, "cannot create");
  }
  return fail(ErrorCode::kIo, "{}.part to {}.part{}: all exist; convert or remove these unfinished recordings", path,
              path, kPartNamesMax);
}

std::unique_ptr<LogOutput> memory_output(Bytes& bytes, const std::string& name) {
  return std::make_unique<MemoryOutput>(bytes, name);
}

}  // namespace footlight::dmx_log
