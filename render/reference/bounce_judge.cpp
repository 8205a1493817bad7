#include "render/reference/bounce_judge.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

#include "render/reference/cores.h"
#include "sim/core/random.h"

namespace footlight::render {
namespace {

using glm::dvec3;

constexpr std::size_t kNoBox = static_cast<std::size_t>(-1);
struct PathHit {
  std::size_t box = kNoBox;
  dvec3 point_m{0};
  dvec3 normal{0};
  dvec3 albedo{0};
};

// The nearest box that a ray enters: the first of its three near faces whose place is within the face.
std::optional<PathHit> path_hit(const PathScene& scene, const dvec3& from, const dvec3& way) {
  if (scene.hit) {
    const std::optional<SurfaceHit> other = scene.hit({from, way});
    if (!other) return {};
    return PathHit{kNoBox, from + other->t_m * way, other->normal, other->albedo};
  }
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<PathHit> hit;
  for (std::size_t b = 0; b < scene.boxes.size(); ++b) {
    const fixtures::StageBox& box = scene.boxes[b];
    for (int axis = 0; axis < 3; ++axis) {
      if (way[axis] == 0) continue;
      const double side = way[axis] > 0 ? box.min_m[axis] : box.max_m[axis];
      const double t = (side - from[axis]) / way[axis];
      if (!(t > 1e-9) || t >= nearest) continue;
      dvec3 point = from + t * way;
      point[axis] = side;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (point[u] < box.min_m[u] || point[u] > box.max_m[u] || point[v] < box.min_m[v] || point[v] > box.max_m[v]) {
        continue;
      }
      nearest = t;
      hit = PathHit{b, point, dvec3(0), box.albedo};
      hit->normal[axis] = way[axis] > 0 ? -1 : 1;
    }
  }
  return hit;
}

// A direction by the cosine (Malley's method).
dvec3 direction_of(const dvec3& normal, double x, double y) {
  const dvec3 side = std::abs(normal.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  const dvec3 u = glm::normalize(glm::cross(normal, side));
  const dvec3 v = glm::cross(normal, u);
  const double r = std::sqrt(x), angle = 2 * std::numbers::pi * y;
  return glm::normalize(r * std::cos(angle) * u + r * std::sin(angle) * v + std::sqrt(1 - x) * normal);
}

}  // namespace

PathScene path_scene(const JudgeScene& scene) {
  PathScene paths;
  paths.boxes = scene.boxes;
  if (scene.others) paths.hit = [&scene](const Ray& ray) { return judge_hit(scene, ray); };
  paths.direct_lx = [&scene](const dvec3& point_m, const dvec3& normal) {
    dvec3 lx(0);
    for (const JudgeBeam& beam : scene.beams) {
      dvec3 share(judge_illuminance(beam, scene.haze, point_m, normal, scene.gobo));
      for (int c = 0; scene.colors && c < 3; ++c) {
        const GoboTransmission through = [&](int gobo, double x, double y) { return scene.colors(gobo, x, y)[c]; };
        share[c] = judge_illuminance(beam, scene.haze, point_m, normal, through);
      }
      if (!(share.x + share.y + share.z > 0)) continue;
      const bool hidden = std::any_of(scene.solids.begin(), scene.solids.end(),
                                      [&](const JudgeSolid& solid) { return judge_hides(beam, solid, point_m); });
      if (!hidden) lx += share * beam.strength_lm;
    }
    return lx;
  };
  return paths;
}

dvec3 judge_bounced(const PathScene& scene, const dvec3& point_m, const dvec3& normal, const PathOptions& options) {
  SeededNumbers numbers(options.seed);
  dvec3 sum(0);
  for (int cell = 0; cell < options.side * options.side; ++cell) {
    dvec3 from = point_m, facing = normal, through(1);
    for (int bounce = 0; bounce < options.bounces; ++bounce) {
      double x = numbers.uniform(), y = numbers.uniform();
      if (bounce == 0) {
        const int row = cell / options.side;
        x = (cell % options.side + x) / options.side;
        y = (row + y) / options.side;
      }
      const std::optional<PathHit> hit = path_hit(scene, from, direction_of(facing, x, y));
      if (!hit) break;
      if (!scene.emitted.empty() && hit->box != kNoBox) sum += through * scene.emitted[hit->box];
      through *= hit->albedo;
      if (scene.direct_lx) sum += through * scene.direct_lx(hit->point_m, hit->normal);
      from = hit->point_m;
      facing = hit->normal;
    }
  }
  return sum / static_cast<double>(options.side * options.side);
}

BouncedLux bounced_lx_of(const PathScene& scene, int bounces) {
  return [&scene, bounces](const dvec3& point_m, const dvec3& normal, int side) {
    std::uint64_t seed = 1;
    for (int c = 0; c < 3; ++c) seed = mixed_bits(seed + std::bit_cast<std::uint64_t>(point_m[c]));
    return judge_bounced(scene, point_m, normal, {.side = side, .bounces = bounces, .seed = seed});
  };
}

std::vector<double> judge_reflected(const PathScene& scene, const fixtures::Haze& haze, const View& view, int width,
                                    int height, const PathOptions& options) {
  std::vector<double> rgb(static_cast<std::size_t>(3 * width) * static_cast<std::size_t>(height));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int y = next++; y < height; y = next++) {
      for (int x = 0; x < width; ++x) {
        const Ray ray = pixel_ray(view, width, height, x, y);
        const std::optional<PathHit> hit = path_hit(scene, ray.origin_m, ray.direction);
        if (!hit) continue;
        PathOptions own = options;
        const int pixel = y * width + x;
        own.seed = options.seed + 0x51ed2701u * static_cast<std::uint64_t>(pixel + 1);
        const dvec3 lx = judge_bounced(scene, hit->point_m, hit->normal, own);
        const double through =
            std::exp(-(haze.scattering_per_m + haze.absorption_per_m) * glm::distance(ray.origin_m, hit->point_m));
        const dvec3 seen = through / std::numbers::pi * hit->albedo * lx;
        for (int c = 0; c < 3; ++c) rgb[static_cast<std::size_t>(3 * pixel + c)] = seen[c];
      }
    }
  };
  on_threads(options.threads, work);
  return rgb;
}

}  // namespace footlight::render
