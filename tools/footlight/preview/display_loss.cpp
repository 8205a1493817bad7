#include "tools/footlight/preview/display_loss.h"

#include <atomic>

#include <dlfcn.h>

namespace footlight::tools {
namespace {

std::atomic<bool> is_lost{false};

// Of Xlib, whose headers are not needed for three functions.
using Display = void;
using IoErrorHandler = int (*)(Display*);
using IoErrorExitHandler = void (*)(Display*, void*);

// Instead of a message of Xlib.
int on_io_error(Display*) {
  is_lost.store(true);
  return 0;
}

// Instead of exit().
void on_io_error_exit(Display*, void*) { is_lost.store(true); }

template <class Function>
Function* found(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void note_display_loss() {
  auto* const display = found<Display*()>("glfwGetX11Display");  // a GLFW for Wayland alone has none
  auto* const set_handler = found<IoErrorHandler(IoErrorHandler)>("XSetIOErrorHandler");
  // Since libX11 1.7. Without it the handler above must not return either.
  auto* const set_exit = found<void(Display*, IoErrorExitHandler, void*)>("XSetIOErrorExitHandler");
  if (display == nullptr || set_handler == nullptr || set_exit == nullptr) return;
  Display* const connection = display();
  if (connection == nullptr) return;
  set_handler(on_io_error);
  set_exit(connection, on_io_error_exit, nullptr);
}

bool display_is_lost() { return is_lost.load(); }

Status check_display() {
  if (!display_is_lost()) return {};
  return fail(ErrorCode::kDisconnected,
              "the window's display has gone: its X server ended, or the connection to it was cut; start the preview "
              "again in a desktop session");
}

}  // namespace footlight::tools
