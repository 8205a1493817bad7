// The tables of shadows: what hides light, and room for what it hides of each beam.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/bodies/solids.h"
#include "render/resources.h"

namespace footlight::render {

// Bytes of the OccluderRow, ShadowListRow and ShadowRow tables; of one row where nothing hides light. Every beam may
// have a shadow of everything, up to FL_SHADOW_ROWS_MAX; a device that allows less for a table gets less. Each part of
// an object counts as one row: how many it has is known when its file is read.
[[nodiscard]] std::uint64_t occluder_bytes(const MemoryShape& shape);
[[nodiscard]] std::uint64_t shadow_list_bytes(const MemoryShape& shape);
[[nodiscard]] std::uint64_t shadow_bytes(const MemoryShape& shape);

// Makes the three tables. `object_solids`: as scene_mesh() makes them.
Status make_shadow_tables(vk::Device& device, const MemoryShape& shape,
                          const std::vector<fixtures::SolidBox>& object_solids, RigTables& r);

}  // namespace footlight::render
