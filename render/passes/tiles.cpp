#include "render/passes/tiles.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/tiles.comp.h"

namespace footlight::render {

const PassEntry kTilesPass{"tiles",
                           [](const fixtures::Needs& needs, const FrameSettings& settings) {
                             return needs.fixtures && (needs.haze || has_solids(needs, settings));
                           },
                           [](const fixtures::Needs& needs, const FrameSettings&) {
                             return std::vector<vk::SpecConstant>{{FL_SPEC_RECTANGLE, needs.rectangle}};
                           },
                           [](const PassContext& context) {
                             return make_compute_pass(
                                 context, kTilesComp,
                                 [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                   vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, tiles_groups));
                                 });
                           },
                           [] { return std::vector<std::vector<vk::Spirv>>{{kTilesComp}}; },
                           "beams on surfaces and in haze"};

}  // namespace footlight::render
