#include "render/reference/gloss_judge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace footlight::render {
namespace {

constexpr double kOnTopM = 1e-6;

// The van der Corput sequence of base 2.
double turned_round(std::uint32_t bits) {
  double value = 0;
  for (double digit = 0.5; bits != 0; bits >>= 1, digit /= 2) value += (bits & 1u) != 0 ? digit : 0;
  return value;
}

}  // namespace

const fixtures::GlossTop* gloss_at(const JudgeScene& scene, const glm::dvec3& point_m) {
  const auto found = std::find_if(scene.glosses.begin(), scene.glosses.end(), [&](const fixtures::GlossTop& top) {
    const glm::dvec3 from = point_m - top.center_m;
    const glm::dvec2 at(from.x, from.y);
    return std::abs(from.z) < kOnTopM && std::abs(glm::dot(at, top.half_x_m)) <= glm::dot(top.half_x_m, top.half_x_m) &&
           std::abs(glm::dot(at, top.half_y_m)) <= glm::dot(top.half_y_m, top.half_y_m);
  });
  return found != scene.glosses.end() ? &*found : nullptr;
}

double gloss_share(const fixtures::Gloss& gloss, double cosine) {
  return gloss.share + (1 - gloss.share) * std::pow(std::clamp(1 - cosine, 0.0, 1.0), 5);
}

glm::dvec3 mirrored_mean(const fixtures::Gloss& gloss, const glm::dvec3& way, int rays, const LightFrom& light) {
  const int count = gloss.roughness > 0 ? std::max(rays, 1) : 1;
  glm::dvec3 sum(0);
  double weights = 0;
  for (int i = 0; i < count; ++i) {
    // Two normal deviates (Box and Muller 1958); the radius is in the first coordinate, which is never 0.
    const double radius = gloss.roughness * std::sqrt(-std::log((i + 0.5) / count));
    const double angle = 2 * std::numbers::pi * turned_round(static_cast<std::uint32_t>(i));
    const glm::dvec3 slopes =
        gloss.roughness > 0 ? radius * glm::dvec3(std::cos(angle), std::sin(angle), 0) : glm::dvec3(0);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0, 0, 1) - slopes);
    const double shown = -glm::dot(way, normal) / normal.z;
    const glm::dvec3 direction = glm::reflect(way, normal);
    if (!(shown > 0) || !(direction.z > 0)) continue;
    sum += shown * light(direction);
    weights += shown;
  }
  return weights > 0 ? sum / weights : glm::dvec3(0);
}

}  // namespace footlight::render
