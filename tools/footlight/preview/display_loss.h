// An X server that goes away, without the end of the program: Xlib would call exit(), and nothing would be saved.
#pragma once

#include "sim/core/result.h"

namespace footlight::tools {

// From now on an X server that goes away is noted instead. Once, after glfwInit(). Nothing happens without X.
void note_display_loss();
// It is away. X calls do nothing any more, and may return anything.
[[nodiscard]] bool display_is_lost();
// kDisconnected then, with a message for the user.
[[nodiscard]] Status check_display();

}  // namespace footlight::tools
