#include "render/passes/depths.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/depths.comp.h"

namespace footlight::render {

const PassEntry kDepthsPass{
    "depths",
    has_tile_depths,
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) {
      // Shadows need them for few beams as well, and lasers without any.
      const bool always = context.resources.rig.has_shadows || context.resources.rig.laser_rows > 0;
      return make_compute_pass(
          context, kDepthsComp,
          [counts = context.resources.rig.counts.handle, always, x = tile_groups(context.settings.width),
           y = tile_groups(context.settings.height)](VkCommandBuffer commands) {
            if (always) vkCmdDispatch(commands, x, y, 1);
            else vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, depths_groups));
          });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kDepthsComp}}; },
    "beams taken together for a tile that shows one plane, and what of a shadow is visible there"};

}  // namespace footlight::render
