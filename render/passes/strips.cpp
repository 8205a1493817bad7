#include "render/passes/strips.h"

#include "render/passes/compute_pass.h"
#include "shaders/strips.comp.h"

namespace footlight::render {

const PassEntry kStripsPass{"strips",
                            has_strips,
                            [](const fixtures::Needs& needs, const FrameSettings& settings) {
                              return std::vector<vk::SpecConstant>{{FL_SPEC_EXTINCTION, needs.extinction},
                                                                   {FL_SPEC_BOXES, needs.surfaces},
                                                                   {FL_SPEC_BODIES, has_bodies(needs, settings)}};
                            },
                            [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                              const auto tiles = [x = tile_groups(context.settings.width),
                                                  y = tile_groups(context.settings.height)](VkCommandBuffer commands) {
                                vkCmdDispatch(commands, x, y, 1);
                              };
                              return make_compute_pass(context, kStripsComp, tiles);
                            },
                            [] { return std::vector<std::vector<vk::Spirv>>{{kStripsComp}}; },
                            "displays that are thin in the picture"};

}  // namespace footlight::render
