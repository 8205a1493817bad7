#include "render/reference/display_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>

#include "fixtures/displays/screen_dimmers.h"

namespace footlight::render {
namespace {

// Parts of pixels, as their extent over their distance: larger ones are split; smaller ones have 3 x 3, 2 x 2 or one
// node.
constexpr double kSplit = 0.25, kThreeNodes = 0.05, kTwoNodes = 0.004;
constexpr double kSplitAtHorizon = 0.02;
constexpr int kSplitsMost = 20;

double lost_per_m(const fixtures::Haze& haze) { return haze.scattering_per_m + haze.absorption_per_m; }

// Calls take(point, area) for nodes of a rectangle, given by its middle and the halves of its sides. may_bend: whether
// what is integrated may have a bend over the rectangle.
template <class Take, class MayBend>
void nodes_of(const glm::dvec3& middle_m, const glm::dvec3& u_m, const glm::dvec3& v_m, const glm::dvec3& place_m,
              const Take& take, const MayBend& may_bend, int splits = 0) {
  const double u = glm::length(u_m), v = glm::length(v_m);
  const double size = 2 * std::max(u, v) / glm::distance(middle_m, place_m);
  if (splits < kSplitsMost && (size > kSplit || (size > kSplitAtHorizon && may_bend(middle_m, u_m, v_m)))) {
    const bool halve_u = u > 0.7 * v, halve_v = v > 0.7 * u;
    const glm::dvec3 part_u = halve_u ? 0.5 * u_m : u_m, part_v = halve_v ? 0.5 * v_m : v_m;
    for (const double x : {-1.0, 1.0}) {
      if (!halve_u && x > 0) continue;
      for (const double y : {-1.0, 1.0}) {
        if (!halve_v && y > 0) continue;
        nodes_of(middle_m + (halve_u ? x * part_u : glm::dvec3(0)) + (halve_v ? y * part_v : glm::dvec3(0)), part_u,
                 part_v, place_m, take, may_bend, splits + 1);
      }
    }
    return;
  }
  const double area = 4 * u * v;
  if (size <= kTwoNodes) {
    take(middle_m, area);
    return;
  }
  const int count = size > kThreeNodes ? 3 : 2;
  const double away = count == 3 ? std::sqrt(0.6) : std::sqrt(1.0 / 3.0);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const auto at = [&](int n) { return count == 3 ? (n - 1) * away : (2 * n - 1) * away; };
      const auto weight = [&](int n) { return count == 2 ? 0.5 : n == 1 ? 8.0 / 18 : 5.0 / 18; };
      take(middle_m + at(i) * u_m + at(j) * v_m, area * weight(i) * weight(j));
    }
  }
}

const auto kNeverBends = [](const glm::dvec3&, const glm::dvec3&, const glm::dvec3&) { return false; };

// Sums weigh(pixel, its light) over all pixels that shine.
template <class Each>
void each_pixel(const JudgeDisplay& display, const Each& each) {
  const glm::dvec3 u = display.right_m / static_cast<double>(display.columns);
  const glm::dvec3 v = display.up_m / static_cast<double>(display.rows);
  for (int y = 0; y < display.rows; ++y) {
    for (int x = 0; x < display.columns; ++x) {
      const glm::dvec3& light =
          display.pixels_cd_m2[static_cast<std::size_t>(y) * static_cast<std::size_t>(display.columns) +
                               static_cast<std::size_t>(x)];
      if (light == glm::dvec3(0)) continue;
      each(display.center_m + (2.0 * x + 1 - display.columns) * u - (2.0 * y + 1 - display.rows) * v, u, v, light);
    }
  }
}

glm::dvec3 front_of(const JudgeDisplay& display) { return glm::normalize(glm::cross(display.right_m, display.up_m)); }

