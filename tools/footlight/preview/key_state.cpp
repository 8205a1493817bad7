#include "tools/footlight/preview/key_state.h"

#include <array>
#include <cstddef>

#include <dlfcn.h>

#include "tools/footlight/preview/display_loss.h"

namespace footlight::tools {
namespace {

constexpr int kKeycodes = 256;  // of X: a bit each

// Of GLFW and Xlib, whose headers are not needed for two functions.
using XDisplay = void;

template <class Function>
Function* function_of(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

// GLFW may have Xlib for itself alone.
template <class Function>
Function* x_function(const char* name) {
  if (auto* const found = function_of<Function>(name)) return found;
  void* const xlib = ::dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);  // stays
  return xlib != nullptr ? reinterpret_cast<Function*>(::dlsym(xlib, name)) : nullptr;
}

}  // namespace

std::optional<bool> key_is_down(int scancode) {
  static auto* const display = function_of<XDisplay*()>("glfwGetX11Display");  // a GLFW for Wayland alone has none
  static auto* const query = x_function<int(XDisplay*, char*)>("XQueryKeymap");
  if (scancode < 0 || scancode >= kKeycodes || display == nullptr || query == nullptr || display_is_lost()) return {};
  XDisplay* const connection = display();
  if (connection == nullptr) return {};
  std::array<char, kKeycodes / 8> map{};
  query(connection, map.data());
  if (display_is_lost()) return {};
  return (static_cast<unsigned char>(map[static_cast<std::size_t>(scancode / 8)]) >> (scancode % 8) & 1u) != 0;
}

}  // namespace footlight::tools
