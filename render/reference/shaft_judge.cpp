#include "render/reference/shaft_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>

namespace footlight::render {
namespace {

constexpr double kLeastCosine = 1e-4;  // of the sun and a pane; below, the sun lies in its plane
constexpr double kEnteredM = 1e-6;     // a solid hides light that has gone this far in it

double extinction_of(const fixtures::Haze& haze) { return haze.scattering_per_m + haze.absorption_per_m; }

glm::dvec3 texel_of(const fixtures::PaneImage& image, int x, int y) {
  const auto column = static_cast<std::size_t>(std::clamp(x, 0, image.width - 1));
  const auto row = static_cast<std::size_t>(std::clamp(y, 0, image.height - 1));
  return image.texels[row * static_cast<std::size_t>(image.width) + column];
}

// Where on the glass: x from the left and y from the top, 0 to 1 on it.
struct OnGlass {
  double x = 0;
  double y = 0;
  double away_m = 0;  // back along the way that was asked
};

bool is_on(const OnGlass& at) { return at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1; }

// Where the straight way from a place meets the plane of the pane; nothing: it runs along it.
std::optional<OnGlass> on_glass(const JudgePane& pane, const glm::dvec3& place_m, const glm::dvec3& way) {
  const glm::dvec3 normal = glm::normalize(glm::cross(pane.right_m, pane.up_m));
  const double speed = glm::dot(normal, way);
  if (speed == 0) return std::nullopt;
  const double away_m = glm::dot(normal, pane.center_m - place_m) / speed;
  const glm::dvec3 from_center = place_m + away_m * way - pane.center_m;
  return OnGlass{0.5 + 0.5 * glm::dot(from_center, pane.right_m) / glm::dot(pane.right_m, pane.right_m),
                 0.5 - 0.5 * glm::dot(from_center, pane.up_m) / glm::dot(pane.up_m, pane.up_m), away_m};
}

glm::dvec3 glass_at(const JudgePane& pane, const OnGlass& at) {
  if (!pane.image) return pane.color;
  const double x = at.x * pane.image->width - 0.5, y = at.y * pane.image->height - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const auto row = [&](int which) {
    return glm::mix(texel_of(*pane.image, left, which), texel_of(*pane.image, left + 1, which), x - left);
  };
  return pane.color * glm::mix(row(top), row(top + 1), y - top);
}

bool sun_lies_in(const JudgePane& pane, const JudgeSun& sun) {
  return std::abs(glm::dot(glm::normalize(glm::cross(pane.right_m, pane.up_m)), sun.direction)) < kLeastCosine;
}

// Whether the path of length_m from the place against the sun's light goes through a solid for longer than a moment.
bool is_hidden(const JudgeSolid& solid, const glm::dvec3& place_m, const glm::dvec3& back, double length_m) {
  double enter = 0, leave = length_m;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 normal = glm::normalize(glm::cross(solid.half_m[(i + 1) % 3], solid.half_m[(i + 2) % 3]));
    const double reach = std::abs(glm::dot(normal, solid.half_m[i]));
    const double at = glm::dot(normal, place_m - solid.center_m), speed = glm::dot(normal, back);
    if (speed == 0) {
      if (std::abs(at) >= reach) return false;
      continue;
    }
    enter = std::max(enter, std::min((-reach - at) / speed, (reach - at) / speed));
    leave = std::min(leave, std::max((-reach - at) / speed, (reach - at) / speed));
  }
  return leave - enter > kEnteredM;
}

bool is_dark(const JudgeScene& scene, const glm::dvec3& place_m, double length_m) {
  return std::any_of(scene.solids.begin(), scene.solids.end(), [&](const JudgeSolid& solid) {
    return is_hidden(solid, place_m, -scene.sun.direction, length_m);
  });
}

// Places along a ray, ascending, between which nothing changes at once.
class Places {
 public:
  Places(const Ray& ray, double end_m) : ray_(ray), end_m_(end_m), all_{0, end_m} {}

