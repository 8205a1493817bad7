#include "tools/footlight/edit/autosave.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/files/toml/toml_text.h"
#include "sim/core/fnv.h"
#include "sim/core/no_signals.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kFoldersMax = 20;  // of sessions with one rig
constexpr std::uint64_t kAboutBytesMax = 1 << 20;
constexpr const char* kRigName = "/rig.toml";
constexpr const char* kAboutName = "/about.toml";
constexpr const char* kLockName = "/lock";

std::string absolute_path(const std::string& path) {
  if (path.empty()) return {};
  std::error_code trouble;
  const fs::path absolute = fs::absolute(path, trouble);
  return (trouble ? fs::path(path) : absolute).lexically_normal().string();
}

// The folders of a rig's copies, in the order in which sessions take them.
std::vector<std::string> folders_of(const std::string& state, const std::string& path) {
  const std::string absolute = absolute_path(path);
  const std::uint64_t sum = fnv_sum(absolute);
  std::string stem = absolute.empty() ? "demo" : fs::path(absolute).stem().string();
  stem.resize(std::min<std::size_t>(stem.size(), 60));
  std::vector<std::string> folders;
  for (int number = 1; number <= kFoldersMax; ++number) {
    folders.push_back(
        fmt::format("{}/rigs/{}-{:016x}{}", state, stem, sum, number > 1 ? fmt::format("-{}", number) : std::string()));
  }
  return folders;
}

bool there(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::string about_text(const RigFile& file) {
  std::string text = "# What rig.toml is an automatic copy of: 'footlight preview --recover RIG' opens it.\n";
  if (!file.path().empty()) text += fmt::format("path = {}\n", fixtures::toml_text(absolute_path(file.path())));
  text += fmt::format("target = {}\n", fixtures::toml_text(absolute_path(file.target())));
  if (const auto& known = file.known()) text += fmt::format("known = \"{}:{:016x}\"\n", known->size, known->sum);
  return text;
}

std::optional<FileMark> mark_of_text(std::string_view text) {
  FileMark mark;
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto size = std::from_chars(text.data(), text.data() + colon, mark.size);
  const auto sum = std::from_chars(text.data() + colon + 1, text.data() + text.size(), mark.sum, 16);
  if (size.ec != std::errc() || sum.ec != std::errc()) return std::nullopt;
  return mark;
}

Status read_about(const std::string& path, LostEdits& lost) {
  FL_ASSIGN(const auto bytes, fixtures::read_whole_file(path, kAboutBytesMax));
  FL_ASSIGN(const fixtures::TomlNode root, fixtures::parse_toml(fixtures::text_of(bytes), path));
  fixtures::TomlReader reader(root, path, "");
  lost.path = reader.text("path", "");
  lost.target = reader.text("target");
  lost.known = mark_of_text(reader.text("known", ""));
  return reader.finish();
}

}  // namespace

std::optional<FolderClaim> FolderClaim::take(const std::string& folder) {
  std::error_code trouble;
  fs::create_directories(folder, trouble);
  if (trouble) return std::nullopt;
  const int fd = open((folder + kLockName).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return std::nullopt;
  FolderClaim claim(folder, fd);
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) return std::nullopt;
  struct stat its {};
  if (fstat(fd, &its) != 0 || its.st_nlink == 0) return std::nullopt;  // its folder was removed in the meantime
  return claim;
}

FolderClaim::FolderClaim(FolderClaim&& other) noexcept
    : folder_(std::move(other.folder_)), fd_(std::exchange(other.fd_, -1)) {}

FolderClaim& FolderClaim::operator=(FolderClaim&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(fd_, other.fd_);
  return *this;
}

FolderClaim::~FolderClaim() { release(); }

void FolderClaim::release() {
  if (fd_ >= 0) close(std::exchange(fd_, -1));
}

void FolderClaim::remove() {
  std::error_code ignored;
  fs::remove(folder_ + kRigName, ignored);  // first: without it there is no copy
  fs::remove_all(folder_, ignored);
}

std::optional<LostEdits> find_lost_edits(const std::string& state, const std::string& path) {
  std::optional<LostEdits> newest;
  if (state.empty()) return newest;
  for (const std::string& folder : folders_of(state, path)) {
    struct stat its {};
    if (stat((folder + kRigName).c_str(), &its) != 0) continue;
    if (newest && its.st_mtime <= newest->written_s) continue;
    auto claim = FolderClaim::take(folder);
    if (!claim) continue;
    LostEdits lost{std::move(*claim), its.st_mtime, {}, {}, {}};
    if (!read_about(folder + kAboutName, lost) || lost.path != absolute_path(path)) continue;
    const std::optional<FileMark> now = mark_of_file(lost.target);
    lost.older = lost.known && now != lost.known;
    lost.others = !lost.known && now;
    newest = std::move(lost);
  }
  return newest;
}

