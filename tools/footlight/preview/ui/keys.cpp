#include "tools/footlight/preview/ui/keys.h"

#include <array>

#include <GLFW/glfw3.h>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {
namespace {

static_assert(kKeyShift == GLFW_MOD_SHIFT && kKeyControl == GLFW_MOD_CONTROL);

using A = UiAction;

constexpr KeyRow kKeyRows[] = {
    {GLFW_KEY_Z, kKeyControl, {A::kUndo}, true, "Ctrl+Z", "undo", UiMenu::kEdit},
    {GLFW_KEY_Z, kKeyControl | kKeyShift, {A::kRedo}, true, "Ctrl+Shift+Z, Ctrl+Y", "redo", UiMenu::kEdit},
    {GLFW_KEY_Y, kKeyControl, {A::kRedo}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_A, kKeyControl, {A::kSelectAll}, false, "Ctrl+A", "select all fixtures", UiMenu::kEdit},
    {GLFW_KEY_L, 0, {A::kHighlight}, false, "L", "highlight what is selected", UiMenu::kEdit},
    {GLFW_KEY_R, 0, {A::kReleaseAll}, false, "R", "release all values that were taken over", UiMenu::kEdit},
    {GLFW_KEY_F, 0, {A::kFrame}, false, "F", "frame the selection, or the rig", UiMenu::kView},
    {GLFW_KEY_F, kKeyShift, {A::kFrameRig}, false, "Shift+F", "frame the rig", UiMenu::kView},
    {GLFW_KEY_1, 0, {A::kCamera, 0}, false, "1 to 9", "cameras of the rig", UiMenu::kNone},
    {GLFW_KEY_W, 0, {A::kWorkLight}, false, "W", "work light", UiMenu::kView},
    {GLFW_KEY_E, 0, {A::kBrighter}, true, "E, +", "brighter picture", UiMenu::kView},
    {GLFW_KEY_EQUAL, 0, {A::kBrighter}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_EQUAL, kKeyShift, {A::kBrighter}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_KP_ADD, 0, {A::kBrighter}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_Q, 0, {A::kDarker}, true, "Q, -", "darker picture", UiMenu::kView},
    {GLFW_KEY_MINUS, 0, {A::kDarker}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_KP_SUBTRACT, 0, {A::kDarker}, true, nullptr, nullptr, UiMenu::kNone},
    {GLFW_KEY_SPACE, 0, {A::kPlay}, false, "Space", "pause or play the log", UiMenu::kPlayback},
    {GLFW_KEY_LEFT, 0, {A::kSeekBack}, true, "Left", "5 s back in the log", UiMenu::kPlayback},
    {GLFW_KEY_RIGHT, 0, {A::kSeekOn}, true, "Right", "5 s on in the log", UiMenu::kPlayback},
    {GLFW_KEY_H, 0, {A::kSidePanel}, false, "H", "side panel: all, a line, none", UiMenu::kView},
    {GLFW_KEY_F11, 0, {A::kFullScreen}, false, "F11", "full screen", UiMenu::kView},
    {GLFW_KEY_F12, 0, {A::kShot}, false, "F12", "save the window as a PNG", UiMenu::kView},
    {GLFW_KEY_ESCAPE, 0, {A::kEscape}, false, "Esc",
     "close the list of keys; then select nothing; then close the window", UiMenu::kNone},
};

constexpr MouseRow kMouseRows[] = {
    {"Click", "select a fixture; Ctrl or Shift adds it or takes it away"},
    {"Drag", "turn around the middle of the picture"},
    {"Right drag", "move sideways"},
    {"Wheel", "nearer and farther"},
};

std::optional<int> camera_of(int key) {
  if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) return key - GLFW_KEY_1;
  if (key >= GLFW_KEY_KP_1 && key <= GLFW_KEY_KP_9) return key - GLFW_KEY_KP_1;
  return std::nullopt;
}

}  // namespace

std::span<const KeyRow> key_rows() { return kKeyRows; }

std::span<const MouseRow> mouse_rows() { return kMouseRows; }

std::optional<UiCall> call_of(int key, int mods, bool repeated) {
  mods &= kKeyShift | kKeyControl;
  if (const auto camera = camera_of(key); camera && mods == 0 && !repeated) return UiCall{A::kCamera, *camera};
  for (std::size_t i = 0; i < panels().size(); ++i) {
    if (panels()[i].key == key && mods == 0 && !repeated) return UiCall{A::kPanel, static_cast<int>(i)};
  }
  for (const KeyRow& row : kKeyRows) {
    if (row.key == key && row.mods == mods && (row.repeats || !repeated)) return row.call;
  }
  return std::nullopt;
}

}  // namespace footlight::tools
