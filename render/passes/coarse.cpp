#include "render/passes/coarse.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/coarse.comp.h"

namespace footlight::render {

const PassEntry kCoarsePass{"coarse",
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
                                  context, kCoarseComp,
                                  [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                    vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, coarse_groups));
                                  });
                            },
                            [] { return std::vector<std::vector<vk::Spirv>>{{kCoarseComp}}; },
                            "beams taken together for 64 x 64 pixels"};

}  // namespace footlight::render
