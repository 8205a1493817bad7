#include "render/passes/boxes.h"

#include "render/passes/compute_pass.h"
#include "shaders/boxes.comp.h"

namespace footlight::render {

const PassEntry kBoxesPass{
    "boxes",
    [](const fixtures::Needs& needs, const FrameSettings&) { return needs.surfaces; },
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_GLOSS, has_gloss(needs, settings)}};
    },
    [](const PassContext& context) {
      return make_compute_pass(context, kBoxesComp,
                               [x = tile_groups(context.settings.width),
                                y = tile_groups(context.settings.height)](VkCommandBuffer commands) {
                                 vkCmdDispatch(commands, x, y, 1);
                               });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kBoxesComp}}; },
    "which box each pixel shows"};

}  // namespace footlight::render
