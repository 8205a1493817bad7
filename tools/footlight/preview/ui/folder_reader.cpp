#include "tools/footlight/preview/ui/folder_reader.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <fmt/format.h>

#include "sim/core/no_signals.h"

namespace footlight::tools {

struct FolderReader::Shared {
  std::mutex mutex;
  std::vector<FileEntry> read;  // the newest last
  bool ended = false;
  std::optional<Error> error;
  std::atomic<bool> stops = false;

  void end(std::optional<Error> why) {
    const std::lock_guard lock(mutex);
    error = std::move(why);
    ended = true;
  }

  void run(const std::string& folder) {
    DIR* const opened = opendir(folder.c_str());
    const auto trouble_of = [&](int code) {
      const ErrorCode kind = code == ENOENT   ? ErrorCode::kNotFound
                             : code == EACCES ? ErrorCode::kPermission
                                              : ErrorCode::kIo;
      return Error{kind, fmt::format("{}: {}", folder, std::strerror(code))};
    };
    if (opened == nullptr) return end(trouble_of(errno));
    int trouble = 0;
    while (!stops) {
      errno = 0;
      const dirent* const entry = readdir(opened);
      if (entry == nullptr) {
        trouble = errno;
        break;
      }
      const std::string name = entry->d_name;
      if (name == "." || name == "..") continue;
      struct stat about{};
      if (fstatat(dirfd(opened), entry->d_name, &about, 0) != 0) continue;  // a link to nothing, or it is gone
      const bool is_folder = S_ISDIR(about.st_mode);
      if (!is_folder && !S_ISREG(about.st_mode)) continue;
      FileEntry one{name, is_folder ? FileKind::kFolder : kind_of_name(name),
                    is_folder ? 0 : static_cast<std::uint64_t>(about.st_size), about.st_mtim.tv_sec};
      const std::lock_guard lock(mutex);
      read.push_back(std::move(one));
    }
    closedir(opened);
    end(trouble == 0 ? std::nullopt : std::optional(trouble_of(trouble)));
  }
};

FolderReader::FolderReader(const std::string& folder) : folder_(folder), shared_(std::make_shared<Shared>()) {
  const NoSignals no_signals;
  std::thread([shared = shared_, folder] { shared->run(folder); }).detach();
}

FolderReader::~FolderReader() { shared_->stops = true; }

std::vector<FileEntry> FolderReader::take() {
  const std::lock_guard lock(shared_->mutex);
  std::vector<FileEntry>& read = shared_->read;
  if (read.size() <= kPartMax) return std::exchange(read, {});
  const auto from = read.end() - static_cast<std::ptrdiff_t>(kPartMax);
  std::vector<FileEntry> part(std::make_move_iterator(from), std::make_move_iterator(read.end()));
  read.erase(from, read.end());
  return part;
}

bool FolderReader::ended() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->ended && shared_->read.empty();
}

std::optional<Error> FolderReader::error() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->error;
}

}  // namespace footlight::tools
