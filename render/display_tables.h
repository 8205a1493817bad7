// The tables of displays: their rows, the levels of their cells, and the jobs that compute them.
#pragma once

#include <cstdint>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

struct DisplayTables {
  std::vector<DisplayRow> rows;
  std::vector<DisplayLevelRow> levels;
  std::vector<DisplayJobRow> jobs;  // of what does not change, then of what follows from levels; by level
  DisplayJobs still, live, film;
  std::uint64_t words = 0;  // of all cells
};
[[nodiscard]] DisplayTables display_tables(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

// Bytes of the buffer at one of the four bindings.
[[nodiscard]] std::uint64_t display_bytes(std::uint32_t binding, const MemoryShape& shape);
// Fails if the device allows no buffer as large as that of the cells.
[[nodiscard]] Status make_display_tables(vk::Device& device, const MemoryShape& shape, RigTables& r);

}  // namespace footlight::render
