#include "render/passes/depths.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/depths.comp.h"

namespace footlight::render {

const PassEntry kDepthsPass{
    "depths",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return has_tile_classes(needs, settings) && has_solids(needs, settings);
    },
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) {
      return make_compute_pass(context, kDepthsComp,
                               [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                 vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, depths_groups));
                               });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kDepthsComp}}; },
    "beams taken together for a tile that shows one plane"};

}  // namespace footlight::render
