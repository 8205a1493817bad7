#include "render/passes/coarse.h"

#include <cstddef>

#include "render/passes/tile_constants.h"
#include "shaders/coarse.comp.h"
#include "shaders/gobocoarse.comp.h"
#include "shaders/hazecoarse.comp.h"
#include "shaders/hazegobocoarse.comp.h"

namespace footlight::render {

const PassEntry kCoarsePass{
    "coarse",
    has_tile_classes,
    tile_class_constants,
    [](const PassContext& context) {
      return make_tile_pass(context,
                            tile_spirv(context, kCoarseComp, kHazecoarseComp, kGobocoarseComp, kHazegobocoarseComp),
                            [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                              vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, coarse_groups));
                            });
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{
          {kCoarseComp}, {kHazecoarseComp},
          {kGobocoarseComp}, {kHazegobocoarseComp}};
    },
    "beams taken together for 64 x 64 pixels"};

}  // namespace footlight::render
