#include "render/passes/rims.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/rims.comp.h"

namespace footlight::render {

const PassEntry kRimsPass{"rims",
                          has_tile_classes,
                          [](const fixtures::Needs& needs, const FrameSettings& settings) {
                            return std::vector<vk::SpecConstant>{
                                {FL_SPEC_PROFILE, needs.profile},
                                {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
                          },
                          [](const PassContext& context) {
                            return make_compute_pass(
                                context, kRimsComp,
                                [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                  vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, fine_groups));
                                });
                          },
                          [] { return std::vector<std::vector<vk::Spirv>>{{kRimsComp}}; },
                          "beams with a rim taken together for 64 x 64 pixels"};

}  // namespace footlight::render
