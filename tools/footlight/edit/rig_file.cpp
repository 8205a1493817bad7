#include "tools/footlight/edit/rig_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "fixtures/edit/patch_slots.h"
#include "fixtures/files/export/rig_toml.h"
#include "fixtures/files/export/write_file.h"
#include "sim/core/fnv.h"
#include "sim/file_kind.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

// True if the rig was read from a rig file of our own, not from the definition of one fixture.
bool is_rig_file(const fixtures::ImportedRig& imported, const std::string& path) {
  return imported.format == "toml" &&
         std::none_of(imported.rig.types.begin(), imported.rig.types.end(),
                      [&](const fixtures::FixtureType& type) { return type.provenance.file == path; });
}

std::string target_of(const fixtures::ImportedRig& imported, const std::string& path) {
  if (is_rig_file(imported, path)) return path;
  fs::path whole = fs::path(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // "unpacked/"
  fs::path target = whole;
  target.replace_extension(".toml");
  if (target == whole) target.replace_filename(whole.stem().string() + "_rig.toml");
  return target.string();
}

// True if a "#" outside of quotes begins a comment. A save would lose it.
bool has_comments(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    char quote = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (quote == 0 && c == '#') return true;
      if (quote == 0 && (c == '"' || c == '\'')) {
        quote = c;
      } else if (quote == '"' && c == '\\') {
        ++i;
      } else if (c == quote) {
        quote = 0;
      }
    }
  }
  return false;
}

// Keeps the file as "NAME~" if there is none, or if the file has comments: one that this program wrote has none, and
// does not replace one by hand. Returns its path; empty: it was not kept.
Result<std::string> keep_old(const std::string& path) {
  const std::string old = path + "~";
  const std::string part = fixtures::part_name(old);
  std::error_code trouble;
  if (fs::exists(fs::symlink_status(old, trouble)) && !has_comments(path)) return std::string();
  fs::copy_file(path, part, fs::copy_options::overwrite_existing, trouble);
  if (!trouble) fs::rename(part, old, trouble);
  if (!trouble) return old;
  std::error_code ignored;
  fs::remove(part, ignored);
  return fail(ErrorCode::kIo, "{}: a copy of the file from before cannot be written: {}", old, trouble.message());
}

