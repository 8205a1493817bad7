// Whether what Dear ImGui draws is what it drew before, so that a window that has not changed need not be drawn again.
#pragma once

#include <cstddef>
#include <vector>

struct ImDrawData;

namespace footlight::tools {

class ShownUi {
 public:
  // True if `data` differs from that of the last call, or there was none since forget(). Compares every byte of its
  // vertices, indices and commands: 0.1 ms for 200 KiB.
  [[nodiscard]] bool changes(const ImDrawData& data);
  void forget() { last_.clear(); }

 private:
  std::vector<std::byte> last_;
  std::vector<std::byte> next_;
};

}  // namespace footlight::tools
