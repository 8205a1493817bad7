// Scenes that the report generates instead of loading them.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/plume.h"

namespace footlight::tools {

// A rig with levels and a camera.
struct Scene {
  std::string name;
  fixtures::Rig rig;
  fixtures::CompiledRig compiled;
  std::vector<std::uint8_t> levels;  // universes x 512, in the order of compiled.universes
  fixtures::Camera camera;
  std::vector<fixtures::PlumePuff> puffs;  // of machines that have run before
};

// Generates `count` lit beams over an arena, 1 to 1,000,000. The same count gives the same scene. Half angles: 70 %
// 0.75 to 2.5 degrees, 20 % 5 to 10, 10 % 12 to 25. Lenses: 5 to 12 cm. Four fifths hang 12 to 16 m up, the others are
// on the floor. The camera is 40 m in front. This is the mix of a large show, with one profile (m = 1) and no gobos.
// `photometry`: an IES or EULUMDAT file whose light all beams have, with unchanged half angles; empty: none.
// `gobo_share`: so many of the beams, 0 to 1, have one of the eight built-in gobos, turned at random; with two `wheels`
// one of eight pairs of them. `clutter`: so many boxes of 0.3 to 2 m stand on the floor.
[[nodiscard]] Result<Scene> make_beams_scene(int count, const std::string& photometry = {}, double gobo_share = 0,
                                             int clutter = 0, int wheels = 1);

}  // namespace footlight::tools
