#include "render/passes/edges.h"

#include <algorithm>
#include <optional>

#include "render/passes/compute_pass.h"
#include "render/passes/triangles.h"
#include "shaders/beginedges.comp.h"
#include "shaders/blend.comp.h"
#include "shaders/edgeblocks.comp.h"
#include "shaders/edgebodies.comp.h"
#include "shaders/edgemix.comp.h"
#include "shaders/edgeobjects.comp.h"
#include "shaders/edges.comp.h"

namespace footlight::render {
namespace {

// Finds pixels with an edge; then, for as many rows as there is room for, draws their samples and mixes their colours;
// then writes these: a pixel's colour is made of those that its neighbours had before.
class EdgesPass final : public Pass {
 public:
  struct Parts {
    BoundPipeline find, begin, mix, blend;
    std::optional<DrawnTriangles> drawn;  // none without bodies and objects
  };

  EdgesPass(const PassContext& context, Parts parts)
      : resources_(context.resources),
        tiles_x_(tile_groups(context.settings.width)),
        height_(context.settings.height),
        rows_(edge_rows(context.settings)),
        parts_(std::move(parts)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    parts_.find.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tile_groups(height_), 1);
    vk::full_barrier(commands);
    for (int first = 0; first < height_; first += rows_) {
      const RowsPush rows{first, std::min(first + rows_, height_)};
      over_tiles(commands, parts_.begin, rows);
      if (parts_.drawn) {
        DrawnTriangles::clear(commands, resources_);
        vk::full_barrier(commands);
        parts_.drawn->record(commands, resources_, rows);
      }
      vk::full_barrier(commands);
      over_tiles(commands, parts_.mix, rows);
      vk::full_barrier(commands);
    }
    parts_.blend.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tile_groups(height_), 1);
  }

 private:
  void over_tiles(VkCommandBuffer commands, const BoundPipeline& bound, RowsPush rows) const {
    bound.bind(commands);
    push_rows(commands, bound, rows);
    vkCmdDispatch(commands, tiles_x_, tile_groups(rows.end - rows.first), 1);
  }

  Resources& resources_;
  std::uint32_t tiles_x_;
  int height_;
  int rows_;
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
      return std::vector<std::vector<vk::Spirv>>{{kEdgesComp},       {kBeginedgesComp}, {kEdgebodiesComp},
                                                 {kEdgeobjectsComp}, {kEdgeblocksComp}, {kEdgemixComp},
                                                 {kBlendComp}};
    },
    "smooth edges of solid things"};

}  // namespace footlight::render
