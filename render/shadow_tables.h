// The tables of shadows: what hides light, and room for what it hides of each beam.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/bodies/solids.h"
#include "render/resources.h"

namespace footlight::render {

// Fails if shadow_map_px or penumbra are not among the values that settings.h names.
Status check_shadow_settings(const FrameSettings& settings);

// Sets shadow_map_px to what the tables of a frame have. Fails if they were made for other shadows, or for fewer points
// of a lens. range_bytes: the largest table of the device.
Status suit_shadows(const fixtures::Needs& needs, const RigTables& rig, std::uint64_t range_bytes,
                    FrameSettings& settings);

// Bytes of the OccluderRow, ShadowListRow and ShadowRow tables; of one row where nothing hides light. Every beam may
// have a shadow of everything, up to FL_SHADOW_ROWS_MAX; a device that allows less for a table gets less. Each part of
// an object counts as one row: how many it has is known when its file is read.
[[nodiscard]] std::uint64_t occluder_bytes(const MemoryShape& shape);
// Spheres around groups of so many bodies (shared/shadow_map.h).
[[nodiscard]] std::uint64_t occluder_groups(std::uint64_t occluders);
[[nodiscard]] std::uint64_t shadow_list_bytes(const MemoryShape& shape);
[[nodiscard]] std::uint64_t shadow_bytes(const MemoryShape& shape);

// The same of the shadow maps; a device that allows less for a table gets fewer texels.
[[nodiscard]] std::uint64_t shadow_map_bytes(const MemoryShape& shape);

// FrameSettings::shadow_map_px of a frame: as it stands there, or as suits the rig, which is maps where all beams have
// more than kExactPairsMax pairs with what may hide their light; halved until the maps of all beams fit into
// FL_MAP_BYTES_MAX and `range_bytes`, the largest table of the device. 0 where even the least ones do not.
inline constexpr std::uint64_t kExactPairsMax = 1'000'000;
[[nodiscard]] std::uint32_t suited_map_px(const MemoryShape& shape, std::uint64_t range_bytes);

// Makes the four tables. `object_solids`: as scene_mesh() makes them.
Status make_shadow_tables(vk::Device& device, const MemoryShape& shape,
                          const std::vector<fixtures::SolidBox>& object_solids, RigTables& r);

}  // namespace footlight::render
