#include "render/passes/gather.h"

#include "render/passes/compute_pass.h"
#include "shaders/gather.comp.h"

namespace footlight::render {

const PassEntry kGatherPass{
    "gather",
    [](const fixtures::Needs& needs, const FrameSettings&) { return needs.fixtures; },
    [](const fixtures::Needs& needs, const FrameSettings&) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_OPTICS, needs.optics},     {FL_SPEC_PROFILE, needs.profile},
                                           {FL_SPEC_WIDE, needs.wide},         {FL_SPEC_IRIS, needs.iris},
                                           {FL_SPEC_STACKED, needs.stacked},   {FL_SPEC_BLADES, needs.blades},
                                           {FL_SPEC_MEASURED, needs.measured}, {FL_SPEC_RECTANGLE, needs.rectangle}};
    },
    [](const PassContext& context) {
      return make_compute_pass(context, kGatherComp,
                               [groups = context.resources.rig.head_groups](VkCommandBuffer commands) {
                                 vkCmdDispatch(commands, groups, 1, 1);
                               });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kGatherComp}}; },
    "beams of any kind",
    nullptr,
    true};

}  // namespace footlight::render
