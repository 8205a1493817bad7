// The keys that are pressed in a window, by what they mean in the layout of the keyboard: Z on a German keyboard is
// where Y is on an American one, W on a Dvorak keyboard where the comma is. Knows no window.
//
// Letters go by the name that GLFW has for the key. Other characters go by what is typed, because Shift is needed for +
// on some keyboards and not on others.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace footlight::tools {

// Added to a character: it was typed, with whatever keys.
inline constexpr int kTyped = 1 << 16;

struct KeyPress {
  int code = 0;           // GLFW_KEY_..., or kTyped and an ASCII character that is no letter
  int mods = 0;           // GLFW_MOD_...; 0 with kTyped
  bool repeated = false;  // the key is held
};

class KeyPresses {
 public:
  // As GLFW's callbacks give them, in their order: a key, and then the character that it types, if any. name: of
  // glfwGetKeyName(); may be nullptr.
  void take_key(int key, const char* name, int action, int mods);
  void take_character(unsigned int character);
  // Since the last clear(), in order.
  [[nodiscard]] const std::vector<KeyPress>& presses() const { return presses_; }
  void clear() { presses_.clear(); }

 private:
  std::vector<KeyPress> presses_;
  int mods_ = 0;  // of the last key
  bool repeated_ = false;
};

// Whether one key is held, for what may go on only while somebody holds it. In doubt it is not held.
//
// After a loss of the keyboard, or at the start, nobody knows whether the key is down, and X repeats a key that is down
// into the window that gets the keyboard as a press of its own. So a press counts only after a release that the window
// has seen while it has the keyboard.
class HeldKey {
 public:
  // A GLFW_KEY_..., wherever the layout of the keyboard has it.
  explicit HeldKey(int key) : key_(key) {}
  // As GLFW's callback gives them. A repeat presses nothing.
  void take_key(int key, int action, int scancode = 0);
  // What the keyboard itself says of scancode(), as key_is_down() (key_state.h) has it: a release may not be reported.
  // It cannot press anything.
  void take_state(bool down);
  [[nodiscard]] int scancode() const { return scancode_; }  // of the last press that counted
  // As GLFW's callback gives it. GLFW makes up releases of all keys after it: they count only while focused.
  void take_focus(bool focused);
  // The key has to go up and down again: for a window that is iconified.
  void let_go() { state_ = State::kUnknown; }
  [[nodiscard]] bool held() const { return state_ == State::kDown; }

 private:
  enum class State { kUnknown, kUp, kDown };
  int key_;
  State state_ = State::kUnknown;
  int scancode_ = 0;
  bool focused_ = true;  // until a callback says otherwise
};

// Keys for fields of text, which look at each picture whether a key is down: one that was pressed and released between
// two pictures is down in the next one. Presses of one key in a row count once in that time, and in two pictures twice.
//
// A field does one thing a picture. So of keys that are commands of a field (with Ctrl, Alt or Super, or keys that type
// nothing, as Del) one goes down in each picture, and those behind it wait: Ctrl+A and Del in one slow picture would
// delete a letter, with the rest still there.
class KeyTaps {
 public:
  static constexpr std::size_t kKeys = 512;  // of Dear ImGui; more than GLFW_KEY_LAST

  // As GLFW's callback gives them.
  void take_key(int key, int action, int mods);
  // Once a picture. down: which keys are down, kKeys of them, by GLFW's numbers. Returns GLFW_MOD_... of the command
  // that goes down, whose Ctrl or Shift may be up by then; nothing: there is none.
  std::optional<int> hold(std::span<bool> down);

 private:
  struct Tap {
    int key = 0;
    int mods = 0;
  };
  std::array<bool, kKeys> down_{};  // as the keyboard has them
  std::vector<Tap> pressed_;        // and not yet in a picture
  std::vector<int> held_;           // down in the last picture though they were released before it
};

}  // namespace footlight::tools
