// Whether what Dear ImGui draws is what the window shows. If so, the window need not be drawn again.
#pragma once

#include <cstddef>
#include <vector>

struct ImDrawData;

namespace footlight::tools {

class ShownUi {
 public:
  // True if `data` differs from that of the last call that returned true, or there was none since forget(). Places
  // count as the same up to a quarter of a pixel: a slider that plays a minute is drawn 15 times a second.
  [[nodiscard]] bool changes(const ImDrawData& data);
  void forget() { shown_ = {}; }

 private:
  struct Seen {
    std::vector<std::byte> exact;  // all but places
    std::vector<float> places;     // x, y of each vertex
  };
  Seen shown_;
  Seen next_;
};

}  // namespace footlight::tools
