// Light that surfaces reflect to each other, by paths that are traced from where it arrives, in double. It has no
// patches, no probes and no form factors (render/bounce_tables.h): each path goes from surface to surface in directions
// drawn by the cosine, and at each surface takes the light that lamps bring there.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "render/reference/judge.h"

namespace footlight::render {

struct PathScene {
  std::vector<fixtures::StageBox> boxes;
  std::vector<glm::dvec3> emitted;  // of each box, evenly from all faces, lm/m^2; empty: none emits
  // Illuminance of a surface at a point by lamps; empty: there are none.
  std::function<glm::dvec3(const glm::dvec3& point_m, const glm::dvec3& normal)> direct_lx;
  RayHit hit = {};  // what paths meet instead of the boxes, and what emits nothing; empty: the boxes
};

// The boxes and the lamps of a judged scene, with their shadows, and what else stands there. The scene must live as
// long.
[[nodiscard]] PathScene path_scene(const JudgeScene& scene);

struct PathOptions {
  int side = 16;     // side x side paths, one in each cell of the square that directions are drawn from
  int bounces = 12;  // surfaces that a path goes to
  std::uint64_t seed = 1;
  int threads = 0;  // of judge_reflected(); 0: one per core. The result does not depend on it.
};

// Illuminance at a point by what surfaces reflect and emit.
[[nodiscard]] glm::dvec3 judge_bounced(const PathScene& scene, const glm::dvec3& point_m, const glm::dvec3& normal,
                                       const PathOptions& options = {});

// The same as what a judged scene gets by it: by paths that are other ones at each place. The result does not depend on
// the order of calls. `scene` must live as long.
[[nodiscard]] BouncedLux bounced_lx_of(const PathScene& scene, int bounces);

// What that adds to the pixels of a picture, 3 values a pixel, cd/m^2; in haze, as it arrives.
[[nodiscard]] std::vector<double> judge_reflected(const PathScene& scene, const fixtures::Haze& haze, const View& view,
                                                  int width, int height, const PathOptions& options = {});

}  // namespace footlight::render
