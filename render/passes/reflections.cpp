#include "render/passes/reflections.h"

#include "render/passes/compute_pass.h"
#include "shaders/reflections.comp.h"

namespace footlight::render {

const PassEntry kReflectionsPass{
    "reflections",
    has_probes,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_EXTINCTION, needs.extinction},
                                           {FL_SPEC_BOXES, needs.surfaces},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_BOUNCE, has_bounce(needs, settings)},
                                           {FL_SPEC_GLOSS, has_gloss(needs, settings)},
                                           {FL_SPEC_SHEEN, has_sheen(needs, settings)}};
    },
    [](const PassContext& context) {
      return make_compute_pass(context, kReflectionsComp,
                               [x = tile_groups(context.settings.width), y = tile_groups(context.settings.height)](
                                   VkCommandBuffer commands) { vkCmdDispatch(commands, x, y, 1); });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kReflectionsComp}}; },
    "what shiny surfaces mirror of the stage"};

}  // namespace footlight::render
