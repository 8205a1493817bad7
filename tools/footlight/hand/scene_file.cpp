#include "tools/footlight/hand/scene_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/files/toml/toml_text.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHeader = "[[scene]]";
constexpr std::string_view kBegin =
    "# Scenes of 'footlight scene'. They may be edited; docs/control.md describes them.\n";

Status check_level(const SceneLevel& level, const std::string& path) {
  std::vector<HandLevel> ignored;
  Status read;
  const std::size_t equals = level.text.rfind('=');
  const std::size_t colon = equals == std::string::npos ? equals : level.text.rfind(':', equals);
  if (names_slots(level.text)) {
    read = parse_slot_assignment(level.text, ignored);
  } else if (colon == std::string::npos) {
    read = fail(ErrorCode::kBadInput, "{}: expected \"1.17=255\" or \"Mover 3:Tilt=30\"", level.text);
  } else if (const auto number = parse_hand_number(std::string_view(level.text).substr(equals + 1)); !number) {
    read = fail(ErrorCode::kBadInput, "{}: {}", level.text, number.error().message);
  }
  if (read) return {};
  return fail(ErrorCode::kBadInput, "{}:{}: {}", path, level.at, read.error().message);
}

Status check_name(std::string_view name) {
  const bool sound =
      !name.empty() && name.size() <= kSceneNameBytesMax &&
      std::none_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (sound) return {};
  return fail(ErrorCode::kBadInput, "expected a name of 1 to {} bytes without control characters", kSceneNameBytesMax);
}

// The lines of a text, each with its end.
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return lines;
}

std::string_view trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view() : line.substr(first);
}

// The text without this scene. Blank lines and comments before the next scene belong to that one.
Result<std::string> cut(const SceneFile& file, std::size_t index) {
  const std::vector<std::string_view> lines = lines_of(file.text);
  const auto first = static_cast<std::size_t>(file.scenes[index].at.line) - 1;
  if (first >= lines.size() || !trimmed(lines[first]).starts_with(kHeader)) {
    return fail(ErrorCode::kBadInput, "{}:{}: this scene does not begin with a line {}; change it in an editor",
                file.path, file.scenes[index].at, kHeader);
  }
  std::size_t end =
      index + 1 < file.scenes.size() ? static_cast<std::size_t>(file.scenes[index + 1].at.line) - 1 : lines.size();
  const auto is_comment = [](std::string_view line) { return trimmed(line).empty() || trimmed(line).front() == '#'; };
  const bool last = end == lines.size();
  while (end > first + 1 && is_comment(lines[end - 1])) --end;
  // One blank line goes with the scene.
  if (end < lines.size() && trimmed(lines[end]).empty() && !last) ++end;
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i < first || i >= end) text += lines[i];
  }
  return text;
}

std::string block_of(std::string_view name, const std::vector<std::string>& levels) {
  std::string text = fmt::format("{}\nname = {}\nlevels = [\n", kHeader, fixtures::toml_text(name));
  for (const std::string& level : levels) text += fmt::format("  {},\n", fixtures::toml_text(level));
  return text + "]\n";
}

// Holds the lock of a folder, so that two programs change its files one after the other.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder) : fd_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (fd_ >= 0) flock(fd_, LOCK_EX);  // a file system without locks: as without this class
  }
  ~FolderLock() {
    if (fd_ >= 0) close(fd_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int fd_;
};

Status change(const std::string& path, const std::function<Result<std::string>(const SceneFile&)>& edit, bool create) {
  FL_ASSIGN(const std::string file_path, fixtures::behind_links(path));  // a link stays a link
  std::error_code trouble;
  const fs::path target = fs::weakly_canonical(fs::absolute(file_path), trouble);
  if (trouble) return fail(ErrorCode::kIo, "{}: {}", path, trouble.message());
  const fs::path folder = target.parent_path();
  if (create) fs::create_directories(folder, trouble);
  if (trouble) return fail(ErrorCode::kIo, "{}: {}", folder.string(), trouble.message());
  const FolderLock lock(folder.string());
  auto file = load_scenes(target.string());
  if (!file && create && file.error().code == ErrorCode::kNotFound) {
    file = SceneFile{.path = target.string(), .text = std::string(kBegin), .scenes = {}};
  }
  if (!file) return tl::unexpected(std::move(file).error());
  FL_ASSIGN(std::string text, edit(*file));
  FL_ASSIGN(const SceneFile changed, parse_scenes(std::move(text), target.string()));
  return fixtures::write_file(target.string(), changed.text);
}

}  // namespace

