#include "tools/footlight/preview/ui/keys.h"

#include <GLFW/glfw3.h>

#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {
namespace {

using A = UiAction;

constexpr KeyRow kKeyRows[] = {
    {GLFW_KEY_Z, GLFW_MOD_CONTROL, {A::kUndo}, true, "Ctrl+Z", "undo", UiMenu::kEdit},
    {GLFW_KEY_Z, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT, {A::kRedo}, true, "Ctrl+Shift+Z, Ctrl+Y", "redo", UiMenu::kEdit},
    {GLFW_KEY_Y, GLFW_MOD_CONTROL, {A::kRedo}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_S, GLFW_MOD_CONTROL, {A::kSave}, false, "Ctrl+S", "save the rig", UiMenu::kEdit},
    {GLFW_KEY_O, GLFW_MOD_CONTROL, {A::kOpen}, false, "Ctrl+O", "open a file ...", UiMenu::kFile},
    {GLFW_KEY_S,
     GLFW_MOD_CONTROL | GLFW_MOD_SHIFT,
     {A::kSaveAs},
     false,
     "Ctrl+Shift+S",
     "save the rig as ...",
     UiMenu::kFile},
    {GLFW_KEY_DELETE, 0, {A::kDelete}, false, "Del", "delete the selected fixtures from the rig", UiMenu::kEdit},
    {GLFW_KEY_A, GLFW_MOD_CONTROL, {A::kSelectAll}, false, "Ctrl+A", "select all fixtures", UiMenu::kEdit},
    {GLFW_KEY_P, GLFW_MOD_CONTROL, {A::kPalette}, false, "Ctrl+P", "find an action by its name", UiMenu::kEdit},
    {GLFW_KEY_RIGHT,
     GLFW_MOD_CONTROL,
     {A::kNudge, 0},
     true,
     "Ctrl+Right",
     "move the selected fixtures by 0.1 m to +X",
     UiMenu::kEdit},
    {GLFW_KEY_LEFT,
     GLFW_MOD_CONTROL,
     {A::kNudge, 1},
     true,
     "Ctrl+Left",
     "move the selected fixtures by 0.1 m to -X",
     UiMenu::kEdit},
    {GLFW_KEY_UP,
     GLFW_MOD_CONTROL,
     {A::kNudge, 2},
     true,
     "Ctrl+Up",
     "move the selected fixtures by 0.1 m to +Y",
     UiMenu::kEdit},
    {GLFW_KEY_DOWN,
     GLFW_MOD_CONTROL,
     {A::kNudge, 3},
     true,
     "Ctrl+Down",
     "move the selected fixtures by 0.1 m to -Y",
     UiMenu::kEdit},
    {GLFW_KEY_PAGE_UP,
     GLFW_MOD_CONTROL,
     {A::kNudge, 4},
     true,
     "Ctrl+Page Up",
     "move the selected fixtures by 0.1 m to +Z, up",
     UiMenu::kEdit},
    {GLFW_KEY_PAGE_DOWN,
     GLFW_MOD_CONTROL,
     {A::kNudge, 5},
     true,
     "Ctrl+Page Down",
     "move the selected fixtures by 0.1 m to -Z, down",
     UiMenu::kEdit},
    {GLFW_KEY_L,
     GLFW_MOD_CONTROL | GLFW_MOD_SHIFT,
     {A::kLock},
     false,
     "Ctrl+Shift+L",
     "lock: nothing here edits the rig or sets levels; again: unlock",
     UiMenu::kEdit},
    {GLFW_KEY_L, 0, {A::kHighlight}, false, "L", "highlight what is selected", UiMenu::kEdit},
    {GLFW_KEY_L,
     GLFW_MOD_SHIFT,
     {A::kLocate},
     false,
     "Shift+L",
     "locate: lit white at the home position",
     UiMenu::kEdit},
    {GLFW_KEY_R, 0, {A::kReleaseAll}, false, "R", "release all values that were taken over", UiMenu::kEdit},
    {GLFW_KEY_F, 0, {A::kFrame}, false, "F", "frame the selection, or the rig", UiMenu::kView},
    {GLFW_KEY_F, GLFW_MOD_SHIFT, {A::kFrameRig}, false, "Shift+F", "frame the rig", UiMenu::kView},
    {GLFW_KEY_G, 0, {A::kHandles}, false, "G", "handles that move and aim the selected fixtures", UiMenu::kView},
    {kTyped + '1', 0, {A::kCamera, 0}, false, "1 to 9", "cameras of the rig", UiMenu::kNone},
    {GLFW_KEY_C, 0, {A::kStoreCamera}, false, "C", "store this view in the rig, for keys 1 to 9", UiMenu::kView},
    {GLFW_KEY_V, 0, {A::kFly}, false, "V", "fly: W A S D, E up, Q down, drag to look, wheel: speed", UiMenu::kView},
    {GLFW_KEY_F1, GLFW_MOD_SHIFT, {A::kViewFrom, 0}, false, "Shift+F1", "view from the front of house", UiMenu::kView},
    {GLFW_KEY_F2, GLFW_MOD_SHIFT, {A::kViewFrom, 1}, false, "Shift+F2", "view from above", UiMenu::kView},
    {GLFW_KEY_F3, GLFW_MOD_SHIFT, {A::kViewFrom, 2}, false, "Shift+F3", "view from the left", UiMenu::kView},
    {GLFW_KEY_F4, GLFW_MOD_SHIFT, {A::kViewFrom, 3}, false, "Shift+F4", "view from the right", UiMenu::kView},
    {GLFW_KEY_F5, GLFW_MOD_SHIFT, {A::kViewFrom, 4}, false, "Shift+F5", "stage plan: straight down", UiMenu::kView},
    {GLFW_KEY_V, GLFW_MOD_SHIFT, {A::kViews}, false, "Shift+V", "one, two or four views of the stage", UiMenu::kView},
    {GLFW_KEY_TAB, 0, {A::kViews, 1}, true, "Tab", "the next view is the active one", UiMenu::kView},
    {GLFW_KEY_G, GLFW_MOD_SHIFT, {A::kFloorLines}, false, "Shift+G", "lines on the floor, 1 m apart", UiMenu::kView},
    {GLFW_KEY_T, 0, {A::kMeasure}, false, "T", "measure between two points that are clicked", UiMenu::kView},
    {GLFW_KEY_K, 0, {A::kCompare}, false, "K", "keep this moment, and compare its levels with now", UiMenu::kView},
    {GLFW_KEY_K, GLFW_MOD_SHIFT, {A::kEndCompare}, false, "Shift+K", "end the comparison of levels", UiMenu::kView},
    {GLFW_KEY_K,
     GLFW_MOD_CONTROL,
     {A::kCompareStage},
     false,
     "Ctrl+K",
     "A and B of the comparison on the stage: beside each other, their difference, off",
     UiMenu::kView},
    {GLFW_KEY_W, 0, {A::kWorkLight}, false, "W", "work light", UiMenu::kView},
    {GLFW_KEY_P, 0, {A::kFlashes}, false, "P", "harmful flashes: warn, limit, off", UiMenu::kView},
    {GLFW_KEY_E, 0, {A::kBrighter}, true, "E, +", "brighter picture", UiMenu::kView},
    {kTyped + '+', 0, {A::kBrighter}, true, nullptr, nullptr, UiMenu::kNone},
    {kTyped + '=', 0, {A::kBrighter}, true, nullptr, nullptr, UiMenu::kNone},  // + without Shift, of many keyboards
    {GLFW_KEY_Q, 0, {A::kDarker}, true, "Q, -", "darker picture", UiMenu::kView},
    {kTyped + '-', 0, {A::kDarker}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_SPACE, 0, {A::kPlay}, false, "Space", "pause or play the log", UiMenu::kPlayback},
    {GLFW_KEY_LEFT, 0, {A::kSeekBack}, true, "Left", "5 s back in the log", UiMenu::kPlayback},
    {GLFW_KEY_RIGHT, 0, {A::kSeekOn}, true, "Right", "5 s on in the log", UiMenu::kPlayback},
    {GLFW_KEY_LEFT, GLFW_MOD_SHIFT, {A::kSlower}, true, "Shift+Left", "slower", UiMenu::kPlayback},
    {GLFW_KEY_RIGHT, GLFW_MOD_SHIFT, {A::kFaster}, true, "Shift+Right", "faster", UiMenu::kPlayback},
    {GLFW_KEY_I, 0, {A::kRepeatFrom}, false, "I", "repeat from this time of the log", UiMenu::kPlayback},
    {GLFW_KEY_O, 0, {A::kRepeatTo}, false, "O", "repeat to this time of the log", UiMenu::kPlayback},
    {GLFW_KEY_X, 0, {A::kRepeatAll}, false, "X", "forget the part that repeats", UiMenu::kPlayback},
    {GLFW_KEY_M, 0, {A::kMark}, false, "M", "a marker at this time of the log", UiMenu::kPlayback},
    {GLFW_KEY_PAGE_UP, 0, {A::kMarkerBack}, true, "Page Up", "to the marker before", UiMenu::kPlayback},
    {GLFW_KEY_PAGE_DOWN, 0, {A::kMarkerOn}, true, "Page Down", "to the next marker", UiMenu::kPlayback},
    {GLFW_KEY_F6, GLFW_MOD_SHIFT, {A::kTheme}, false, "Shift+F6", "theme: dark or light", UiMenu::kView},
    {GLFW_KEY_F7, GLFW_MOD_SHIFT, {A::kUiSmaller}, true, "Shift+F7", "smaller panels and text", UiMenu::kView},
    {GLFW_KEY_F8, GLFW_MOD_SHIFT, {A::kUiLarger}, true, "Shift+F8", "larger panels and text", UiMenu::kView},
    {GLFW_KEY_R,
     GLFW_MOD_CONTROL,
     {A::kRecord},
     false,
     "Ctrl+R",
     "record what the fixtures get; again: end the recording",
     UiMenu::kView},
    {GLFW_KEY_N, 0, {A::kTap}, false, "N", "tap the tempo of made-up inputs", UiMenu::kView},
    {GLFW_KEY_H, 0, {A::kSidePanel}, false, "H", "side panel: all, a line, none", UiMenu::kView},
    {GLFW_KEY_F11, 0, {A::kFullScreen}, false, "F11", "full screen", UiMenu::kView},
    {GLFW_KEY_F12, 0, {A::kShot}, false, "F12", "save the window as a PNG", UiMenu::kView},
    {GLFW_KEY_B,
     0,
     {A::kBlackout},
     false,
     "B, F9",
     "blackout of outputs: all that are armed send zeros",
     UiMenu::kOutputs},
    {GLFW_KEY_F9, 0, {A::kBlackout}, false, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_B, GLFW_MOD_SHIFT, {A::kEndBlackout}, false, "Shift+B", "end the blackout of outputs", UiMenu::kOutputs},
    {GLFW_KEY_D, GLFW_MOD_CONTROL, {A::kDisarm}, false, "Ctrl+D", "disarm all outputs", UiMenu::kOutputs},
    {kTyped + '?', 0, {A::kPanel, 0}, false, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_ESCAPE,
     0,
     {A::kEscape},
     false,
     "Esc",
     "put a drag of a handle back; close a menu; cancel a seek; then the list of keys; then end flying and measuring; "
     "then select nothing; then close the window",
     UiMenu::kNone},
};

constexpr CommandRow kCommandRows[] = {
    {{A::kEditField, static_cast<int>(EditField::kAddress)}, "address of the selected fixtures", UiMenu::kEdit},
    {{A::kEditField, static_cast<int>(EditField::kName)}, "rename the selected fixtures", UiMenu::kEdit},
    {{A::kEditField, static_cast<int>(EditField::kNumber)}, "renumber the selected fixtures", UiMenu::kEdit},
    {{A::kEditField, static_cast<int>(EditField::kClone)}, "clone the selected fixtures", UiMenu::kEdit},
    {{A::kUnpatch}, "unpatch the selected fixtures", UiMenu::kEdit},
    {{A::kLibrary}, "add fixtures from the library", UiMenu::kEdit},
    {{A::kHoldToLive}, "dead man's switch: lamps are live only while End is held", UiMenu::kOutputs},
};
static_assert(kHoldKey == GLFW_KEY_END);

constexpr QualityChoice kQualityChoices[] = {{}, {0.01, 0}, {0.001, 0}, {0, 8}, {0, 16}};

constexpr MouseRow kMouseRows[] = {
    {"Click", "select a fixture; Ctrl or Shift adds it or takes it away"},
    {"Shift+drag", "select what is in the rectangle; Ctrl adds it, Ctrl+Shift takes it away; Esc: nothing"},
    {"Drag", "turn around the middle of the picture"},
    {"Right drag", "move sideways"},
    {"Right button on a camera", "in the side panel: store this view there, rename, delete"},
    {"Drag a handle (G)", "move or aim the selected fixtures; Ctrl: steps of 0.5 m; Esc: back"},
    {"Mouse over another view", "keys, drags and the wheel move its camera"},
    {"Wheel", "nearer and farther"},
};

}  // namespace

