#include "render/passes/surfaces.h"

#include "render/passes/compute_pass.h"
#include "shaders/surfaces.comp.h"

namespace footlight::render {

const PassEntry kSurfacesPass{
    "surfaces",
    [](const fixtures::Needs& needs, const FrameSettings& settings) { return has_solids(needs, settings); },
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_GOBO, needs.gobo},
                                           {FL_SPEC_EXTINCTION, needs.extinction},
                                           {FL_SPEC_PROFILE, needs.profile},
                                           {FL_SPEC_BOXES, needs.surfaces},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_BLADES, needs.blades},
                                           {FL_SPEC_FOCUS, needs.focus},
                                           {FL_SPEC_ANIMATION, needs.animation},
                                           {FL_SPEC_MEASURED, needs.measured},
                                           {FL_SPEC_RECTANGLE, needs.rectangle},
                                           {FL_SPEC_WIDE, needs.wide},
                                           {FL_SPEC_TILES, settings.tile_error > 0},
                                           {FL_SPEC_IRIS, needs.iris},
                                           {FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                           {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                           {FL_SPEC_PENUMBRA, lens_points(needs, settings)},
                                           {FL_SPEC_BOUNCE, has_bounce(needs, settings)},
                                           {FL_SPEC_LENSES, has_small_lenses(needs, settings)},
                                           {FL_SPEC_GLOSS, has_gloss(needs, settings)},
                                           {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                                           {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
    },
    [](const PassContext& context) {
      // Small subgroups mean a CPU: it executes subgroups one after the other, and stores the state of each at every
      // barrier.
      PassContext sized = context;
      const std::uint32_t wide = context.device.limits().maxComputeWorkGroupInvocations >= 512 ? 512 : 256;
      const bool is_wide = vk::compute_subgroup_size(context.device.facts()) >= 32;
      sized.constants.push_back({FL_SPEC_GROUP, is_wide ? wide : 128u});
      const auto groups = [](int size_px) { return groups_of(static_cast<std::uint32_t>(size_px), FL_SURFACE_PX); };
      return make_compute_pass(sized, kSurfacesComp,
                               [x = groups(context.settings.width), y = groups(context.settings.height)](
                                   VkCommandBuffer commands) { vkCmdDispatch(commands, x, y, 1); });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kSurfacesComp}}; },
    "light on floor, walls and fixtures"};

}  // namespace footlight::render
