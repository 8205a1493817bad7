#include "tools/footlight/preview/mouse_queue.h"

#include <algorithm>

namespace footlight::tools {

void MouseQueue::take_move(float x, float y) {
  x_ = x;
  y_ = y;
  if (!events_.empty() && events_.back().button < 0) events_.pop_back();
  events_.push_back({x, y});
}

void MouseQueue::take_button(int button, bool down, int mods) {
  if (button < 0 || button >= static_cast<int>(down_.size())) return;
  newest_down_[static_cast<std::size_t>(button)] = down;
  int& press_mods = press_mods_[static_cast<std::size_t>(button)];
  if (down) press_mods = mods;
  if (events_.size() < kEventsMax) events_.push_back({x_, y_, button, down, press_mods});
}

std::optional<MouseMoment> MouseQueue::next() {
  if (events_.empty()) return std::nullopt;
  MouseMoment moment;
  const bool drags = std::find(down_.begin(), down_.end(), true) != down_.end();
  bool moved = false;
  while (!events_.empty()) {
    const Event event = events_.front();
    if (event.button >= 0 && !event.down && drags && moved) break;  // Dear ImGui ends a drag before it moves it
    events_.pop_front();
    moved = moved || event.button < 0;
    moment.x = event.x;
    moment.y = event.y;
    if (event.button < 0) continue;
    down_[static_cast<std::size_t>(event.button)] = event.down;
    moment.mods = event.mods;
    break;
  }
  if (events_.empty()) down_ = newest_down_;  // also what was lost
  moment.down = down_;
  return moment;
}

void MouseQueue::clear() {
  events_.clear();
  down_ = newest_down_;
}

}  // namespace footlight::tools
