#include "render/rivals/shaft_march.h"

#include <algorithm>

#include "render/passes/shafts.h"
#include "render/rivals/rival_pass.h"
#include "shaders/shaftmarch.comp.h"
#include "shaders/shaftmasks.comp.h"

namespace footlight::render {

const PassEntry kShaftMarchPass{
    "shaft march",
    has_shafts,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      std::vector<vk::SpecConstant> constants = kShaftsPass.constants(needs, settings);
      constants.push_back({FL_SPEC_NODES, settings.nodes});
      return constants;
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      auto pass = std::make_unique<RivalPass>(context);
      const RigTables& rig = context.resources.rig;
      if (has_constant(context, FL_SPEC_SHADOWS)) {
        FL_TRY(pass->add_compute(kShaftmasksComp, [words = rig.occluder_words,
                                                   panes = rig.pane_count](VkCommandBuffer commands) {
          vkCmdDispatch(commands, groups_of(words, FL_GROUP_SHAFTS), panes, 1);
        }));
      }
      FL_TRY(pass->add_compute(kShaftmarchComp, [x = tile_groups(context.settings.width),
                                                 y = tile_groups(context.settings.height)](VkCommandBuffer commands) {
        vkCmdDispatch(commands, x, y, 1);
      }));
      return pass;
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kShaftmasksComp}, {kShaftmarchComp}};
    },
    "light in the haze"};

const Rival kShaftMarch{"shaft march",
                        {30, 100, 300},
                        {30, 300},
                        "a march with equal steps through the box of each shaft",
                        false,
                        true,
                        false,
                        [] {
                          PassList list = product_passes();
                          std::replace(list.begin(), list.end(), &kShaftsPass, &kShaftMarchPass);
                          return list;
                        },
                        rival_settings,
                        false,
                        true};

}  // namespace footlight::render
