// A key that is released while another program has grabbed the keyboard: Xvfb, GLFW and xdotool. Skipped with a message
// where one of them is not installed.
#include <chrono>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

#include <dlfcn.h>

#include <GLFW/glfw3.h>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/tools/footlight/display.h"
#include "tools/footlight/preview/key_presses.h"
#include "tools/footlight/preview/key_state.h"
#include "tools/footlight/preview/ui/keys.h"

namespace footlight::tools {
namespace {

// Another program that grabs the keyboard, as a screen lock does.
class Grabber {
 public:
  explicit Grabber(const std::string& display) : library_(::dlopen("libX11.so.6", RTLD_NOW)) {
    REQUIRE(library_ != nullptr);
    connection_ = call<void*(const char*)>("XOpenDisplay")(display.c_str());
    REQUIRE(connection_ != nullptr);
  }
  ~Grabber() { call<int(void*)>("XCloseDisplay")(connection_); }
  Grabber(const Grabber&) = delete;
  Grabber& operator=(const Grabber&) = delete;
  [[nodiscard]] bool grab() {
    const unsigned long root = call<unsigned long(void*)>("XDefaultRootWindow")(connection_);
    constexpr int kAsync = 1;
    const int status = call<int(void*, unsigned long, int, int, int, unsigned long)>("XGrabKeyboard")(
        connection_, root, 0, kAsync, kAsync, 0);
    call<int(void*, int)>("XSync")(connection_, 0);
    return status == 0;
  }

 private:
  template <class Function>
  Function* call(const char* name) {
    void* const found = ::dlsym(library_, name);
    REQUIRE(found != nullptr);
    return reinterpret_cast<Function*>(found);
  }
  void* library_;
  void* connection_ = nullptr;
};

HeldKey* held_key = nullptr;

TEST_CASE("a key that is released while another program has grabbed the keyboard is not held") {
  if (std::system("command -v Xvfb > /dev/null && command -v xdotool > /dev/null") != 0) {  // NOLINT: fixed
    MESSAGE("skipped: needs Xvfb and xdotool; 'sudo apt-get install xvfb xdotool'");
    return;
  }
  const footlight::testing::Display display(320, 200);
  REQUIRE(!display.name().empty());
  REQUIRE(::setenv("DISPLAY", display.name().c_str(), 1) == 0);  // NOLINT: one thread
  REQUIRE(glfwInit() == GLFW_TRUE);
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  GLFWwindow* const window = glfwCreateWindow(320, 200, "keys", nullptr, nullptr);
  REQUIRE(window != nullptr);
  HeldKey key(kHoldKey);
  held_key = &key;
  glfwSetKeyCallback(window, [](GLFWwindow*, int code, int scancode, int action, int) {
    held_key->take_key(code, action, scancode);
  });
  const auto xdotool = [&](const char* what) {
    const std::string line = fmt::format("DISPLAY={} xdotool {}", display.name(), what);
    REQUIRE(std::system(line.c_str()) == 0);  // NOLINT: words of this file only
  };
  // Events until `is`, or for 10 s.
  const auto until = [&](const std::function<bool()>& is) {
    for (int i = 0; i < 1000 && !is(); ++i) glfwWaitEventsTimeout(0.01);
    return is();
  };
  xdotool("mousemove 100 100");
  const bool held = until([&] {
    xdotool("keyup End keydown End");
    for (int i = 0; i < 10; ++i) glfwWaitEventsTimeout(0.01);
    return key.held();
  });
  REQUIRE(held);
  CHECK(key_is_down(key.scancode()) == true);
  Grabber other(display.name());
  REQUIRE(other.grab());
  xdotool("keyup End");
  CHECK(until([&] { return key_is_down(key.scancode()) == false; }));
  CHECK(key.held());  // no event came
  key.take_state(*key_is_down(key.scancode()));
  CHECK(!key.held());
  key.take_key(kHoldKey, GLFW_PRESS, key.scancode());
  CHECK(!key.held());  // until it was seen up
  glfwDestroyWindow(window);
  glfwTerminate();
  CHECK(!key_is_down(key.scancode()));
}

}  // namespace
}  // namespace footlight::tools
