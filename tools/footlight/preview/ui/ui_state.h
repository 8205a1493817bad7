// What the user of the window edits, as plain data, and the commands that edit it (decision 0135).
//
// A command is a struct with apply(), undo() and text(). apply() notes what it replaces, so undo() after it gives the
// state from before. Everything that edits, a panel, a key or a test, makes a command and gives it to UiHistory::run().
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "fixtures/edit/rig_edit.h"
#include "fixtures/model/rig.h"
#include "render/settings.h"
#include "tools/footlight/preview/orbit_camera.h"
#include "tools/footlight/preview/ui/markers.h"
#include "tools/footlight/preview/ui/rig_index.h"
#include "tools/footlight/preview/ui/stage_views.h"

namespace footlight::tools {

// Indices into Rig::fixtures.
struct Selection {
  std::vector<int> fixtures;  // ascending, each once
  int lead = -1;              // the one selected last; -1: none
  [[nodiscard]] bool has(int fixture) const;
  bool operator==(const Selection&) const = default;
};

// How bright the picture is.
struct Exposure {
  float ev = 4;            // a lower one makes a brighter picture
  bool automatic = false;  // ev does not matter then
  bool operator==(const Exposure&) const = default;
};

// How the picture looks, but for its exposure and its haze, which is the rig's.
struct PictureLook {
  render::ToneCurve tone = render::ToneCurve::kAgx;
  bool balances_white = false;
  float white_k = 5600;  // where it does
  float glare_percent = 1;
  bool operator==(const PictureLook&) const = default;
};

struct UiState {
  Selection selection;
  std::map<ChannelKey, std::uint32_t> taken;  // channels with a value of the user's instead of the input's
  OrbitCamera camera{fixtures::Camera{}};  // of the active view
  int view = 0;                            // the active one
  std::vector<OrbitCamera> cameras = std::vector<OrbitCamera>(kViewsMax, camera);  // of the others
  [[nodiscard]] OrbitCamera& camera_of(int of_view) {
    return of_view == view ? camera : cameras[static_cast<std::size_t>(of_view)];
  }
  Exposure exposure;
  PictureLook look;
  Markers markers;  // of the log
  // The rig as its file has it, which EditRig changes; nullptr: it cannot be edited. Its fixtures have the indices of
  // the selection.
  fixtures::Rig* edited = nullptr;
  std::vector<int> ids;             // of its fixtures: an id stays with its fixture while others come and go
  int next_id = 0;                  // that no fixture had yet
  std::uint64_t revision = 0;       // of the edited rig: equal ones have equal contents; 0: as it was opened
  std::uint64_t revision_last = 0;  // that was given
};

struct SelectFixtures {
  Selection after;
  Selection before;  // set by apply()

  bool apply(UiState& state);  // false: nothing changes
  void undo(UiState& state) const;
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  // Goes on to where a later command of the same gesture leads; false: they are two edits.
  bool join(const SelectFixtures& later);
  [[nodiscard]] std::size_t heap_bytes() const;  // memory outside of the struct
};

// Takes channels over, or releases them.
struct TakeChannels {
  struct Edit {
    ChannelKey key;
    std::optional<std::uint32_t> after;  // a raw value; nothing: released
    std::optional<std::uint32_t> before;
  };
  std::vector<Edit> edits;  // in the order of their keys, each channel once
  // The channel that the user moved. Commands of one gesture join if it is the same one, although the channels that
  // follow it in other fixtures may change on the way.
  std::optional<ChannelKey> moved = std::nullopt;

  bool apply(UiState& state);
  void undo(UiState& state) const;
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  bool join(const TakeChannels& later);
  [[nodiscard]] std::size_t heap_bytes() const;
};

struct MoveCamera {
  OrbitCamera after;
  std::optional<float> exposure_ev = std::nullopt;  // of a camera of the rig; nothing: the exposure stays
  std::optional<int> view = std::nullopt;           // set by the first apply(): the one that was active then
  std::optional<OrbitCamera> before = std::nullopt;
  float before_ev = 0;

  bool apply(UiState& state);
  void undo(UiState& state) const;
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  bool join(const MoveCamera& later);
  [[nodiscard]] std::size_t heap_bytes() const;
};

struct SetExposure {
  Exposure after;
  Exposure before = {};

