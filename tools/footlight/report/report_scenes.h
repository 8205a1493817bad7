// Scenes for the report that are made, not loaded.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/model/rig.h"

namespace footlight::tools {

// A rig with the levels to look at it.
struct Scene {
  std::string name;
  fixtures::Rig rig;
  fixtures::CompiledRig compiled;
  std::vector<std::uint8_t> levels;  // universes x 512, as compiled.universes orders them
  fixtures::Camera camera;
};

// `count` beams over an arena, all lit, the same for the same count: 70 % with half angles of 0.75 to 2.5 degrees, 20 %
// 5 to 10, 10 % 12 to 25; lenses 5 to 12 cm; four fifths hang 12 to 16 m up, the rest stand on the floor; seen from 40
// m in front. The mix of a large show, with one profile (m = 1) and no gobos. 1 to 1,000,000 beams.
// `photometry`: an IES or EULUMDAT file whose light they throw instead, ending where theirs would; empty: none.
[[nodiscard]] Result<Scene> make_beams_scene(int count, const std::string& photometry = {});

}  // namespace footlight::tools
