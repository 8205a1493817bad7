// The judge of panes and the sun behind them, in double, from the definition: a place is lit if the path from there
// back to the sun goes through the glass and meets no solid behind it. It shares no formula with
// render/shaders/shared/shaft.h: rays are cut at every line between texels and wherever a plane of light paths along an
// edge of a solid meets them, and between two such places the light is integrated by Gauss-Legendre.
#pragma once

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "render/reference/judge.h"

namespace footlight::render {

// The panes and the sun of a rig.
void add_panes(JudgeScene& scene, const fixtures::Rig& rig, double range_m);

// Light of the sun in the air along a ray up to t_max_m, and of the panes that the ray meets before, cd/m^2.
[[nodiscard]] glm::dvec3 judge_shafts(const JudgeScene& scene, const Ray& ray, double t_max_m);
// Illuminance by the sun at a point of a surface, lx.
[[nodiscard]] glm::dvec3 judge_sun_lux(const JudgeScene& scene, const glm::dvec3& point_m, const glm::dvec3& normal);

}  // namespace footlight::render
