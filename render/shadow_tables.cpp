#include "render/shadow_tables.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "fixtures/bodies/solids.h"
#include "render/pass.h"
#include "render/shaders/shared/shadow_map.h"

namespace footlight::render {
namespace {

// What hides light and does not move: stage boxes, and scenery and objects where they are drawn.
std::vector<OccluderRow> still_occluders(const MemoryShape& shape,
                                         const std::vector<fixtures::SolidBox>& object_solids) {
  if (!has_occluders(shape.needs, shape.settings)) return {};
  std::vector<fixtures::SolidBox> solids = fixtures::scene_solids(shape.rig);
  if (has_bodies(shape.needs, shape.settings)) {
    solids.insert(solids.end(), object_solids.begin(), object_solids.end());
  } else {
    solids.resize(shape.rig.boxes.size());
  }
  std::vector<OccluderRow> rows;
  for (const fixtures::SolidBox& solid : solids) {
    const glm::vec3 center(solid.center_m);
    double radius_m = 0;
    for (const glm::dvec3& half : solid.half_m) radius_m += glm::length(half);
    rows.push_back({center.x, center.y, center.z, FL_NONE, vec4(solid.half_m[0], radius_m),
                    vec4(solid.half_m[1], solid.slack_m), vec4(solid.half_m[2], 0)});
  }
  return rows;
}

// Bodies that hide light: at most one a head.
std::uint64_t shading_bodies_max(const MemoryShape& shape) {
  return has_bodies(shape.needs, shape.settings) ? shape.compiled.heads.size() : 0;
}

// All rows, at least one. Those of bodies are written by each frame; nothing of a body hides light before.
std::vector<OccluderRow> all_occluders(const MemoryShape& shape, const std::vector<fixtures::SolidBox>& object_solids) {
  std::vector<OccluderRow> rows = still_occluders(shape, object_solids);
  OccluderRow nothing{};
  nothing.half_edge_0.w = -1;
  const bool used = has_occluders(shape.needs, shape.settings);
  rows.resize(rows.size() + (used ? shading_bodies_max(shape) * FL_BODY_BOXES : 0), nothing);
  if (rows.empty()) rows.push_back(nothing);
  return rows;
}

// One solid a part of an object, before its file is read.
std::size_t planned_occluders(const MemoryShape& shape) {
  std::vector<fixtures::SolidBox> parts;
  for (const fixtures::SceneObject& object : shape.rig.objects) parts.resize(parts.size() + object.parts.size());
  return all_occluders(shape, parts).size();
}

std::uint64_t map_bytes(const MemoryShape& shape, std::uint32_t px, std::size_t occluders) {
  const std::uint64_t rows = px == FL_MAP_ROWS ? FL_MAP_ROWS * FL_MAP_ROW_WORDS : 0;
  const std::uint64_t words = std::uint64_t{px} * px + std::uint64_t{FL_MAP_CELLS} * FL_MAP_CELLS + rows;
  const std::uint64_t maps = std::max<std::uint64_t>(shape.compiled.beams_max, 1) * words * sizeof(std::uint32_t);
  return maps + occluder_groups(occluders) * 4 * sizeof(float);
}

// Every beam may have a shadow of everything, up to what the entries of lists can number.
std::uint64_t exact_bytes(const MemoryShape& shape, std::size_t occluders) {
  if (!has_shadows(shape.needs, shape.settings)) return sizeof(ShadowRow);
  const std::uint64_t pairs = shape.compiled.beams_max * std::uint64_t{occluders};
  return std::clamp<std::uint64_t>(pairs * shape.settings.penumbra, 1, FL_SHADOW_ROWS_MAX) * sizeof(ShadowRow);
}

}  // namespace

Status check_shadow_settings(const FrameSettings& settings) {
  const std::uint32_t map_px = settings.shadow_map_px;
  if (map_px != 0 && map_px != kShadowsSuited &&
      (map_px < kMapLeastPx || map_px > kMapMostPx || !std::has_single_bit(map_px))) {
    return fail(ErrorCode::kBadInput, "shadow maps of {} texels a side: expected 16, 32, 64, 128 or 256, or 0", map_px);
  }
  if (settings.penumbra != 1 && settings.penumbra != 4 && settings.penumbra != 7) {
    return fail(ErrorCode::kBadInput, "shadows from {} points of a lens: expected 1, 4 or 7", settings.penumbra);
  }
  return {};
}

Status suit_shadows(const fixtures::Needs& needs, const RigTables& rig, std::uint64_t range_bytes,
                    FrameSettings& settings) {
  if (settings.shadow_map_px == kShadowsSuited) settings.shadow_map_px = rig.shadow_map_px;
  if (!has_shadows(needs, settings)) return {};
  if (settings.shadow_map_px == 0 && rig.shadow_map_px > 0) {
    return fail(ErrorCode::kBadInput, "the frame was made for shadow maps: expected a new frame");
  }
  if (settings.shadow_map_px > 0 && rig.shadow_map_px == 0) {
    return fail(ErrorCode::kBadInput,
                "the frame was made for exact shadows: expected a new frame, or fewer beams if shadow maps of all of "
                "them do not fit into {} bytes",
                std::min<std::uint64_t>(FL_MAP_BYTES_MAX, range_bytes));
  }
  if (settings.penumbra > rig.lens_points) {
    return fail(ErrorCode::kBadInput, "the frame was made for shadows from {} points of a lens, not {}: expected a new "
                "frame", rig.lens_points, settings.penumbra);
  }
  settings.shadow_map_px = rig.shadow_map_px;
  return {};
}

std::uint64_t occluder_bytes(const MemoryShape& shape) { return planned_occluders(shape) * sizeof(OccluderRow); }

std::uint64_t occluder_groups(std::uint64_t occluders) {
  return (occluders + FL_OCCLUDER_GROUP - 1) / FL_OCCLUDER_GROUP;
}

std::uint64_t shadow_list_bytes(const MemoryShape& shape) {
  const std::uint64_t beams = has_shadows(shape.needs, shape.settings) ? shape.compiled.beams_max : 0;
  return std::max<std::uint64_t>(beams, 1) * sizeof(ShadowListRow);
}

std::uint64_t shadow_bytes(const MemoryShape& shape) {
  if (suited_map_px(shape, FL_MAP_BYTES_MAX) > 0) return sizeof(ShadowRow);
  return exact_bytes(shape, planned_occluders(shape));
}

std::uint64_t shadow_map_bytes(const MemoryShape& shape) {
  const std::uint32_t px = suited_map_px(shape, FL_MAP_BYTES_MAX);
  return px > 0 ? map_bytes(shape, px, planned_occluders(shape)) : sizeof(std::uint32_t);
}

std::uint32_t suited_map_px(const MemoryShape& shape, std::uint64_t range_bytes) {
  if (!has_shadows(shape.needs, shape.settings)) return 0;
  std::uint32_t px = shape.settings.shadow_map_px;
  if (px == kShadowsSuited) {
    // Of the rows kept for mirrors few are lit at a time: they do not decide.
    const std::uint64_t beams = shape.compiled.beams_max - shape.compiled.mirror_rows;
    px = beams * planned_occluders(shape) > kExactPairsMax ? kMapUsualPx : 0;
  }
  const std::size_t occluders = planned_occluders(shape);
  const std::uint64_t most = std::min<std::uint64_t>(FL_MAP_BYTES_MAX, range_bytes);
  while (px >= kMapLeastPx && map_bytes(shape, px, occluders) > most) px /= 2;
  return px >= kMapLeastPx ? px : 0;
}

Status make_shadow_tables(vk::Device& device, const MemoryShape& shape,
                          const std::vector<fixtures::SolidBox>& object_solids, RigTables& r) {
  const std::vector<OccluderRow> rows = all_occluders(shape, object_solids);
  FL_ASSIGN(r.occluders, vk::Buffer::table(device, rows));
  FL_ASSIGN(r.shadow_lists,
            vk::Buffer::device_local(device, shadow_list_bytes(shape), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  const std::uint64_t range = device.limits().maxStorageBufferRange;
  r.shadow_map_px = suited_map_px(shape, range);
  r.lens_points = shape.settings.penumbra;
  const std::uint64_t maps = r.shadow_map_px > 0 ? map_bytes(shape, r.shadow_map_px, rows.size()) : 4;
  FL_ASSIGN(r.shadow_maps, vk::Buffer::device_local(device, maps, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  const std::uint64_t most = range / sizeof(ShadowRow) * sizeof(ShadowRow);
  const std::uint64_t bytes = r.shadow_map_px > 0 ? sizeof(ShadowRow) : std::min(exact_bytes(shape, rows.size()), most);
  FL_ASSIGN(r.shadows, vk::Buffer::device_local(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  return device.run_once([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, r.shadow_lists.handle, 0, VK_WHOLE_SIZE, 0);
    vkCmdFillBuffer(commands, r.shadows.handle, 0, VK_WHOLE_SIZE, 0);
    vkCmdFillBuffer(commands, r.shadow_maps.handle, 0, VK_WHOLE_SIZE, 0);
  });
}

}  // namespace footlight::render
