#include "render/passes/shade.h"

#include <cstddef>

#include "render/passes/tile_constants.h"
#include "shaders/hazeshade.comp.h"
#include "shaders/shade.comp.h"

namespace footlight::render {

const PassEntry kShadePass{
    "shade",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return has_tile_classes(needs, settings) && has_shadows(needs, settings) &&
             settings.view == FrameView::kPicture;
    },
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      std::vector<vk::SpecConstant> constants = tile_class_constants(needs, settings);
      for (vk::SpecConstant& constant : constants) {
        if (constant.id == FL_SPEC_NODES) constant.value = settings.nodes;
      }
      return constants;
    },
    [](const PassContext& context) {
      return make_tile_pass(context,
                            has_constant(context, FL_SPEC_HAZE) ? vk::Spirv(kHazeshadeComp) : vk::Spirv(kShadeComp),
                            [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                              vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, fine_groups));
                            });
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kShadeComp}, {kHazeshadeComp}};
    },
    "shadows of beams taken together"};

}  // namespace footlight::render
