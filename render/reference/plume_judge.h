// Plumes of machines for the judge of pictures: densities and losses in double, apart from the table of the picture.
#pragma once

#include "render/haze.h"
#include "render/reference/judge.h"

namespace footlight::render {

// Adds plumes to the density of a scene whose haze is that of the room; from then on haze.scattering_per_m is that of a
// density of 1. Light is lost in them on its way to the eye.
void add_plumes(JudgeScene& scene, const PlumeField& plumes);

// Optical depth of the puffs between the ray's origin and a distance, without noise.
[[nodiscard]] double plume_depth(const PlumeField& plumes, const Ray& ray, double t_m);

}  // namespace footlight::render
