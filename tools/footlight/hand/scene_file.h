// Scenes: named levels in a TOML file, which may be edited by hand (docs/control.md).
//
//   [[scene]]
//   name = "Warm wash"
//   levels = [
//     "1.1-12=0",
//     "1.17=255",
//     "Mover 3:Tilt=30",
//   ]
//
// The texts are those of 'footlight set'. Slots are checked when the file is read, names of fixtures when a scene is
// recalled. with_scene() and without_scene() change only the lines of that scene; comments and the other scenes stay
// as they are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fixtures/files/source_at.h"
#include "sim/core/result.h"

namespace footlight::tools {

inline constexpr std::size_t kSceneFileBytesMax = 4u << 20;
inline constexpr std::size_t kSceneNameBytesMax = 100;

struct SceneLevel {
  std::string text;
  fixtures::SourceAt at;
};

struct LevelScene {
  std::string name;
  std::vector<SceneLevel> levels;
  fixtures::SourceAt at;  // of its [[scene]]
};

struct SceneFile {
  std::string path;
  std::string text;
  std::vector<LevelScene> scenes;  // in the order of the file; no name twice

  // kNotFound lists the names. find() also takes underscores for characters that OSC reserves.
  [[nodiscard]] Result<const LevelScene*> find_exactly(std::string_view name) const;
  [[nodiscard]] Result<const LevelScene*> find(std::string_view name) const;
};

// `path` is the name of the text in messages: "scenes.toml:12:3: ...". Errors: kBadInput.
[[nodiscard]] Result<SceneFile> parse_scenes(std::string text, const std::string& path);
// Also returns kNotFound, kPermission, kIo.
[[nodiscard]] Result<SceneFile> load_scenes(const std::string& path);

// The new text. Errors: kBadInput: the name is empty, too long or has control characters; the scene is written in
// another form than above.
[[nodiscard]] Result<std::string> with_scene(const SceneFile& file, std::string_view name,
                                             const std::vector<std::string>& levels);
[[nodiscard]] Result<std::string> without_scene(const SceneFile& file, std::string_view name);

// Stores or deletes one scene: reads the file (none: begins one, with its folder), changes it and replaces it in one
// step. Two programs that do so at the same time wait for each other.
[[nodiscard]] Status store_scene(const std::string& path, std::string_view name,
                                 const std::vector<std::string>& levels);
[[nodiscard]] Status delete_scene(const std::string& path, std::string_view name);

}  // namespace footlight::tools
