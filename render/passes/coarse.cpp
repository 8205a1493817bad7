#include "render/passes/coarse.h"

#include <cstddef>

#include "render/passes/tile_constants.h"
#include "shaders/coarse.comp.h"
#include "shaders/hazecoarse.comp.h"

namespace footlight::render {

const PassEntry kCoarsePass{
    "coarse",
    has_tile_classes,
    tile_class_constants,
    [](const PassContext& context) {
      return make_tile_pass(context,
                            has_constant(context, FL_SPEC_HAZE) ? vk::Spirv(kHazecoarseComp) : vk::Spirv(kCoarseComp),
                            [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                              vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, coarse_groups));
                            });
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kCoarseComp}, {kHazecoarseComp}};
    },
    "beams taken together for 64 x 64 pixels"};

}  // namespace footlight::render
