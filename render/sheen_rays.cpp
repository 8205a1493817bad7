#include "render/sheen_rays.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "render/probe.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

using glm::dvec3;

constexpr int kShareSamples = 256;

// The bits behind the point in the order of those before it.
double radical_inverse(std::uint32_t i) {
  double value = 0, digit = 0.5;
  for (; i != 0; i >>= 1, digit *= 0.5) value += digit * (i & 1u);
  return value;
}

// Smith's Lambda of GGX.
double lambda(double alpha, double cosine) {
  const double square = std::max(cosine * cosine, 1e-12);
  return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - square) / square) - 1);
}

dvec3 visible_facet(double alpha, const dvec3& to_eye, double x, double y) {
  const dvec3 view = glm::normalize(dvec3(alpha * to_eye.x, alpha * to_eye.y, to_eye.z));
  const double across = view.x * view.x + view.y * view.y;
  const dvec3 u = across > 0 ? dvec3(-view.y, view.x, 0) / std::sqrt(across) : dvec3(1, 0, 0);
  const dvec3 v = glm::cross(view, u);
  const double r = std::sqrt(x), angle = 2 * std::numbers::pi * y;
  const double a = r * std::cos(angle), half = 0.5 * (1 + view.z);
  const double b = (1 - half) * std::sqrt(1 - a * a) + half * r * std::sin(angle);
  const dvec3 facet = a * u + b * v + std::sqrt(std::max(0.0, 1 - a * a - b * b)) * view;
  return glm::normalize(dvec3(alpha * facet.x, alpha * facet.y, std::max(0.0, facet.z)));
}

}  // namespace

std::vector<SheenRay> sheen_rays(double alpha, double cosine, int count) {
  FL_CHECK(alpha > 0 && count > 0);
  const double facing = std::clamp(cosine, 1e-3, 1.0);  // as kSheenFacingLeast
  const dvec3 to_eye(std::sqrt(1 - facing * facing), 0, facing);
  const double eye_lambda = lambda(alpha, facing);
  std::vector<SheenRay> rays(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    SheenRay& ray = rays[static_cast<std::size_t>(i)];
    const dvec3 facet = visible_facet(alpha, to_eye, (i + 0.5) / count, radical_inverse(static_cast<std::uint32_t>(i)));
    const double along = std::clamp(glm::dot(to_eye, facet), 0.0, 1.0);
    ray.way = 2 * along * facet - to_eye;
    ray.fresnel = std::pow(1 - along, 5);
    if (ray.way.z > 0) ray.share = (1 + eye_lambda) / (1 + eye_lambda + lambda(alpha, ray.way.z));
  }
  return rays;
}

glm::dvec2 sheen_shares(double alpha, double cosine, int samples) {
  glm::dvec2 sum(0);
  for (const SheenRay& ray : sheen_rays(alpha, cosine, samples)) {
    sum += ray.share * glm::dvec2(1 - ray.fresnel, ray.fresnel);
  }
  return sum / static_cast<double>(samples);
}

std::vector<vec4> probe_share_table() {
  std::vector<vec4> table;
  constexpr double kSteps = FL_PROBE_SHARES - 1;
  for (int row = 0; row < FL_PROBE_SHARES; ++row) {
    for (int column = 0; column < FL_PROBE_SHARES; ++column) {
      // The places of probe_share_place(): roughness and the root of the cosine.
      const double alpha = std::max(std::pow(column / kSteps, 2), 1e-4);
      table.emplace_back(glm::vec2(sheen_shares(alpha, std::pow(row / kSteps, 2), kShareSamples)), 0, 0);
    }
  }
  return table;
}

glm::dvec2 table_shares(const std::vector<vec4>& table, double alpha, double cosine) {
  const glm::dvec2 at = f64::probe_share_place(alpha, cosine) * static_cast<double>(FL_PROBE_SHARES - 1);
  const glm::dvec2 low = glm::min(glm::floor(at), glm::dvec2(FL_PROBE_SHARES - 2));
  const glm::dvec2 share = at - low;
  const auto first = static_cast<std::size_t>(low.y) * FL_PROBE_SHARES + static_cast<std::size_t>(low.x);
  const auto row = [&](std::size_t from) {
    return glm::mix(glm::dvec2(table[from]), glm::dvec2(table[from + 1]), share.x);
  };
  return glm::mix(row(first), row(first + FL_PROBE_SHARES), share.y);
}

}  // namespace footlight::render
