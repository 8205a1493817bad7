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

void KeyTaps::take_key(int key, int action) {
  if (key < 0 || static_cast<std::size_t>(key) >= kKeys || action == GLFW_REPEAT) return;
  down_[static_cast<std::size_t>(key)] = action == GLFW_PRESS;
  if (action == GLFW_PRESS && std::find(pressed_.begin(), pressed_.end(), key) == pressed_.end()) {
    pressed_.push_back(key);
  }
}

void KeyTaps::hold(std::span<bool> down) {
  const std::vector<int> before = std::exchange(held_, {});
  for (const int key : before) down[static_cast<std::size_t>(key)] = false;
  std::vector<int> later;
  for (const int key : std::exchange(pressed_, {})) {
    // Between two presses a picture has to see it up.
    if (std::find(before.begin(), before.end(), key) != before.end()) {
      later.push_back(key);
      continue;
    }
    if (!down_[static_cast<std::size_t>(key)]) held_.push_back(key);
    down[static_cast<std::size_t>(key)] = true;
  }
  pressed_ = std::move(later);
}

}  // namespace footlight::tools
