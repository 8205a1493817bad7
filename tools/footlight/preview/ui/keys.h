// What keys and menus do: one table. The window looks a key up in it, the menu and the list of keys show it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace footlight::tools {

enum class UiAction {
  kUndo,
  kRedo,
  kSelectAll,
  kHighlight,
  kReleaseAll,
  kFrame,     // the selection; the rig if there is none
  kFrameRig,
  kCamera,    // argument: its index
  kWorkLight,
  kBrighter,
  kDarker,
  kPlay,
  kSeekBack,
  kSeekOn,
  kSidePanel,
  kPanel,     // argument: index into panels()
  kFullScreen,
  kShot,
  kEscape,
};

struct UiCall {
  UiAction action;
  int argument = 0;
};

enum class UiMenu { kNone, kEdit, kView, kPlayback };

struct KeyRow {
  int key;  // GLFW_KEY_...; of letters that which is printed on the key
  int mods;
  UiCall call;
  bool repeats;      // while it is held
  const char* keys;  // for people; nullptr: another way to say the row before
  const char* does;
  UiMenu menu;
};

inline constexpr int kKeyShift = 1;  // as GLFW has them
inline constexpr int kKeyControl = 2;

[[nodiscard]] std::span<const KeyRow> key_rows();
// What a key does; panels are opened by theirs. mods: of shift and control, others are ignored. `repeated`: the key is
// held.
[[nodiscard]] std::optional<UiCall> call_of(int key, int mods, bool repeated);

// What the mouse does, for the list.
struct MouseRow {
  const char* hands;
  const char* does;
};
[[nodiscard]] std::span<const MouseRow> mouse_rows();

}  // namespace footlight::tools