void discard_lost_edits(const LostEdits& lost) {
  const std::string& folder = lost.claim.folder();
  struct stat its {};
  if (stat((folder + kRigName).c_str(), &its) != 0) return;
  auto claim = FolderClaim::take(folder);
  if (claim && stat((folder + kRigName).c_str(), &its) == 0 && its.st_mtime == lost.written_s) claim->remove();
}

Result<RigFile> open_lost_edits(const LostEdits& lost) {
  fixtures::Diagnostics diagnostics;
  FL_ASSIGN(fixtures::ImportedRig imported, fixtures::import_rig(lost.claim.folder() + kRigName, nullptr, diagnostics));
  return RigFile::recovered(std::move(imported), lost.path, lost.target, lost.known);
}

struct Autosave::Copy {
  fixtures::ImportedRig imported;
  std::string folder;
  std::string about;
  bool has_files = false;

  Status write() {
    FL_TRY(fixtures::write_file(folder + kAboutName, about));
    FL_TRY(write_rig(imported, folder + kRigName, has_files ? RigFiles::kThere : RigFiles::kReplace));
    has_files = true;
    return {};
  }
};

Autosave::Autosave(const RigFile& file, std::string state, std::optional<FolderClaim> claim)
    : file_(file), state_(std::move(state)), claim_(std::move(claim)) {
  if (claim_) written_ = 0;
}

Autosave::~Autosave() {
  if (writing_.valid()) (void)writing_.get();
  if (claim_ && !there(claim_->folder() + kRigName)) claim_->remove();
}

Status Autosave::claim_folder() {
  if (claim_) return {};
  for (const std::string& folder : folders_of(state_, file_.path())) {
    if (there(folder + kRigName)) continue;  // of a session that runs, or that was lost
    auto claim = FolderClaim::take(folder);
    if (!claim || there(folder + kRigName)) continue;
    // What is left of a session that was killed before its first copy was whole.
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path() != fs::path(folder + kLockName)) fs::remove_all(entry.path(), ignored);
    }
    claim_ = std::move(claim);
    return {};
  }
  return fail(ErrorCode::kIo, "{}/rigs: no folder for automatic copies can be made there; save often", state_);
}

Status Autosave::begin(std::uint64_t revision) {
  FL_TRY(claim_folder());
  if (!copy_) copy_ = std::make_unique<Copy>(Copy{file_.imported(), claim_->folder(), {}, false});
  copy_->imported.rig.fixtures = file_.rig().fixtures;
  if (copy_->imported.rig.types.size() != file_.rig().types.size() ||
      copy_->imported.definitions != file_.imported().definitions) {  // an edit added types, or took them back
    copy_->imported.rig.types = file_.rig().types;
    copy_->imported.definitions = file_.imported().definitions;
    copy_->has_files = false;
  }
  copy_->about = about_text(file_);
  begun_ = revision;
  const NoSignals no_signals;
  writing_ = std::async(std::launch::async, [copy = copy_.get()] { return copy->write(); });
  return {};
}

Status Autosave::take_result() {
  Status result = writing_.get();
  if (result) written_ = begun_;
  begun_.reset();
  return result;
}

std::optional<Error> Autosave::step(TimeNs now_ns, std::uint64_t revision, bool unsaved) {
  if (state_.empty()) return std::nullopt;
  Status result;
  if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    result = take_result();
  }
  if (!unsaved) {
    changed_ns_.reset();
    if (written_ && !writing_.valid()) forget();
  } else if (revision == written_ || revision == begun_) {
    changed_ns_.reset();
  } else {
    if (!changed_ns_) changed_ns_ = now_ns;
    if (!writing_.valid() && now_ns - *changed_ns_ >= kAfterNs) {
      changed_ns_.reset();
      if (Status begun = begin(revision); !begun) result = std::move(begun);
    }
  }
  if (result) return std::nullopt;
  if (std::exchange(told_, result.error().message) == result.error().message) return std::nullopt;
  return result.error();
}

Status Autosave::write_now(std::uint64_t revision) {
  if (state_.empty()) return {};
  Status result;
  if (writing_.valid()) result = take_result();
  if (revision == written_) return {};
  FL_TRY(begin(revision));
  return take_result();
}

void Autosave::forget() {
  if (writing_.valid()) (void)take_result();
  written_.reset();
  changed_ns_.reset();
  if (!claim_) return;
  // The folder stays until the end: a recovered rig reads its definitions there.
  std::error_code ignored;
  fs::remove(claim_->folder() + kRigName, ignored);
}

}  // namespace footlight::tools