// Light that the air at a place scatters against the direction, over sigma_s.
glm::dvec3 scattered_at(const JudgeScene& scene, const JudgeDisplay& display, const glm::dvec3& place_m,
                        const glm::dvec3& direction) {
  const glm::dvec3 front = front_of(display);
  const double g = scene.haze.anisotropy, sigma_t = lost_per_m(scene.haze);
  glm::dvec3 sum(0);
  each_pixel(display, [&](const glm::dvec3& middle, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& light) {
    double share = 0;
    nodes_of(
        middle, u, v, place_m,
        [&](const glm::dvec3& point, double area) {
          const glm::dvec3 from = place_m - point;
          const double r = glm::length(from);
          const double cosine = -glm::dot(from, direction) / r;  // of the scattering angle
          const double phase = (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
          share += area * std::max(glm::dot(from, front), 0.0) / (r * r * r) * phase * std::exp(-sigma_t * r);
        },
        kNeverBends);
    sum += share * light;
  });
  return sum;
}

// From a place to the nearest of the rectangle.
double distance_m(const JudgeDisplay& display, const glm::dvec3& place_m) {
  const glm::dvec3 from = place_m - display.center_m;
  glm::dvec3 near = display.center_m;
  for (const glm::dvec3& half : {display.right_m, display.up_m}) {
    near += half * std::clamp(glm::dot(from, half) / glm::dot(half, half), -1.0, 1.0);
  }
  return glm::distance(place_m, near);
}

// Pieces of a ray from begin to end, each twice as long as the one before, away from where it is nearest the display.
std::vector<double> graded_pieces(const JudgeDisplay& display, const Ray& ray, double begin_m, double end_m) {
  double low = begin_m, high = std::min(end_m, begin_m + 1e6);
  const auto at = [&](double t_m) { return distance_m(display, ray.origin_m + t_m * ray.direction); };
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
  }
  const double nearest = 0.5 * (low + high);
  const double pixel_m =
      2 * std::min(glm::length(display.right_m) / display.columns, glm::length(display.up_m) / display.rows);
  const double first_m = std::max(at(nearest), 0.25 * pixel_m);
  std::vector<double> places{begin_m, nearest};
  for (const double side : {-1.0, 1.0}) {
    double step_m = 0.5 * first_m;
    for (double t = nearest + side * step_m; t > begin_m && t < end_m && std::abs(t - nearest) < 1e5;
         t += side * step_m, step_m *= 1.5) {
      places.push_back(t);
    }
  }
  std::sort(places.begin(), places.end());
  if (std::isfinite(end_m)) places.push_back(end_m);
  return places;
}

glm::dvec3 air_of(const JudgeScene& scene, const JudgeDisplay& display, const Ray& ray, double t_max_m) {
  using Gauss = boost::math::quadrature::gauss<double, 7>;
  const glm::dvec3 front = front_of(display);
  const double height = glm::dot(front, ray.origin_m - display.center_m), speed = glm::dot(front, ray.direction);
  double begin_m = 0, end_m = t_max_m;
  if (speed > 0) begin_m = std::max(0.0, -height / speed);
  if (speed < 0) end_m = std::min(end_m, height / -speed);
  if (speed == 0 && height <= 0) return glm::dvec3(0);
  if (!(end_m > begin_m)) return glm::dvec3(0);
  const double sigma_t = lost_per_m(scene.haze);
  const std::vector<double> places = graded_pieces(display, ray, begin_m, end_m);
  glm::dvec3 sum(0);
  const auto add = [&](double from_m, double to_m) {
    const auto node = [&](double x, double weight) {
      const double t_m = 0.5 * (from_m + to_m) + 0.5 * (to_m - from_m) * x;
      const glm::dvec3 place_m = ray.origin_m + t_m * ray.direction;
      const double density = scene.density ? scene.density(place_m) : 1.0;
      sum += 0.5 * (to_m - from_m) * weight * density * std::exp(-sigma_t * t_m) *
             scattered_at(scene, display, place_m, ray.direction);
    };
    for (std::size_t n = 0; n < Gauss::abscissa().size(); ++n) {
      node(Gauss::abscissa()[n], Gauss::weights()[n]);
      if (Gauss::abscissa()[n] != 0) node(-Gauss::abscissa()[n], Gauss::weights()[n]);
    }
  };
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    if (sigma_t * places[i] > 40) break;  // nothing is left
    const double length_m = places[i + 1] - places[i];
    // Short enough for clouds, and that what is left of the light changes by little.
    const double parts =
        std::clamp(std::ceil(std::max(sigma_t * length_m, scene.density ? length_m / 0.2 : 0.0)), 1.0, 1e3);
    for (int k = 0; k < static_cast<int>(parts); ++k) {
      add(glm::mix(places[i], places[i + 1], k / parts), glm::mix(places[i], places[i + 1], (k + 1) / parts));
    }
  }
  return sum;
}

