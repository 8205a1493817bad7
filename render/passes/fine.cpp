#include "render/passes/fine.h"

#include <cstddef>

#include "render/passes/tile_constants.h"
#include "shaders/fine.comp.h"
#include "shaders/gobofine.comp.h"
#include "shaders/hazefine.comp.h"
#include "shaders/hazegobofine.comp.h"

namespace footlight::render {

const PassEntry kFinePass{"fine",
                          has_tile_classes,
                          tile_class_constants,
                          [](const PassContext& context) {
                            return make_tile_pass(
                                context,
                                tile_spirv(context, kFineComp, kHazefineComp, kGobofineComp, kHazegobofineComp),
                                [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
                                  vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, fine_groups));
                                });
                          },
                          [] {
                            return std::vector<std::vector<vk::Spirv>>{
                                {kFineComp}, {kHazefineComp},
                                {kGobofineComp}, {kHazegobofineComp}};
                          },
                          "beams taken together for 32 x 32 pixels"};

}  // namespace footlight::render
