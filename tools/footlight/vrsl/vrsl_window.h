// Pictures in a window, pixel by pixel, for programs that capture windows.
#pragma once

#include <memory>
#include <string_view>

#include "drivers/vrsl/picture_port.h"

namespace footlight::tools {

// "window".
[[nodiscard]] bool is_window_target(std::string_view name);

// The window opens with the first picture, has the picture's size and cannot be resized. Nothing is scaled and no
// colour is converted: the levels of a picture are the codes on the screen. When the user closes it, pictures fail with
// kDisconnected. Options: none. Errors: kBadInput, kNotFound (no display), kUnsupported (a build without GLFW).
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_window_output(const drivers::PictureTarget& target);

}  // namespace footlight::tools
