// What keys and menus do: one table. The window looks a key up in it, the menu and the list of keys show it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/footlight/preview/key_presses.h"

namespace footlight::tools {

// The key of the dead man's switch: GLFW_KEY_END. It has no other meaning, and types nothing.
inline constexpr int kHoldKey = 269;

enum class UiAction {
  kUndo,
  kRedo,
  kOpen,  // a file, by a dialog
  kSave,
  kSaveAs,  // the rig in another file, by a dialog
  kDelete,  // what is selected
  kSelectAll,
  kLock,  // and unlocks
  kHighlight,
  kLocate,
  kReleaseAll,
  kFrame,  // the selection; the rig if there is none
  kFrameRig,
  kHandles,      // that move and aim the selection in the picture
  kNudge,        // moves the selection; argument: nudge_axis()
  kCamera,       // argument: its index
  kStoreCamera,  // the view as a new camera of the rig
  kViewFrom,     // argument: ViewSide
  kViews,        // argument 0: one, two or four of them; 1: the next one is active
  kFly,          // held keys move the camera
  kMeasure,      // clicks measure distances
  kFloorLines,
  kCompare,  // keeps this moment, to compare it with now
  kEndCompare,
  kCompareStage,  // A and B beside each other, their difference, neither
  kWorkLight,
  kFlashes,  // the next mode of harmful flashes
  kBrighter,
  kDarker,
  kPlay,
  kSeekBack,
  kSeekOn,
  kSlower,
  kFaster,
  kRepeatFrom,
  kRepeatTo,
  kRepeatAll,
  kMark,        // this time of the log
  kMarkerBack,  // to the marker before
  kMarkerOn,
  kMarker,  // to the one of this index
  kTheme,   // the other one
  kUiSmaller,
  kUiLarger,
  kOpenRecent,     // argument: index into UiDesk::recent_rigs()
  kOpenRecentLog,  // argument: index into UiDesk::recent_logs()
  kSidePanel,
  kPanel,  // argument: index into panels()
  kFullScreen,
  kShot,
  kBlackout,  // of all armed outputs
  kEndBlackout,
  kDisarm,      // all outputs; no key arms one
  kHoldToLive,  // they are live only while a key is held
  kRecord,      // begins and ends a recording
  kTap,         // of the tempo of made-up inputs
  kEditField,   // of the selected fixtures, in the patch; argument: EditField
  kUnpatch,     // the selected fixtures
  kLibrary,     // opens its panel
  kTone,        // argument: index into render::kToneCurves
  kQuality,     // argument: index into quality_choices()
  kPalette,
  kEscape,
};

struct UiCall {
  UiAction action;
  int argument = 0;
  bool operator==(const UiCall&) const = default;
};

// Argument of kNudge: the axis times 2, and 1 towards lower values.
[[nodiscard]] constexpr int nudge_axis(int argument) { return argument / 2; }
[[nodiscard]] constexpr double nudge_sign(int argument) { return argument % 2 == 0 ? 1 : -1; }

// What kQuality asks for: an error of the light as a share, or a time in ms, or nothing: knobs by hand.
struct QualityChoice {
  double error = 0;
  double ms = 0;
};
[[nodiscard]] std::span<const QualityChoice> quality_choices();

enum class UiMenu { kNone, kFile, kEdit, kView, kPlayback, kOutputs };

struct KeyRow {
  int key;  // as KeyPress has it
  int mods;
  UiCall call;
  bool repeats;      // while it is held
  const char* keys;  // for people; nullptr: another way to say the row before
  const char* does;
  UiMenu menu;
};

[[nodiscard]] std::span<const KeyRow> key_rows();

// An action without a key, for the menus and the list of actions.
struct CommandRow {
  UiCall call;
  const char* does;
  UiMenu menu;
};
[[nodiscard]] std::span<const CommandRow> command_rows();
// What a key does; panels are opened by theirs. A key with Alt or Super belongs to the desktop and does nothing.
[[nodiscard]] std::optional<UiCall> call_of(const KeyPress& press);
// Whether a key acts while text is typed or a question is open: the blackout key that types nothing.
[[nodiscard]] bool acts_always(const KeyPress& press);

// What has the keys in one picture, and what a key does then.
struct KeyHolders {
  bool text = false;      // a field of text, or the palette
  bool question = false;  // whether to close
  bool drag = false;      // of a handle or a rectangle
  bool fly = false;       // letters move the camera
  bool press = false;     // a button of the mouse is held that was pressed on the stage
};
enum class KeyTurn { kNothing, kActs, kCancelsDrag };
// Keys of outputs (blackout, its end, disarm) act during a drag and a question as well. Keys of views wait while the
// mouse is held or the camera flies: both stay in their view.
[[nodiscard]] KeyTurn turn_of(const KeyPress& press, const KeyHolders& holders);
// The first key that cancels a drag; nullptr: there is none.
[[nodiscard]] const KeyPress* canceling_key(std::span<const KeyPress> keys, const KeyHolders& holders);

// What the mouse does, for the list.
struct MouseRow {
  const char* hands;
  const char* does;
};
[[nodiscard]] std::span<const MouseRow> mouse_rows();

}  // namespace footlight::tools
