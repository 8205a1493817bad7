// How triangles of bodies and objects are drawn by compute shaders: those of bodies and objects that fit into a
// workgroup, then the parts of larger ones (render/shaders/lib/triangle_blocks.glsl).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/passes/compute_pass.h"

namespace footlight::render {

// Workgroups that draw the objects of a rig.
struct ObjectGroups {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
};
[[nodiscard]] inline ObjectGroups object_groups(const RigTables& rig) {
  if (rig.object_draw_count == 0) return {};
  const std::uint32_t groups = groups_of(static_cast<std::uint32_t>(rig.object_triangles), FL_OBJECT_TRIANGLES);
  const std::uint32_t x = std::min<std::uint32_t>(groups, FL_SLOTS_X);
  return {x, groups_of(groups, x)};
}

inline void push_part(VkCommandBuffer commands, const BoundPipeline& bound, std::uint32_t part) {
  bound.pipeline->push(commands, std::as_bytes(std::span(&part, 1)));
}

class DrawnTriangles {
 public:
  struct Shaders {
    vk::Spirv bodies, objects, blocks;
  };

  [[nodiscard]] static Result<DrawnTriangles> create(const PassContext& context, const Shaders& shaders,
                                                     const std::vector<vk::SpecConstant>& constants) {
    DrawnTriangles drawn;
    const RigTables& rig = context.resources.rig;
    // Before there are tables it is not known which will be needed.
    const bool any = context.only_pipelines && rig.slot_count + rig.object_draw_count == 0;
    if (any || rig.slot_count > 0) {
      FL_ASSIGN(drawn.bodies_, BoundPipeline::compute(context, shaders.bodies, constants));
    }
    if (any || rig.object_draw_count > 0) {
      FL_ASSIGN(drawn.objects_, BoundPipeline::compute(context, shaders.objects, constants));
    }
    FL_ASSIGN(drawn.blocks_, BoundPipeline::compute(context, shaders.blocks, constants));
    return drawn;
  }

  // Before record(), with a barrier between them.
  static void clear(VkCommandBuffer commands, const Resources& resources) {
    const DrawBlocksHead none{0, 1, 1, 0};
    vkCmdUpdateBuffer(commands, resources.picture.draw_blocks.handle, 0, sizeof(none), &none);
  }

  // What pixels show at their middles.
  void record(VkCommandBuffer commands, const Resources& resources) const {
    if (bodies_.pipeline) {
      bodies_.bind(commands);
      vkCmdDispatchIndirect(commands, resources.rig.body_rounds.handle, 0);
    }
    if (objects_.pipeline) {
      const ObjectGroups groups = object_groups(resources.rig);
      objects_.bind(commands);
      vkCmdDispatch(commands, groups.x, groups.y, 1);
    }
    vk::full_barrier(commands);
    blocks_.bind(commands);
    vkCmdDispatchIndirect(commands, resources.picture.draw_blocks.handle, 0);
  }

  // The samples of pixels with an edge in a part of the picture (EdgePartRow).
  void record_part(VkCommandBuffer commands, const Resources& resources, std::uint32_t part) const {
    const VkBuffer parts = resources.picture.edge_parts.handle;
    const VkDeviceSize row = VkDeviceSize{part} * sizeof(EdgePartRow);
    for (const auto& [bound, groups] : {std::pair{&bodies_, offsetof(EdgePartRow, bodies_x)},
                                        std::pair{&objects_, offsetof(EdgePartRow, objects_x)}}) {
      if (!bound->pipeline) continue;
      bound->bind(commands);
      push_part(commands, *bound, part);
      vkCmdDispatchIndirect(commands, parts, row + groups);
    }
    vk::full_barrier(commands);
    blocks_.bind(commands);
    push_part(commands, blocks_, part);
    vkCmdDispatchIndirect(commands, parts, row + offsetof(EdgePartRow, blocks_x));
  }

 private:
  BoundPipeline bodies_, objects_, blocks_;
};

}  // namespace footlight::render
