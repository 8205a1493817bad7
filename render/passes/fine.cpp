#include "render/passes/fine.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/fine.comp.h"

namespace footlight::render {

const PassEntry kFinePass{"fine",
                          has_tile_classes,
                          [](const fixtures::Needs& needs, const FrameSettings& settings) {
                            return std::vector<vk::SpecConstant>{
                                {FL_SPEC_GOBO, needs.gobo},         {FL_SPEC_EXTINCTION, needs.extinction},
                                {FL_SPEC_PROFILE, needs.profile},   {FL_SPEC_NODES, settings.nodes > 3 ? 5u : 3u},
                                {FL_SPEC_BOXES, needs.surfaces},    {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                {FL_SPEC_MEASURED, needs.measured}, {FL_SPEC_RECTANGLE, needs.rectangle},
                                {FL_SPEC_WIDE, needs.wide},         {FL_SPEC_IRIS, needs.iris}};
                          },
                          [](const PassContext& context) {
                            return make_compute_pass(
                                context, kFineComp,
                                [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                  vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, fine_groups));
                                });
                          },
                          [] { return std::vector<std::vector<vk::Spirv>>{{kFineComp}}; },
                          "beams taken together for 32 x 32 pixels"};

}  // namespace footlight::render