std::span<const KeyRow> key_rows() { return kKeyRows; }

std::span<const CommandRow> command_rows() { return kCommandRows; }

std::span<const QualityChoice> quality_choices() { return kQualityChoices; }

std::span<const MouseRow> mouse_rows() { return kMouseRows; }

std::optional<UiCall> call_of(const KeyPress& press) {
  const int mods = press.mods & (GLFW_MOD_SHIFT | GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER);
  if (press.code >= kTyped + '1' && press.code <= kTyped + '9' && mods == 0 && !press.repeated) {
    return UiCall{A::kCamera, press.code - (kTyped + '1')};
  }
  for (std::size_t i = 0; i < panels().size(); ++i) {
    if (panels()[i].key == press.code && mods == 0 && !press.repeated) return UiCall{A::kPanel, static_cast<int>(i)};
  }
  for (const KeyRow& row : kKeyRows) {
    if (row.key == press.code && row.mods == mods && (row.repeats || !press.repeated)) return row.call;
  }
  return std::nullopt;
}

bool acts_always(const KeyPress& press) {
  if (press.code != GLFW_KEY_F9) return false;
  const auto call = call_of(press);
  return call && call->action == A::kBlackout;
}

KeyTurn turn_of(const KeyPress& press, const KeyHolders& holders) {
  const auto call = call_of(press);
  if (!call) return KeyTurn::kNothing;
  if (acts_always(press)) return KeyTurn::kActs;
  if (holders.text) return KeyTurn::kNothing;
  const A action = call->action;
  if (action == A::kBlackout || action == A::kEndBlackout || action == A::kDisarm) return KeyTurn::kActs;
  const bool letter = press.code >= GLFW_KEY_A && press.code <= GLFW_KEY_Z && (press.mods & GLFW_MOD_CONTROL) == 0;
  if (holders.fly && letter && action != A::kFly && action != A::kStoreCamera) return KeyTurn::kNothing;
  if ((holders.press || holders.fly) && action == A::kViews) return KeyTurn::kNothing;
  if (holders.drag) return action == A::kEscape ? KeyTurn::kCancelsDrag : KeyTurn::kNothing;
  return holders.question && action != A::kEscape ? KeyTurn::kNothing : KeyTurn::kActs;
}

const KeyPress* canceling_key(std::span<const KeyPress> keys, const KeyHolders& holders) {
  for (const KeyPress& key : keys) {
    if (turn_of(key, holders) == KeyTurn::kCancelsDrag) return &key;
  }
  return nullptr;
}

}  // namespace footlight::tools
