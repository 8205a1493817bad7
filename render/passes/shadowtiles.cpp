#include "render/passes/shadowtiles.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "render/passes/compute_pass.h"
#include "render/shaders/shared/shadow_map.h"
#include "shaders/maprows.comp.h"
#include "shaders/shadowtiles.comp.h"

namespace footlight::render {
namespace {

class ShadowtilesPass final : public Pass {
 public:
  ShadowtilesPass(BoundPipeline step, std::optional<BoundPipeline> rows, const Resources& resources)
      : step_(std::move(step)), rows_(std::move(rows)), rig_(resources.rig), picture_(resources.picture) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    if (rows_) {  // they are for this view's camera; nothing before the beam passes reads them
      rows_->bind(commands);
      vkCmdDispatchIndirect(commands, rig_.counts.handle, offsetof(CountsRow, shadow_groups));
    }
    vkCmdFillBuffer(commands, picture_.shadow_picks.handle, 0, 8, 0);  // no word is in use
    vk::full_barrier(commands);
    step_.bind(commands);
    vkCmdDispatch(commands, picture_.supertiles_x, picture_.supertiles_y, 1);
  }

 private:
  BoundPipeline step_;
  std::optional<BoundPipeline> rows_;
  const RigTables& rig_;
  const PictureImages& picture_;
};

}  // namespace

const PassEntry kShadowtilesPass{
    "shadowtiles",
    has_shadows_in_air,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_RECTANGLE, needs.rectangle},
                                           {FL_SPEC_BOXES, needs.surfaces},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                           {FL_SPEC_PENUMBRA, lens_points(needs, settings)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(BoundPipeline step, BoundPipeline::compute(context, kShadowtilesComp, context.constants));
      std::optional<BoundPipeline> rows;
      if (context.resources.rig.shadow_map_px == FL_MAP_ROWS) {
        FL_ASSIGN(rows, BoundPipeline::compute(context, kMaprowsComp, context.constants));
      }
      return std::unique_ptr<Pass>(new ShadowtilesPass(std::move(step), std::move(rows), context.resources));
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kShadowtilesComp}, {kMaprowsComp}}; },
    "shadows in the haze"};

}  // namespace footlight::render