Result<const LevelScene*> SceneFile::find_exactly(std::string_view name) const {
  std::string names;
  for (const LevelScene& scene : scenes) {
    if (scene.name == name) return &scene;
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", scene.name);
  }
  return fail(ErrorCode::kNotFound, "{}: there is no scene '{}'; there {} {}", path, name,
              scenes.size() == 1 ? "is" : "are", names.empty() ? "none" : names);
}

Result<const LevelScene*> SceneFile::find(std::string_view name) const {
  auto found = find_exactly(name);
  for (std::size_t i = 0; i < scenes.size() && !found; ++i)
    if (osc_name(scenes[i].name) == name) return &scenes[i];
  return found;
}

Result<SceneFile> parse_scenes(std::string text, const std::string& path) {
  if (text.size() > kSceneFileBytesMax) {
    return fail(ErrorCode::kBadInput, "{}: longer than {} bytes, the limit for a scene file", path, kSceneFileBytesMax);
  }
  SceneFile file{.path = path, .text = std::move(text), .scenes = {}};
  FL_ASSIGN(const fixtures::TomlNode root, fixtures::parse_toml(file.text, path));
  fixtures::TomlReader reader(root, path, "");
  for (const fixtures::TomlNode* node : reader.tables("scene")) {
    fixtures::TomlReader scene_reader(*node, path, std::string(kHeader));
    LevelScene scene;
    scene.at = scene_reader.place();
    scene.name = scene_reader.text("name");
    for (auto& [level, at] : scene_reader.texts("levels")) scene.levels.push_back({std::move(level), at});
    FL_TRY(scene_reader.finish());
    if (const Status named = check_name(scene.name); !named) {
      return fail(ErrorCode::kBadInput, "{}:{}: name: {}", path, scene_reader.place_of("name"), named.error().message);
    }
    for (const SceneLevel& level : scene.levels) FL_TRY(check_level(level, path));
    for (const LevelScene& other : file.scenes) {
      if (other.name != scene.name) continue;
      return fail(ErrorCode::kBadInput, "{}:{}: there is a scene '{}' already, at line {}", path, scene.at, scene.name,
                  other.at.line);
    }
    file.scenes.push_back(std::move(scene));
  }
  FL_TRY(reader.finish());
  return file;
}

Result<SceneFile> load_scenes(const std::string& path) {
  FL_ASSIGN(const auto bytes, fixtures::read_whole_file(path, kSceneFileBytesMax));
  return parse_scenes(std::string(fixtures::text_of(bytes)), path);
}

Result<std::string> with_scene(const SceneFile& file, std::string_view name, const std::vector<std::string>& levels) {
  FL_TRY(check_name(name));
  std::string text = file.text;
  for (std::size_t i = 0; i < file.scenes.size(); ++i) {
    if (file.scenes[i].name != name) continue;
    FL_ASSIGN(text, cut(file, i));
  }
  if (!text.empty() && text.back() != '\n') text += '\n';
  if (!text.empty() && !text.ends_with("\n\n")) text += '\n';
  return text + block_of(name, levels);
}

Result<std::string> without_scene(const SceneFile& file, std::string_view name) {
  FL_ASSIGN(const LevelScene* scene, file.find_exactly(name));
  return cut(file, static_cast<std::size_t>(scene - file.scenes.data()));
}

Status store_scene(const std::string& path, std::string_view name, const std::vector<std::string>& levels) {
  return change(
      path, [&](const SceneFile& file) { return with_scene(file, name, levels); }, /*create=*/true);
}

Status delete_scene(const std::string& path, std::string_view name) {
  return change(
      path, [&](const SceneFile& file) { return without_scene(file, name); }, /*create=*/false);
}

}  // namespace footlight::tools