  void add(double t_m) {
    if (t_m > 0 && t_m < end_m_) all_.push_back(t_m);
  }
  // Where the ray meets a plane through a point.
  void meet(const glm::dvec3& normal, const glm::dvec3& point_m) {
    add(glm::dot(normal, point_m - ray_.origin_m) / glm::dot(normal, ray_.direction));
  }
  [[nodiscard]] std::vector<double> take() {
    std::sort(all_.begin(), all_.end());
    return std::move(all_);
  }

 private:
  const Ray& ray_;
  double end_m_;
  std::vector<double> all_;
};

// The lines between the middles of texels, their borders and the pane itself, drawn out along the light.
void add_glass(const JudgePane& pane, const glm::dvec3& sun, Places& places) {
  places.meet(glm::cross(pane.right_m, pane.up_m), pane.center_m);
  const auto add_lines = [&](const glm::dvec3& across, const glm::dvec3& along, int texels) {
    const glm::dvec3 normal = glm::cross(along, sun);
    const auto line = [&](double share) { places.meet(normal, pane.center_m + (2 * share - 1) * across); };
    line(0);
    line(1);
    for (int i = 0; i < texels; ++i) line((i + 0.5) / texels);
  };
  add_lines(pane.right_m, pane.up_m, pane.image ? pane.image->width : 0);
  add_lines(-pane.up_m, pane.right_m, pane.image ? pane.image->height : 0);
}

// The faces of a solid, and planes of light along its edges and along where its faces meet the plane of the pane.
void add_solid(const JudgeSolid& solid, const JudgePane& pane, const glm::dvec3& sun, Places& places) {
  const glm::dvec3 pane_normal = glm::cross(pane.right_m, pane.up_m);
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 u = solid.half_m[i], v = solid.half_m[(i + 1) % 3], w = solid.half_m[(i + 2) % 3];
    const glm::dvec3 normal = glm::cross(v, w);
    for (const double side : {-1.0, 1.0}) {
      places.meet(normal, solid.center_m + side * u);
      for (const double other : {-1.0, 1.0}) {
        places.meet(glm::cross(u, sun), solid.center_m + side * v + other * w);
      }
      // A point of both planes, and the line in which they meet.
      const glm::dvec3 line = glm::cross(normal, pane_normal);
      const double square = glm::dot(line, line);
      if (!(square > 0)) continue;
      const glm::dvec3 point = (glm::dot(normal, solid.center_m + side * u) * glm::cross(pane_normal, line) +
                                glm::dot(pane_normal, pane.center_m) * glm::cross(line, normal)) /
                               square;
      places.meet(glm::cross(line, sun), point);
    }
  }
}

// Light of one pane in the air, over that of the sun, sigma_s and the phase function.
glm::dvec3 shaft(const JudgeScene& scene, const JudgePane& pane, const Ray& ray, double end_m) {
  const glm::dvec3& sun = scene.sun.direction;
  Places places(ray, end_m);
  add_glass(pane, sun, places);
  // Where the range ends.
  places.meet(glm::cross(pane.right_m, pane.up_m), pane.center_m + scene.sun.range_m * sun);
  for (const JudgeSolid& solid : scene.solids) add_solid(solid, pane, sun, places);
  const std::vector<double> all = places.take();
  const double sigma_t = extinction_of(scene.haze);
  using Gauss = boost::math::quadrature::gauss<double, 10>;
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    const double middle_m = 0.5 * (all[i] + all[i + 1]);
    if (!(middle_m > all[i])) continue;
    const auto back = on_glass(pane, ray.origin_m + middle_m * ray.direction, -sun);
    if (!back || back->away_m <= 0 || back->away_m > scene.sun.range_m || !is_on(*back)) continue;
    if (is_dark(scene, ray.origin_m + middle_m * ray.direction, back->away_m)) continue;
    const auto light_at = [&](double t_m) {
      const glm::dvec3 place_m = ray.origin_m + t_m * ray.direction;
      const auto at = on_glass(pane, place_m, -sun);
      const double density = scene.density ? scene.density(place_m) : 1.0;
      return glass_at(pane, *at) * (density * std::exp(-sigma_t * (t_m + at->away_m)));
    };
    // Short enough that what is left of the light changes by little, and for clouds.
    const auto first = on_glass(pane, ray.origin_m + all[i] * ray.direction, -sun);
    const auto last = on_glass(pane, ray.origin_m + all[i + 1] * ray.direction, -sun);
    const double gone = sigma_t * std::abs(all[i + 1] - all[i] + last->away_m - first->away_m);
    const double pieces =
        std::clamp(std::ceil(std::max(gone, scene.density ? (all[i + 1] - all[i]) / 0.1 : 0.0)), 1.0, 1e4);
    for (int k = 0; k < static_cast<int>(pieces); ++k) {
      const double from = glm::mix(all[i], all[i + 1], k / pieces);
      const double to = glm::mix(all[i], all[i + 1], (k + 1) / pieces);
      for (std::size_t n = 0; n < Gauss::abscissa().size(); ++n) {
        const double away = 0.5 * (to - from) * Gauss::abscissa()[n];
        const double center = 0.5 * (from + to);
        sum += 0.5 * (to - from) * Gauss::weights()[n] * (light_at(center - away) + light_at(center + away));
      }
    }
  }
  return sum;
}

}  // namespace

