// What the passes that classify beams for tiles (render/shaders/lib/tile_class.glsl) are specialised by.
#pragma once

#include <vector>

#include "render/pass.h"

namespace footlight::render {

[[nodiscard]] inline std::vector<vk::SpecConstant> tile_class_constants(const fixtures::Needs& needs,
                                                                        const FrameSettings& settings) {
  return {{FL_SPEC_GOBO, needs.gobo},
          {FL_SPEC_EXTINCTION, needs.extinction},
          {FL_SPEC_PROFILE, needs.profile},
          {FL_SPEC_NODES, settings.nodes > 3 ? 5u : 3u},  // tile_node() has these two rules
          {FL_SPEC_BOXES, needs.surfaces},
          {FL_SPEC_BODIES, has_bodies(needs, settings)},
          {FL_SPEC_MEASURED, needs.measured},
          {FL_SPEC_RECTANGLE, needs.rectangle},
          {FL_SPEC_WIDE, needs.wide},
          {FL_SPEC_IRIS, needs.iris}};
}

}  // namespace footlight::render
