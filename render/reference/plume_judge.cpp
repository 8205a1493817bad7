#include "render/reference/plume_judge.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace footlight::render {

void add_plumes(JudgeScene& scene, const PlumeField& plumes) {
  if (plumes.puffs.empty()) return;
  scene.haze.scattering_per_m = plumes.head.scattering_per_m;
  scene.plumes = plumes;
  scene.density = [even = std::move(scene.density), plumes](const glm::dvec3& place_m) {
    double density = plumes.head.even_share * (even ? even(place_m) : 1);
    for (const f64::HazePuff& puff : plumes.puffs) {
      const double of_puff = f64::haze_puff_density(puff, place_m);
      if (of_puff < 1e-12) continue;
      density += of_puff * f64::haze_plume_factor(puff.axis, puff.plume, plumes.head.shift_m, place_m, 0);
    }
    return density;
  };
}

double plume_depth(const PlumeField& plumes, const Ray& ray, double t_m) {
  double sum = 0;
  for (const f64::HazePuff& puff : plumes.puffs) {
    const glm::dvec3 at = f64::haze_puff_scaled(puff, ray.origin_m - puff.center);
    const glm::dvec3 way = f64::haze_puff_scaled(puff, ray.direction);
    const double slope = glm::length(way);
    const double nearest = -glm::dot(at, way) / (slope * slope);
    const glm::dvec3 off = at + nearest * way;
    const double root = slope / std::numbers::sqrt2;
    sum += puff.peak * std::exp(-0.5 * glm::dot(off, off)) * std::sqrt(std::numbers::pi) / (2 * root) *
           (std::erf(root * (t_m - nearest)) - std::erf(-root * nearest));
  }
  return plumes.head.scattering_per_m * sum;
}

}  // namespace footlight::render
