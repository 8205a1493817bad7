#include "render/reference/probe_judge.h"

#include <cmath>

#include "render/probe.h"
#include "render/sheen_rays.h"

namespace footlight::render {

glm::dvec3 judge_mirrored(const fixtures::Sheen& sheen, const glm::dvec3& albedo, const glm::dvec3& normal,
                          const glm::dvec3& way, int rays, const LightFrom& light) {
  using glm::dvec3;
  const f64::Sheen own = f64::sheen_of(albedo, albedo, sheen.roughness, sheen.metal);
  const dvec3 to_eye = -way;
  const double cosine = glm::dot(normal, to_eye);
  dvec3 across = to_eye - cosine * normal;
  if (!(glm::length(across) > 1e-9)) {
    across = glm::cross(normal, std::abs(normal.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0));
  }
  const dvec3 u = glm::normalize(across), v = glm::cross(normal, u);
  dvec3 sum(0);
  for (const SheenRay& ray : sheen_rays(own.alpha, cosine, rays)) {
    if (!(ray.share > 0)) continue;
    const dvec3 share = (own.straight * (1 - ray.fresnel) + ray.fresnel) * ray.share;
    sum += share * light(ray.way.x * u + ray.way.y * v + ray.way.z * normal);
  }
  return sum / static_cast<double>(rays);
}

}  // namespace footlight::render