  bool apply(UiState& state);
  void undo(UiState& state) const;
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  bool join(const SetExposure& later);
  [[nodiscard]] std::size_t heap_bytes() const { return 0; }
};

struct SetLook {
  PictureLook after;
  PictureLook before = {};

  bool apply(UiState& state);
  void undo(UiState& state) const { state.look = before; }
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  bool join(const SetLook& later);
  [[nodiscard]] std::size_t heap_bytes() const { return 0; }
};

struct EditMarkers {
  Markers after;
  std::string does;  // "add the marker Chorus"
  Markers before = {};

  bool apply(UiState& state);
  void undo(UiState& state) const { state.markers = before; }
  [[nodiscard]] std::string text(const fixtures::Rig&) const { return does; }
  static bool join(const EditMarkers&) { return false; }
  [[nodiscard]] std::size_t heap_bytes() const;
};

// Edits the rig. Where fixtures get other indices, the selection and what was taken over follow them. What was taken
// over of fixtures that get another mode or are deleted is released.
struct EditRig {
  fixtures::RigEdit edit;
  std::optional<Selection> selects = std::nullopt;  // the selection after it; nothing: the same fixtures

  // Set by apply().
  std::uint64_t revision = 0;
  std::uint64_t before = 0;
  Selection selection_before = {};
  std::map<ChannelKey, std::uint32_t> taken_before = {};  // empty unless it changes
  std::vector<int> removed_ids = {};                      // of edit.removed
  std::vector<int> added_ids = {};                        // of edit.added, from the first apply() on

  bool apply(UiState& state);
  void undo(UiState& state) const;
  [[nodiscard]] std::string text(const fixtures::Rig& rig) const;
  bool join(const EditRig& later);
  [[nodiscard]] std::size_t heap_bytes() const;

 private:
  [[nodiscard]] bool releases() const;
  void move_ids(UiState& state);
};

using UiCommand = std::variant<SelectFixtures, TakeChannels, MoveCamera, SetExposure, SetLook, EditMarkers, EditRig>;
[[nodiscard]] std::string text_of(const UiCommand& command, const fixtures::Rig& rig);

// The commands so far, and those that were undone. Forgets the oldest ones when they need more than bytes_max: a drag
// of one channel of 10,000 fixtures needs 240 kB, an edit of 10,000 fixtures of the rig some 12 MB. The last command is
// kept whatever it needs.
class UiHistory {
 public:
  static constexpr std::size_t kBytesMax = std::size_t{1} << 30;  // 4,400 such drags

  explicit UiHistory(std::size_t bytes_max = kBytesMax) : bytes_max_(bytes_max) {}

  // Applies a command and remembers it; forgets what was undone. A command that changes nothing is not remembered.
  // Commands of one gesture, such as the drag of a slider, become one if they edit the same; 0: no gesture.
  enum class Ran { kNothing, kNew, kJoined };
  Ran run(UiState& state, UiCommand command, std::uint64_t gesture = 0);
  // nullptr: there is nothing to undo or redo. Else the command that was.
  const UiCommand* undo(UiState& state);
  const UiCommand* redo(UiState& state);
  [[nodiscard]] const UiCommand* next_undo() const { return done_ > 0 ? &commands_[done_ - 1] : nullptr; }
  [[nodiscard]] const UiCommand* next_redo() const { return done_ < commands_.size() ? &commands_[done_] : nullptr; }
  [[nodiscard]] std::size_t size() const { return commands_.size(); }
  // Undoes the last command and forgets it, if it is of this gesture; else false.
  bool drop(UiState& state, std::uint64_t gesture);
  // Forgets what was undone.
  void forget_undone();
  // Whether commands were forgotten for want of memory since the last call.
  [[nodiscard]] bool take_forgot() { return std::exchange(forgot_, false); }
  // What the commands need.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_max_;
  bool forgot_ = false;
  std::deque<UiCommand> commands_;
  std::size_t bytes_ = 0;      // of commands_
  std::size_t done_ = 0;       // of commands_ are applied
  std::uint64_t gesture_ = 0;  // of the last one
};

}  // namespace footlight::tools
