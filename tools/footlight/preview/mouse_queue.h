// The mouse between two pictures. A picture may take a second, and Dear ImGui looks at the mouse only when one begins:
// a press would count where the mouse is by then, and a short drag would be a click. This keeps presses and releases
// with their places and gives at most one of them to a picture.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>

namespace footlight::tools {

struct MouseMoment {
  float x = 0;
  float y = 0;
  std::array<bool, 3> down{};  // left, right, middle
  // GLFW_MOD_... of the press of the button that goes down or up: a click in a list counts at its release, and the key
  // may be up by then. Nothing: no button moves.
  std::optional<int> mods;
};

class MouseQueue {
 public:
  // More presses and releases than these are lost, but not which buttons are down after them.
  static constexpr std::size_t kEventsMax = 64;

  void take_move(float x, float y);
  // Where the mouse was moved to last.
  void take_button(int button, bool down, int mods);
  // For the next picture: the mouse at its next press or release, else where it is. At the end of a drag first where it
  // was moved to, then the release there. Nothing: it did nothing since the last call.
  [[nodiscard]] std::optional<MouseMoment> next();
  // Forgets what was not given yet.
  void clear();

 private:
  struct Event {
    float x = 0;
    float y = 0;
    int button = -1;  // -1: moved
    bool down = false;
    int mods = 0;
  };
  std::deque<Event> events_;
  float x_ = 0;  // after the last event
  float y_ = 0;
  std::array<bool, 3> down_{};  // as given last
  std::array<bool, 3> newest_down_{};
  std::array<int, 3> press_mods_{};  // of the last press of each button
};

}  // namespace footlight::tools