const std::vector<JudgeDisplay>& lights_of(const JudgeScene& scene) {
  return scene.display_lights.empty() ? scene.displays : scene.display_lights;
}

}  // namespace

void add_displays(JudgeScene& scene, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                  std::span<const std::uint8_t> given) {
  const std::vector<Universe>& universes = compiled.universes;
  const std::vector<std::uint8_t> none(given.empty() ? universes.size() * kSlotCountMax : 0);
  const std::span<const std::uint8_t> levels = given.empty() ? none : given;
  const fixtures::ScreenDimmers dimmers(rig, compiled);
  std::vector<double> shares(rig.displays.size(), 1);
  for (std::size_t i = 0; i < dimmers.displays().size(); ++i) {
    shares[dimmers.displays()[i]] = dimmers.share(i, levels);
  }
  for (std::size_t i = 0; i < rig.displays.size(); ++i) {
    const fixtures::Display& display = rig.displays[i];
    const glm::dmat4 pose = fixtures::pose_of(display);
    JudgeDisplay judged{display.position_m,
                        glm::dvec3(pose[0]) * (display.width_m / 2),
                        glm::dvec3(pose[2]) * (display.height_m / 2),
                        display.columns,
                        display.rows,
                        {}};
    const auto light_of = [&](int x, int y) {
      if (display.image) {
        return glm::dvec3(
            display.image->texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(display.columns) +
                                  static_cast<std::size_t>(x)]);
      }
      if (!display.map) return glm::dvec3(1);
      const fixtures::PixelPlace place = fixtures::place_of_pixel(display, x, y);
      const auto at = std::lower_bound(universes.begin(), universes.end(), display.map->universe + place.universe);
      const auto first =
          static_cast<std::size_t>(at - universes.begin()) * kSlotCountMax + static_cast<std::size_t>(place.slot);
      return fixtures::pixel_light(*display.map, &levels[first]);
    };
    for (int y = 0; y < display.rows; ++y) {
      for (int x = 0; x < display.columns; ++x) {
        judged.pixels_cd_m2.push_back(shares[i] * display.nits * display.color * light_of(x, y));
      }
    }
    scene.displays.push_back(std::move(judged));
  }
}

