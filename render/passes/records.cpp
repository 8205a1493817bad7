#include "render/passes/records.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/records.comp.h"

namespace footlight::render {

const PassEntry kRecordsPass{
    "records",
    has_tile_classes,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_PROFILE, needs.profile},
                                           {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
    },
    [](const PassContext& context) {
      return make_compute_pass(context, kRecordsComp,
                               [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                 vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, fine_groups));
                               });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kRecordsComp}}; },
    "beams with a rim or cuts taken together for 64 x 64 pixels"};

}  // namespace footlight::render
