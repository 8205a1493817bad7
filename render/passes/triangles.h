// How triangles of bodies and objects are drawn by compute shaders: those of bodies and objects that fit into a
// workgroup, then the parts of larger ones (render/shaders/lib/triangle_blocks.glsl).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/passes/compute_pass.h"

namespace footlight::render {

// The push constants of all of them: rows of the picture.
struct RowsPush {
  std::int32_t first = 0;
  std::int32_t end = 0;
};

inline void push_rows(VkCommandBuffer commands, const BoundPipeline& bound, RowsPush rows) {
  bound.pipeline->push(commands, std::as_bytes(std::span(&rows, 1)));
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

  void record(VkCommandBuffer commands, const Resources& resources, RowsPush rows) const {
    const RigTables& rig = resources.rig;
    if (bodies_.pipeline) {
      bodies_.bind(commands);
      push_rows(commands, bodies_, rows);
      vkCmdDispatchIndirect(commands, rig.body_rounds.handle, 0);
    }
    if (objects_.pipeline) {
      const std::uint32_t groups = groups_of(static_cast<std::uint32_t>(rig.object_triangles), FL_GROUP_TRIANGLES);
      const std::uint32_t x = std::min<std::uint32_t>(groups, FL_SLOTS_X);
      objects_.bind(commands);
      push_rows(commands, objects_, rows);
      vkCmdDispatch(commands, x, groups_of(groups, x), 1);
    }
    vk::full_barrier(commands);
    blocks_.bind(commands);
    push_rows(commands, blocks_, rows);
    vkCmdDispatchIndirect(commands, resources.picture.draw_blocks.handle, 0);
  }

 private:
  BoundPipeline bodies_, objects_, blocks_;
};

}  // namespace footlight::render