void join_display_lights(JudgeScene& scene, int most) {
  scene.display_lights.clear();
  const auto displays = std::max<double>(1, static_cast<double>(scene.displays.size()));
  const double each = std::max(static_cast<double>(most) / displays, 1.0);
  for (const JudgeDisplay& display : scene.displays) {
    const double aspect = glm::length(display.right_m) / glm::length(display.up_m);
    JudgeDisplay joined = display;
    joined.columns = std::clamp(static_cast<int>(std::lround(std::sqrt(each * aspect))), 1, display.columns);
    joined.rows = std::clamp(static_cast<int>(each / joined.columns), 1, display.rows);
    joined.pixels_cd_m2.assign(static_cast<std::size_t>(joined.columns) * static_cast<std::size_t>(joined.rows), {});
    // Share of the old pixel `from` that is within the new one `to`, of so many.
    const auto overlap = [](int from, int old_count, int to, int count) {
      const double size = static_cast<double>(old_count) / count;
      return std::max(std::min(from + 1.0, (to + 1) * size) - std::max<double>(from, to * size), 0.0) / size;
    };
    for (int y = 0; y < display.rows * joined.rows; ++y) {
      const double tall = overlap(y / joined.rows, display.rows, y % joined.rows, joined.rows);
      for (int x = 0; tall > 0 && x < display.columns * joined.columns; ++x) {
        const double share = tall * overlap(x / joined.columns, display.columns, x % joined.columns, joined.columns);
        if (!(share > 0)) continue;
        joined.pixels_cd_m2[static_cast<std::size_t>(y % joined.rows * joined.columns + x % joined.columns)] +=
            share * display.pixels_cd_m2[static_cast<std::size_t>(y / joined.rows * display.columns +
                                                                  x / joined.columns)];
      }
    }
    scene.display_lights.push_back(std::move(joined));
  }
}

glm::dvec3 judge_displays(const JudgeScene& scene, const Ray& ray, double t_max_m) {
  glm::dvec3 total(0);
  for (const JudgeDisplay& display : scene.displays) {
    const glm::dvec3 front = front_of(display);
    const double height = glm::dot(front, ray.origin_m - display.center_m), speed = glm::dot(front, ray.direction);
    if (height > 0 && speed < 0 && height / -speed < t_max_m) {
      const double t_m = height / -speed;
      const glm::dvec3 from = ray.origin_m + t_m * ray.direction - display.center_m;
      const double x = 0.5 + 0.5 * glm::dot(from, display.right_m) / glm::dot(display.right_m, display.right_m);
      const double y = 0.5 - 0.5 * glm::dot(from, display.up_m) / glm::dot(display.up_m, display.up_m);
      if (x >= 0 && x < 1 && y >= 0 && y < 1) {
        const auto column = static_cast<std::size_t>(x * display.columns),
                   row = static_cast<std::size_t>(y * display.rows);
        total += display.pixels_cd_m2[row * static_cast<std::size_t>(display.columns) + column] *
                 std::exp(-lost_per_m(scene.haze) * t_m);
      }
    }
  }
  for (const JudgeDisplay& display : lights_of(scene)) {
    if (!(scene.haze.scattering_per_m > 0)) break;
    total += scene.haze.scattering_per_m * air_of(scene, display, ray, t_max_m);
  }
  return total;
}

glm::dvec3 judge_display_lux(const JudgeScene& scene, const glm::dvec3& point_m, const glm::dvec3& normal) {
  glm::dvec3 total(0);
  for (const JudgeDisplay& display : lights_of(scene)) {
    const glm::dvec3 front = front_of(display);
    if (!(glm::dot(front, point_m - display.center_m) > 0)) continue;
    // Where the horizon of the surface goes through a rectangle.
    const auto may_bend = [&](const glm::dvec3& middle, const glm::dvec3& u, const glm::dvec3& v) {
      return std::abs(glm::dot(normal, middle - point_m)) <=
             std::abs(glm::dot(normal, u)) + std::abs(glm::dot(normal, v));
    };
    each_pixel(display,
               [&](const glm::dvec3& middle, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& light) {
                 double share = 0;
                 nodes_of(
                     middle, u, v, point_m,
                     [&](const glm::dvec3& at, double area) {
                       const glm::dvec3 to = at - point_m;
                       const double square = glm::dot(to, to);
                       share += area * std::max(glm::dot(normal, to), 0.0) * std::max(-glm::dot(front, to), 0.0) /
                                (square * square) * std::exp(-lost_per_m(scene.haze) * std::sqrt(square));
                     },
                     may_bend);
                 total += share * light;
               });
  }
  return total;
}

}  // namespace footlight::render
