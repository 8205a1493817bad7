#include "render/passes/edges.h"

#include <cstddef>
#include <optional>

#include "render/passes/compute_pass.h"
#include "render/passes/triangles.h"
#include "shaders/beginedges.comp.h"
#include "shaders/blend.comp.h"
#include "shaders/edgeblocks.comp.h"
#include "shaders/edgebodies.comp.h"
#include "shaders/edgebodyparts.comp.h"
#include "shaders/edgemix.comp.h"
#include "shaders/edgeobjects.comp.h"
#include "shaders/edgeparts.comp.h"
#include "shaders/edges.comp.h"

namespace footlight::render {
namespace {

// Finds pixels with an edge, and parts of the picture whose samples have room; draws the samples of one part after the
// other, and mixes their colours; then writes these: a pixel's colour is made of those that its neighbours had before.
class EdgesPass final : public Pass {
 public:
  struct Parts {
    BoundPipeline find, divide, begin, mix, blend;
    std::optional<DrawnTriangles> drawn;  // none without bodies and objects
  };

  EdgesPass(const PassContext& context, Parts parts)
      : resources_(context.resources),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        room_(edge_room(context.settings)),
        part_count_(edge_part_count(context.settings)),
        parts_(std::move(parts)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    vkCmdFillBuffer(commands, resources_.picture.edge_parts.handle, 0, VK_WHOLE_SIZE, 0);
    vk::full_barrier(commands);
    parts_.find.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
    vk::full_barrier(commands);
    divide(commands);
    for (std::uint32_t part = 0; part < part_count_; ++part) {
      vk::full_barrier(commands);
      over_tiles(commands, parts_.begin, part);
      if (parts_.drawn) {
        vk::full_barrier(commands);
        parts_.drawn->record_part(commands, resources_, part);
      }
      vk::full_barrier(commands);
      over_tiles(commands, parts_.mix, part);
    }
    vk::full_barrier(commands);
    parts_.blend.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  void divide(VkCommandBuffer commands) const {
    const ObjectGroups objects = parts_.drawn ? object_groups(resources_.rig) : ObjectGroups{};
    const std::uint32_t push[] = {room_, objects.x, objects.y};
    parts_.divide.bind(commands);
    parts_.divide.pipeline->push(commands, std::as_bytes(std::span(push)));
    vkCmdDispatch(commands, 1, 1, 1);
  }
  void over_tiles(VkCommandBuffer commands, const BoundPipeline& bound, std::uint32_t part) const {
    bound.bind(commands);
    push_part(commands, bound, part);
    vkCmdDispatchIndirect(commands, resources_.picture.edge_parts.handle,
                          VkDeviceSize{part} * sizeof(EdgePartRow) + offsetof(EdgePartRow, tiles_x));
  }

  Resources& resources_;
  std::uint32_t tiles_x_;
  std::uint32_t tiles_y_;
  std::uint32_t room_;
  std::uint32_t part_count_;  // at most; the rest of them are empty
  Parts parts_;
};

}  // namespace

const PassEntry kEdgesPass{
    "edges",
    has_smooth_edges,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_BOXES, needs.surfaces},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                                           {FL_SPEC_EDGE_SAMPLES, settings.edge_samples}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      EdgesPass::Parts parts;
      FL_ASSIGN(parts.find, BoundPipeline::compute(context, kEdgesComp, context.constants));
      const bool any_bodies =
          has_constant(context, FL_SPEC_BODIES) && (context.only_pipelines || context.resources.rig.slot_count > 0);
      const vk::Spirv divide = any_bodies ? vk::Spirv(kEdgebodypartsComp) : vk::Spirv(kEdgepartsComp);
      FL_ASSIGN(parts.divide, BoundPipeline::compute(context, divide, {}));
      FL_ASSIGN(parts.begin, BoundPipeline::compute(context, kBeginedgesComp, context.constants));
      FL_ASSIGN(parts.mix, BoundPipeline::compute(context, kEdgemixComp, context.constants));
      FL_ASSIGN(parts.blend, BoundPipeline::compute(context, kBlendComp, {}));
      if (has_constant(context, FL_SPEC_BODIES)) {
        FL_ASSIGN(parts.drawn, DrawnTriangles::create(context, {kEdgebodiesComp, kEdgeobjectsComp, kEdgeblocksComp},
                                                      context.constants));
      }
      return std::unique_ptr<Pass>(new EdgesPass(context, std::move(parts)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kEdgesComp},      {kEdgepartsComp},  {kEdgebodypartsComp},
                                                 {kBeginedgesComp}, {kEdgebodiesComp}, {kEdgeobjectsComp},
                                                 {kEdgeblocksComp}, {kEdgemixComp},    {kBlendComp}};
    },
    "smooth edges of solid things"};

}  // namespace footlight::render
