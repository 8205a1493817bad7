#include "render/passes/tonemap.h"

#include "render/passes/compute_pass.h"
#include "shaders/glaretone.comp.h"
#include "shaders/tonemap.comp.h"

namespace footlight::render {

const PassEntry kTonemapPass{
    "tonemap",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return needs.fixtures || has_solids(needs, settings);
    },
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) {
      const bool glare = context.resources.picture.glare.handle != VK_NULL_HANDLE;
      return make_compute_pass(context, glare ? vk::Spirv(kGlaretoneComp) : vk::Spirv(kTonemapComp),
                               [x = tile_groups(context.settings.width / context.settings.supersample),
                                y = tile_groups(context.settings.height / context.settings.supersample)](
                                   VkCommandBuffer commands) { vkCmdDispatch(commands, x, y, 1); });
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kTonemapComp}, {kGlaretoneComp}};
    },
    "anything to see"};

}  // namespace footlight::render
