// What a surface with sheen mirrors, in double: rays from the place itself, one a facet (render/sheen_rays.h), with
// whatever light they meet. There is no map, no box and no level of roughness.
#pragma once

#include "render/reference/gloss_judge.h"

namespace footlight::render {

// Light to the eye, cd/m^2. way: of the ray from the eye, unit, into the surface. Its error falls about as 1 / rays
// where the light is smooth.
[[nodiscard]] glm::dvec3 judge_mirrored(const fixtures::Sheen& sheen, const glm::dvec3& albedo,
                                        const glm::dvec3& normal, const glm::dvec3& way, int rays,
                                        const LightFrom& light);

}  // namespace footlight::render
