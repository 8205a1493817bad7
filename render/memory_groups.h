// The GPU memory of a frame, by what it is for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::render {

class Frame;

struct MemoryGroup {
  std::string name;
  std::uint64_t bytes = 0;
};

// What has no bytes is left out. All bytes are in one group each: the sum is Frame::bytes().
[[nodiscard]] std::vector<MemoryGroup> memory_groups(Frame& frame);

}  // namespace footlight::render