void add_panes(JudgeScene& scene, const fixtures::Rig& rig, double range_m) {
  scene.sun = {rig.sun.direction, fixtures::sun_lx(rig.sun), glm::dvec3(rig.sun.sky_lx / std::numbers::pi), range_m};
  for (const fixtures::Pane& pane : rig.panes) {
    const glm::dmat4 pose = fixtures::pose_of(pane);
    scene.panes.push_back({pane.position_m, glm::dvec3(pose[0]) * (pane.width_m / 2),
                           glm::dvec3(pose[2]) * (pane.height_m / 2), pane.image, pane.color});
  }
}

glm::dvec3 judge_shafts(const JudgeScene& scene, const Ray& ray, double t_max_m) {
  glm::dvec3 total(0);
  const fixtures::Haze& haze = scene.haze;
  const double g = haze.anisotropy;
  const double cosine = -glm::dot(scene.sun.direction, ray.direction);  // of the scattering angle
  const double phase = (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
  for (const JudgePane& pane : scene.panes) {
    if (const auto seen = on_glass(pane, ray.origin_m, ray.direction);
        seen && seen->away_m > 0 && seen->away_m < t_max_m && is_on(*seen)) {
      total += scene.sun.sky_cd_m2 * glass_at(pane, *seen) * std::exp(-extinction_of(haze) * seen->away_m);
    }
    if (!(haze.scattering_per_m > 0) || sun_lies_in(pane, scene.sun)) continue;
    const double far_m = glm::length(pane.center_m - ray.origin_m) + glm::length(pane.right_m) +
                         glm::length(pane.up_m) + scene.sun.range_m;
    total += haze.scattering_per_m * phase * scene.sun.light_lx * shaft(scene, pane, ray, std::min(t_max_m, far_m));
  }
  return total;
}

glm::dvec3 judge_sun_lux(const JudgeScene& scene, const glm::dvec3& point_m, const glm::dvec3& normal) {
  glm::dvec3 total(0);
  const double facing = -glm::dot(normal, scene.sun.direction);
  if (!(facing > 0)) return total;
  for (const JudgePane& pane : scene.panes) {
    if (sun_lies_in(pane, scene.sun)) continue;
    const auto back = on_glass(pane, point_m, -scene.sun.direction);
    if (!back || !(back->away_m > 0) || back->away_m > scene.sun.range_m || !is_on(*back)) continue;
    if (is_dark(scene, point_m, back->away_m)) continue;
    total += glass_at(pane, *back) * (facing * std::exp(-extinction_of(scene.haze) * back->away_m));
  }
  return total * scene.sun.light_lx;
}

}  // namespace footlight::render
