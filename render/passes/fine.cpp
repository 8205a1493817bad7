#include "render/passes/fine.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "render/passes/tile_constants.h"
#include "shaders/fine.comp.h"

namespace footlight::render {

const PassEntry kFinePass{"fine",
                          has_tile_classes,
                          tile_class_constants,
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
