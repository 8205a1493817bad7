// Whether a key is down, by the keyboard rather than by what a window was told of it.
#pragma once

#include <optional>

namespace footlight::tools {

// scancode: as GLFW's callback gives it, which for X is the keycode. Asks the X server, which takes one round trip. So
// a release is found that went to a program which has grabbed the keyboard, such as a screen lock or a menu of the
// desktop: X sends it to that program alone, and GLFW does not report such a grab as a loss of focus. Nothing: there is
// no X server, or it is away.
[[nodiscard]] std::optional<bool> key_is_down(int scancode);

}  // namespace footlight::tools
