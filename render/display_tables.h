// The tables of displays: their rows, the levels of their cells, and the jobs that compute them.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "render/resources.h"

namespace footlight::render {

struct DisplayTables {
  std::vector<DisplayRow> rows;
  std::vector<DisplayLevelRow> levels;
  std::vector<DisplayJobRow> jobs;  // of what does not change, then of what follows from levels; by level
  DisplayJobs still, live, film;
  std::uint64_t pixels = 0;  // of all displays
  std::uint64_t cells = 0;   // that are stored
};
inline constexpr std::uint64_t kPixelBytes = 12, kCellBytes = 24;
static_assert(sizeof(glm::vec3) == kPixelBytes, "a pixel of an image is one of a display");
[[nodiscard]] DisplayTables display_tables(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

// Bytes of the buffer at one of the five bindings.
[[nodiscard]] std::uint64_t display_bytes(std::uint32_t binding, const MemoryShape& shape);
// Fails if the device allows no buffer as large as that of the pixels or that of the cells.
[[nodiscard]] Status make_display_tables(vk::Device& device, const MemoryShape& shape, RigTables& r);

}  // namespace footlight::render
