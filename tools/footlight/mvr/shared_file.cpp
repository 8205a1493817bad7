#include "tools/footlight/mvr/shared_file.h"

#include <fstream>
#include <utility>
#include <vector>

#include "drivers/net/hash.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/core/counted.h"
#include "sim/file_kind.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr DurationNs kAskNs = kNsPerS / 2;
constexpr DurationNs kRestNs = kNsPerS;  // a program may still be writing

// A UUID of version 8 (RFC 9562) over two 64-bit digests.
std::string content_uuid(const std::vector<std::uint8_t>& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  drivers::Cid uuid = {};
  for (std::size_t half = 0; half < 2; ++half) {
    const std::uint64_t digest = drivers::mix64(drivers::fnv1a64(text, drivers::mix64(half + bytes.size())));
    for (std::size_t i = 0; i < 8; ++i) uuid.at(half * 8 + i) = static_cast<std::uint8_t>(digest >> (8 * i));
  }
  uuid[6] = static_cast<std::uint8_t>((uuid[6] & 0x0Fu) | 0x80u);
  uuid[8] = static_cast<std::uint8_t>((uuid[8] & 0x3Fu) | 0x80u);
  return uuid_text(uuid);
}

}  // namespace

std::string uuid_text(const drivers::Cid& uuid) {
  std::string text;
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    text += fmt::format("{}{:02x}", i == 4 || i == 6 || i == 8 || i == 10 ? "-" : "", uuid.at(i));
  }
  return text;
}

Result<std::string> check_mvr(const std::string& path, const std::string& shown) {
  const auto rig = fixtures::import_rig(path);
  if (!rig) {
    std::string message = rig.error().message;
    if (message.starts_with(path)) message.erase(0, path.size());
    return fail(ErrorCode::kBadInput, "{}{}{}", shown, message.starts_with(':') ? "" : ": ", message);
  }
  if (rig->format != "mvr") {
    return fail(ErrorCode::kBadInput, "{}: is a rig of format {}; expected an MVR file", shown, rig->format);
  }
  return fmt::format("{}, {}", counted(static_cast<long long>(rig->rig.fixtures.size()), "fixture"),
                     counted(static_cast<long long>(rig->assumptions.size()), "assumption"));
}

std::optional<SharedFile::Mark> SharedFile::mark_of(const std::string& path) {
  std::error_code trouble;
  Mark mark;
  mark.size = fs::file_size(path, trouble);
  if (!trouble) mark.time = fs::last_write_time(path, trouble);
  return trouble ? std::nullopt : std::optional(mark);
}

Result<SharedFile::Revision> SharedFile::read() const {
  FL_TRY(refuse_pipe_input(path_));
  FL_TRY(check_mvr(path_, path_));
  std::error_code trouble;
  const std::uintmax_t size = fs::file_size(path_, trouble);
  std::ifstream file(path_, std::ios::binary);
  if (!file || trouble) return fail(ErrorCode::kIo, "{}: cannot be read", path_);
  if (size > drivers::kMvrFileBytesMax) {
    return fail(ErrorCode::kBadInput, "{}: has {} bytes; at most {} can be shared", path_, size,
                drivers::kMvrFileBytesMax);
  }
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(size);
  file.read(reinterpret_cast<char*>(bytes->data()), static_cast<std::streamsize>(size));
  if (file.gcount() != static_cast<std::streamsize>(size)) return fail(ErrorCode::kIo, "{}: cannot be read", path_);
  Revision revision;
  revision.commit.file_uuid = content_uuid(*bytes);
  revision.commit.file_name = fs::path(path_).filename().string();
  revision.commit.comment = comment_;
  revision.commit.version_major = drivers::kMvrVersionMajor;
  revision.commit.version_minor = drivers::kMvrVersionMinor;
  revision.commit.file_bytes = bytes->size();
  revision.bytes = std::move(bytes);
  return revision;
}

Result<std::optional<SharedFile::Revision>> SharedFile::read_unchanged() {
  const auto before = mark_of(path_);
  auto revision = read();
  if (mark_of(path_) != before) return std::nullopt;
  known_ = before;
  if (!revision) return tl::unexpected(std::move(revision).error());
  return std::optional(std::move(*revision));
}

Result<SharedFile> SharedFile::open(const std::string& path, const std::string& comment) {
  SharedFile file;
  file.path_ = path;
  file.comment_ = comment;
  FL_ASSIGN(auto first, file.read_unchanged());
  if (!first) {
    return fail(ErrorCode::kIo, "{}: was changed while it was read; share it once it is written", path);
  }
  file.first_ = std::move(*first);
  file.last_uuid_ = file.first_.commit.file_uuid;
  return file;
}

Result<std::optional<SharedFile::Revision>> SharedFile::poll(TimeNs now_ns) {
  if (now_ns < next_ns_) return std::nullopt;
  next_ns_ = now_ns + kAskNs;
  const auto mark = mark_of(path_);
  if (!mark || mark == known_) {
    changed_.reset();
    return std::nullopt;
  }
  if (mark != changed_) {
    changed_ = mark;
    changed_ns_ = now_ns;
  }
  if (now_ns - changed_ns_ < kRestNs) return std::nullopt;
  FL_ASSIGN(auto revision, read_unchanged());
  if (!revision || revision->commit.file_uuid == last_uuid_) return std::nullopt;
  last_uuid_ = revision->commit.file_uuid;
  return revision;
}

}  // namespace footlight::tools
