#include "render/passes/shadowtiles.h"

#include <utility>

#include "render/passes/compute_pass.h"
#include "shaders/shadowtiles.comp.h"

namespace footlight::render {
namespace {

class ShadowtilesPass final : public Pass {
 public:
  ShadowtilesPass(BoundPipeline step, const PictureImages& picture) : step_(std::move(step)), picture_(picture) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    vkCmdFillBuffer(commands, picture_.shadow_picks.handle, 0, 8, 0);  // no word is in use
    vk::full_barrier(commands);
    step_.bind(commands);
    vkCmdDispatch(commands, picture_.supertiles_x, picture_.supertiles_y, 1);
  }

 private:
  BoundPipeline step_;
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
      return std::unique_ptr<Pass>(new ShadowtilesPass(std::move(step), context.resources.picture));
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kShadowtilesComp}}; },
    "shadows in the haze"};

}  // namespace footlight::render
