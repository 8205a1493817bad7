// What the passes that classify beams for tiles (render/shaders/lib/tile_class.glsl) are specialised by.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "render/passes/compute_pass.h"

namespace footlight::render {

[[nodiscard]] inline std::vector<vk::SpecConstant> tile_class_constants(const fixtures::Needs& needs,
                                                                        const FrameSettings& settings) {
  return with_plumes(needs.plumes, {{FL_SPEC_EXTINCTION, needs.extinction},
                                    {FL_SPEC_PROFILE, needs.profile},
                                    {FL_SPEC_GOBO, has_gobo_tables(needs, settings)},
                                    {FL_SPEC_NODES, settings.nodes > 3 ? 5u : 3u},  // tile_node() has these two rules
                                    {FL_SPEC_BOXES, needs.surfaces},
                                    {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                    {FL_SPEC_MEASURED, needs.measured},
                                    {FL_SPEC_RECTANGLE, needs.rectangle},
                                    {FL_SPEC_WIDE, needs.wide},
                                    {FL_SPEC_IRIS, needs.iris},
                                    {FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                    {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                    {FL_SPEC_PENUMBRA, lens_points(needs, settings)},
                                    {FL_SPEC_HAZE, uneven_haze(needs)},
                                    {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}});
}

// Which of four shaders a pass of teams is: with gobos, and in haze that is not even.
[[nodiscard]] inline vk::Spirv tile_spirv(const PassContext& context, vk::Spirv plain, vk::Spirv haze, vk::Spirv gobo,
                                          vk::Spirv haze_gobo) {
  const bool uneven = has_constant(context, FL_SPEC_HAZE);
  if (has_constant(context, FL_SPEC_GOBO)) return uneven ? haze_gobo : gobo;
  return uneven ? haze : plain;
}

// A pass of teams (render/shaders/lib/tile_team.glsl), whose size follows the device's subgroups.
template <class Dispatch>
[[nodiscard]] Result<std::unique_ptr<Pass>> make_tile_pass(const PassContext& context, vk::Spirv spirv,
                                                           Dispatch dispatch) {
  const std::uint32_t team = std::min(vk::compute_subgroup_size(context.device.facts()), 16u);
  std::vector<vk::SpecConstant> constants = context.constants;
  constants.push_back({FL_SPEC_TEAM, team});
  return make_compute_pass(
      {context.device, context.resources, context.settings, std::move(constants), context.only_pipelines}, spirv,
      std::move(dispatch));
}

}  // namespace footlight::render
