#include "tools/footlight/vrsl/vrsl_window.h"

#include <cstdlib>
#include <string>
#include <type_traits>

#include <GLFW/glfw3.h>

namespace footlight::tools {
namespace {

std::string last_window_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "unknown error";
}

// The functions of OpenGL 1.1 that put pixels on the screen. Every driver has them; GLFW loads the library, so that the
// program is not linked with it.
struct Gl {
  decltype(&::glViewport) viewport = nullptr;
  decltype(&::glClear) clear = nullptr;
  decltype(&::glMatrixMode) matrix_mode = nullptr;
  decltype(&::glLoadIdentity) load_identity = nullptr;
  decltype(&::glOrtho) ortho = nullptr;
  decltype(&::glRasterPos2f) raster_position = nullptr;
  decltype(&::glPixelZoom) pixel_zoom = nullptr;
  decltype(&::glPixelStorei) pixel_store = nullptr;
  decltype(&::glDrawPixels) draw_pixels = nullptr;
  decltype(&::glDisable) disable = nullptr;
  decltype(&::glGetError) error = nullptr;

  // For the context of this thread. False: a function is missing.
  bool load() {
    bool all = true;
    const auto get = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(glfwGetProcAddress(name));
      all = all && function != nullptr;
    };
    get(viewport, "glViewport");
    get(clear, "glClear");
    get(matrix_mode, "glMatrixMode");
    get(load_identity, "glLoadIdentity");
    get(ortho, "glOrtho");
    get(raster_position, "glRasterPos2f");
    get(pixel_zoom, "glPixelZoom");
    get(pixel_store, "glPixelStorei");
    get(draw_pixels, "glDrawPixels");
    get(disable, "glDisable");
    get(error, "glGetError");
    return all;
  }
};

// All calls come from one
// thread, which GLFW's X11 and Wayland parts allow to be another than the first one, and no other part of a bridge uses
// GLFW.
class GridWindow final : public drivers::PictureOutput {
 public:
  explicit GridWindow(drivers::PictureTarget target) : target_(std::move(target)) {}
  Status show(const drivers::Picture& picture, DurationNs /*time_ns*/) override {
    if (window_ == nullptr) FL_TRY(open(picture));
    glfwPollEvents();
    if (glfwWindowShouldClose(window_) != 0) {
      close();
      return fail(ErrorCode::kDisconnected, "its window was closed");
    }
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width == 0 || height == 0) return {};  // minimised
    gl_.viewport(0, 0, width, height);
    gl_.clear(GL_COLOR_BUFFER_BIT);
    // The top left corner, and rows downwards. A quarter of a pixel inside, or rounding may leave the position outside
    // of the window, where nothing is drawn.
    gl_.matrix_mode(GL_PROJECTION);
    gl_.load_identity();
    gl_.ortho(0, width, height, 0, -1, 1);
    gl_.raster_position(0.25F, 0.25F);
    gl_.pixel_zoom(1, -1);
    gl_.pixel_store(GL_UNPACK_ALIGNMENT, 1);
    gl_.draw_pixels(picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
    if (gl_.error() != GL_NO_ERROR) return fail(ErrorCode::kIo, "the display refused a picture");
    glfwSwapBuffers(window_);
    return {};
  }
  Status finish() override {
    close();
    return {};
  }

 private:
  Status open(const drivers::Picture& picture) {
    if (glfwInit() != GLFW_TRUE) return fail(ErrorCode::kIo, "no window: {}", last_window_error());
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    glfwWindowHint(GLFW_FOCUSED, GLFW_FALSE);
    glfwWindowHint(GLFW_SRGB_CAPABLE, GLFW_FALSE);  // codes are written as they are
    glfwWindowHint(GLFW_ALPHA_BITS, 0);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    const std::string title = "Footlight: " + target_.endpoint;
    window_ = glfwCreateWindow(picture.width, picture.height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
      const std::string reason = last_window_error();
      glfwTerminate();
      return fail(ErrorCode::kIo, "no window of {}x{}: {}", picture.width, picture.height, reason);
    }
    glfwMakeContextCurrent(window_);
    if (!gl_.load()) {
      close();
      return fail(ErrorCode::kIo, "no window: this display has no OpenGL");
    }
    glfwSwapInterval(0);  // the pictures have a rate of their own
    gl_.disable(GL_DITHER);
    // Displays with large pixels count windows in units of several pixels.
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width > 0 && height > 0 && (width != picture.width || height != picture.height)) {
      glfwSetWindowSize(window_, picture.width * picture.width / width, picture.height * picture.height / height);
    }
    return {};
  }
  void close() {
    if (window_ == nullptr) return;
    glfwDestroyWindow(window_);
    window_ = nullptr;
    glfwTerminate();
  }

  const drivers::PictureTarget target_;
  GLFWwindow* window_ = nullptr;
  Gl gl_;
};

bool has_display(const char* variable) {
  const char* const value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): nothing here sets variables
  return value != nullptr && *value != '\0';
}

}  // namespace

Result<std::unique_ptr<drivers::PictureOutput>> open_window_output(const drivers::PictureTarget& target) {
  if (!target.options.empty()) return drivers::unused_option(target, target.options.front().key);
  if (!has_display("DISPLAY") && !has_display("WAYLAND_DISPLAY")) {
    return fail(ErrorCode::kNotFound,
                "{}: there is no display (DISPLAY and WAYLAND_DISPLAY are not set); start it in a desktop session, or "
                "send the pictures to a device (vrsl:1-9@/dev/video9) or a pipe",
                target.endpoint);
  }
  return std::unique_ptr<drivers::PictureOutput>(std::make_unique<GridWindow>(target));
}

}  // namespace footlight::tools
