// The judge of displays, in double, from the definition: every pixel is a rectangle that shines equally in all
// directions of its side, and is integrated by Gauss-Legendre over parts that are small as they are seen. It has no
// levels of cells and shares no formula with render/shaders/shared/display.h. Nothing hides the light of displays.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "render/reference/judge.h"

namespace footlight::render {

// The displays of a rig with the levels `given` to its pixel maps and to the fixtures that dim them: universes x 512
// bytes, as the compiled rig orders them; empty: all are 0.
void add_displays(JudgeScene& scene, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                  std::span<const std::uint8_t> given);

// Makes display_lights: the displays with fewer and larger pixels, about `most` of all together, so that rays that meet
// them by the thousand take less time.
void join_display_lights(JudgeScene& scene, int most);

// Light of displays in the air along a ray up to t_max_m, which may be infinite, and of a pixel that the ray meets
// before, cd/m^2.
[[nodiscard]] glm::dvec3 judge_displays(const JudgeScene& scene, const Ray& ray, double t_max_m);
// Illuminance by displays at a point of a surface, lx.
[[nodiscard]] glm::dvec3 judge_display_lux(const JudgeScene& scene, const glm::dvec3& point_m,
                                           const glm::dvec3& normal);

}  // namespace footlight::render
