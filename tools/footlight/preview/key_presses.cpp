#include "tools/footlight/preview/key_presses.h"

#include <algorithm>
#include <utility>

#include <GLFW/glfw3.h>

namespace footlight::tools {
namespace {

bool is_letter(int code) { return (code >= 'a' && code <= 'z') || (code >= 'A' && code <= 'Z'); }

// A letter of the layout as its GLFW_KEY_...; the key itself if it has another meaning than a letter everywhere, or
// types letters of another script, such as Greek.
int meant(int key, const char* name) {
  const bool prints_ascii = name != nullptr && name[0] > ' ' && name[0] <= '~' && name[1] == '\0';
  if (!prints_ascii) return key;
  if (is_letter(name[0])) return name[0] >= 'a' ? GLFW_KEY_A + (name[0] - 'a') : GLFW_KEY_A + (name[0] - 'A');
  return key >= GLFW_KEY_A && key <= GLFW_KEY_Z ? GLFW_KEY_UNKNOWN : key;
}

// Whether a field of text does something by the key, other than that it types a character.
bool is_command(int key, int mods) {
  const bool modifier = key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER;
  const bool keypad = key >= GLFW_KEY_KP_0 && key < GLFW_KEY_KP_ENTER;
  return !modifier &&
         ((key >= GLFW_KEY_ESCAPE && !keypad) || (mods & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER)) != 0);
}

}  // namespace

void KeyPresses::take_key(int key, const char* name, int action, int mods) {
  if (action == GLFW_RELEASE) return;
  mods_ = mods;
  repeated_ = action == GLFW_REPEAT;
  presses_.push_back({meant(key, name), mods, repeated_});
}

void KeyPresses::take_character(unsigned int character) {
  constexpr int kCommands = GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER;
  if (character <= ' ' || character > '~' || is_letter(static_cast<int>(character)) || (mods_ & kCommands) != 0) return;
  presses_.push_back({kTyped + static_cast<int>(character), 0, repeated_});
}

void HeldKey::take_key(int key, int action, int scancode) {
  if (key != key_ || !focused_) return;
  if (action == GLFW_RELEASE) state_ = State::kUp;
  if (action != GLFW_PRESS || state_ != State::kUp) return;
  state_ = State::kDown;
  scancode_ = scancode;
}

void HeldKey::take_state(bool down) {
  if (!down && held()) let_go();
}

void HeldKey::take_focus(bool focused) {
  focused_ = focused;
  let_go();
}

void KeyTaps::take_key(int key, int action, int mods) {
  if (key < 0 || static_cast<std::size_t>(key) >= kKeys || action == GLFW_REPEAT) return;
  down_[static_cast<std::size_t>(key)] = action == GLFW_PRESS;
  if (action == GLFW_PRESS && (pressed_.empty() || pressed_.back().key != key)) pressed_.push_back({key, mods});
}

std::optional<int> KeyTaps::hold(std::span<bool> down) {
  const std::vector<int> before = std::exchange(held_, {});
  for (const int key : before) down[static_cast<std::size_t>(key)] = false;
  std::optional<int> command;
  std::vector<Tap> later;
  for (const Tap& tap : std::exchange(pressed_, {})) {
    const auto at = static_cast<std::size_t>(tap.key);
    // Between two presses a picture has to see it up.
    const bool again = std::find(before.begin(), before.end(), tap.key) != before.end();
    const bool commands = is_command(tap.key, tap.mods);
    if (again || (commands && (command || !later.empty()))) {
      later.push_back(tap);
      down[at] = false;
      continue;
    }
    if (!down_[at]) held_.push_back(tap.key);
    down[at] = true;
    if (commands) command = tap.mods;
  }
  pressed_ = std::move(later);
  return command;
}

}  // namespace footlight::tools