// Locks the folder of a file against other programs that save in it, until the object is destroyed. Folders of file
// systems without locks are not locked.
class SaveLock {
 public:
  static Result<SaveLock> take(const std::string& path) {
    const std::string folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path().string() : ".";
    SaveLock lock(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    for (int tries = 0; lock.fd_ >= 0 && flock(lock.fd_, LOCK_EX | LOCK_NB) != 0; ++tries) {
      if (errno != EWOULDBLOCK) return lock;
      if (tries == 50) {
        return fail(ErrorCode::kIo, "{}: another program is saving in this folder; try again", path);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return lock;
  }
  SaveLock(SaveLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  SaveLock(const SaveLock&) = delete;
  SaveLock& operator=(const SaveLock&) = delete;
  SaveLock& operator=(SaveLock&&) = delete;
  ~SaveLock() {
    if (fd_ >= 0) close(fd_);
  }

 private:
  explicit SaveLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace

std::optional<FileMark> mark_of_file(const std::string& path) {
  if (is_pipe_or_device(path)) return std::nullopt;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) return std::nullopt;
  FileMark mark{0, kFnvStart};
  std::array<std::byte, 65536> piece{};
  while (const std::size_t count = std::fread(piece.data(), 1, piece.size(), file.get())) {
    mark.sum = fnv_sum(std::span(piece).first(count), mark.sum);
    mark.size += count;
  }
  if (std::ferror(file.get()) != 0) return std::nullopt;
  return mark;
}

Status check_rig_target(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  if (name.empty() || name == ".toml" || name == "." || name == "..") {
    return fail(ErrorCode::kBadInput, "{}: has no name before its ending; expected one such as show.toml", path);
  }
  std::error_code trouble;
  if (fs::is_directory(path, trouble)) {
    return fail(ErrorCode::kBadInput, "{}: is a folder; choose another name", path);
  }
  if (is_pipe_or_device(path)) {
    return fail(ErrorCode::kBadInput, "{}: is a pipe or a device; choose another name", path);
  }
  return {};
}

Result<RigFile> RigFile::open(const std::string& path, const fixtures::Library* library,
                              fixtures::Diagnostics& diagnostics, const fixtures::GoOn& go_on) {
  RigFile file;
  // Before it is read: a change in the meantime is then found by save().
  const std::optional<FileMark> mark = mark_of_file(path);
  FL_ASSIGN(file.imported_, fixtures::import_rig(path, library, diagnostics, go_on));
  file.path_ = path;
  file.target_ = target_of(file.imported_, path);
  if (file.target_ == path) file.known_ = mark;
  return file;
}

RigFile RigFile::made(fixtures::ImportedRig imported, const std::string& target) {
  return recovered(std::move(imported), "", target, std::nullopt);
}

RigFile RigFile::recovered(fixtures::ImportedRig imported, const std::string& path, const std::string& target,
                           const std::optional<FileMark>& known) {
  RigFile file;
  file.imported_ = std::move(imported);
  file.path_ = path;
  file.target_ = target;
  file.known_ = known;
  return file;
}

Result<SaveReport> write_rig(fixtures::ImportedRig& imported, const std::string& path, RigFiles files) {
  SaveReport report;
  report.path = path;
  fixtures::follow_types(imported);
  std::vector<fixtures::PatchedFixture> own = imported.rig.fixtures;
  report.shared = fixtures::share_conflicting_addresses(imported.rig);
  const auto write = [&]() -> Status {
    if (files == RigFiles::kThere) {
      const std::string folder = fs::path(fixtures::files_folder_of(path)).filename().string();
      return fixtures::write_rig_toml(imported, path, folder);
    }
    const auto there = files == RigFiles::kReplace ? fixtures::FilesThere::kReplace : fixtures::FilesThere::kKeepEqual;
    FL_TRY(fixtures::export_rig_toml(imported, path, {}, there));
    return {};
  };
  const Status written = write();
  imported.rig.fixtures = std::move(own);
  if (!written) return tl::unexpected<Error>(written.error());
  return report;
}

Result<SaveReport> RigFile::save() {
  FL_ASSIGN(const SaveLock lock, SaveLock::take(target_));
  std::error_code trouble;
  if (fs::is_symlink(target_, trouble)) {
    return fail(ErrorCode::kBadInput, "{}: is a link; open the file that it names to save it", target_);
  }
  const bool there = fs::exists(target_, trouble);
  if (there && !known_) {
    return fail(ErrorCode::kBadInput,
                "{}: exists already and was not opened here; save under another name, or move it away, then save again",
                target_);
  }
  if (there && mark_of_file(target_) != known_) {
    return fail(ErrorCode::kBadInput,
                "{}: was changed by another program since it was read; move it away, then save again", target_);
  }
  constexpr fs::perms kWriters = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  if (there && ((fs::status(target_, trouble).permissions() & kWriters) == fs::perms::none ||
                access(target_.c_str(), W_OK) != 0)) {
    return fail(ErrorCode::kPermission, "{}: is read-only; allow to write it, then save again", target_);
  }
  std::string old;
  if (there && !saved_) {
    FL_ASSIGN(old, keep_old(target_));
  }
  FL_ASSIGN(SaveReport report, write_rig(imported_, target_));
  known_ = mark_of_file(target_);
  saved_ = true;
  report.old = std::move(old);
  return report;
}

Result<SaveReport> RigFile::save_as(const std::string& path, bool replaces) {
  FL_TRY(check_rig_target(path));
  std::error_code trouble;
  const std::optional<FileMark> mark = replaces ? mark_of_file(path) : std::nullopt;
  if (replaces && !mark && fs::exists(path, trouble)) {
    return fail(ErrorCode::kPermission, "{}: cannot be read, so it could not be kept; choose another name", path);
  }
  const std::string target = std::exchange(target_, path);
  const std::optional<FileMark> known = std::exchange(known_, mark);
  const bool saved = std::exchange(saved_, false);
  auto report = save();
  if (!report) {
    target_ = target;
    known_ = known;
    saved_ = saved;
    return report;
  }
  path_ = path;
  return report;
}

}  // namespace footlight::tools
