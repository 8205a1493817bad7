// The tables of shadows: what hides light, and room for what it hides of each beam.
#pragma once

#include <cstdint>

#include "render/resources.h"

namespace footlight::render {

// Bytes of the OccluderRow, ShadowListRow and ShadowRow tables; of one row where nothing hides light. Every beam may
// have a shadow of everything, up to FL_SHADOW_BYTES_MAX.
[[nodiscard]] std::uint64_t occluder_bytes(const MemoryShape& shape);
[[nodiscard]] std::uint64_t shadow_list_bytes(const MemoryShape& shape);
[[nodiscard]] std::uint64_t shadow_bytes(const MemoryShape& shape);

// Makes the three tables.
Status make_shadow_tables(vk::Device& device, const MemoryShape& shape, RigTables& r);

}  // namespace footlight::render
