// The rig that the window shows, made from the rig that is edited: with the options of the scene, a camera to start
// with, addresses for faders, and what VRSL shows of it. Knows neither a window nor a GPU.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/model/rig.h"
#include "tools/footlight/edit/rig_file.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/preview/hand_levels.h"

namespace footlight::tools {

// A rig with its tables. Not changed while somebody else holds it.
struct PreviewScene {
  fixtures::Rig rig;
  fixtures::CompiledRig compiled;
  std::optional<fixtures::Rig> written;  // as written, where `rig` is what VRSL shows of it
  std::uint64_t types = 0;               // EditedScene::types_ of its types
  std::uint64_t revision = 0;            // UiState::revision of the edited rig
  std::vector<int> ids;                  // of its fixtures: equal ones in two scenes are the same fixture
  // Ascending: those in which the rig has an address of its own, not one that was made up for faders.
  std::vector<Universe> own_universes;
};
using SharedScene = std::shared_ptr<PreviewScene>;

// The universes of compiled in which a log may have levels: not those that were made up for faders.
[[nodiscard]] std::vector<Universe> logged_universes(const PreviewScene& scene);

// Puts the channels of fixtures of `from` that `to` has no more to 0, but for slots that another fixture shares.
// levels: those of `from`. For pictures of the rig from before an edit: what is deleted is dark in the next one.
void darken_deleted(const PreviewScene& from, const PreviewScene& to, std::span<std::uint8_t> levels);

// For each fixture of one scene its index in another one; -1: it is not there.
[[nodiscard]] std::vector<int> fixture_moves(const PreviewScene& from, const PreviewScene& to);
// What the user set by faders, for another scene. `hand` is of `from`.
[[nodiscard]] std::unique_ptr<HandLevels> moved_hand(const HandLevels& hand, const PreviewScene& from,
                                                     const PreviewScene& to);

class EditedScene {
 public:
  // aspect: width over height of the picture that the start camera is for. by_hand: faders drive the rig.
  [[nodiscard]] static Result<std::unique_ptr<EditedScene>> make(RigFile file, const SceneFiles& files, double aspect,
                                                                 bool by_hand);
  EditedScene(const EditedScene&) = delete;
  EditedScene& operator=(const EditedScene&) = delete;

  [[nodiscard]] RigFile& file() { return file_; }
  [[nodiscard]] const SharedScene& scene() const { return scene_; }
  // Makes a new scene() after the fixtures of file() have changed. Fixtures that share slots both use them. If the rig
  // cannot be compiled, scene() stays. Universes stay in the tables once they were there, so that inputs need not be
  // opened again. ids: UiState::ids; empty: as many new ones as there are fixtures.
  // revision: UiState::revision, equal for equal rigs. shown: a scene from before that the picture still shows, or
  // null. If the rig is again as it was then, scene() is that one.
  Status remake(std::vector<int> ids = {}, std::uint64_t revision = 0, const SharedScene& shown = nullptr);

 private:
  EditedScene(RigFile file, const SceneFiles& files) : file_(std::move(file)), files_(files) {}
  Status follow_types();

  RigFile file_;
  SceneFiles files_;
  fixtures::Rig base_;       // with the options of the scene and its cameras; its fixtures do not matter
  std::uint64_t types_ = 0;  // counts the changes of its types
  bool by_hand_ = false;
  SharedScene scene_;
  std::vector<SharedScene> held_;  // scenes so far; those that nobody else holds are used again, with their types
};

}  // namespace footlight::tools
