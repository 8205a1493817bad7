#include "render/reference/judge.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <thread>
#include <utility>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "fixtures/displays/screen_motion.h"
#include "fixtures/photometry/table.h"
#include "render/probe.h"
#include "render/reference/cores.h"
#include "render/reference/display_judge.h"
#include "render/reference/gloss_judge.h"
#include "render/reference/mirror_judge.h"
#include "render/reference/plume_judge.h"
#include "render/reference/probe_judge.h"
#include "render/reference/shaft_judge.h"
#include "render/reference/wide.h"
#include "render/sheen_rays.h"
#include "sim/core/check.h"
#include "sim/shared/shared.h"

namespace footlight::render::f64 {
using namespace ::footlight::f64;
namespace {
using fixtures::kWheelOpening;
#include "render/shaders/shared/optics.h"
}  // namespace
}  // namespace footlight::render::f64

namespace footlight::render {
namespace {

// fixtures/ does not include this code and decides by kFrostWidensMost which beam forms to leave out.
static_assert(fixtures::kFrostWidensMost > 1 + std::numbers::sqrt3 * static_cast<double>(f64::kFrostWidens));
static_assert(fixtures::kFrostAddsMost > std::numbers::sqrt3 * static_cast<double>(f64::kFrostAdds));

// One piece of an integral with its estimated error.
struct Piece {
  double from = 0;
  double to = 0;
  double value = 0;
  double error = 0;
};

bool less_wrong(const Piece& a, const Piece& b) { return a.error < b.error; }

template <class F>
Piece measure_piece(const F& f, double from, double to) {
  Piece piece{from, to, 0, 0};
  const double middle = (from + to) / 2;
  const double half = (to - from) / 2;
  // Integrates over [-1, 1], because the library's error estimate then has the scale of its result.
  piece.value = boost::math::quadrature::gauss_kronrod<double, 15>::integrate(
      [&](double x) { return half * f(middle + half * x); }, -1.0, 1.0, 0, 0.0, &piece.error);
  return piece;
}

// Globally adaptive: halves the piece with the largest error until the sum of the errors is less than tolerance x
// value. `cuts` are ascending, at least two.
template <class F>
double integrate(const F& f, const std::vector<double>& cuts, double tolerance) {
  // Enough for a gobo with a few hundred hard edges along a ray. The remaining error is part of the judge's own error.
  constexpr std::size_t kPiecesMax = 20'000;
  std::vector<Piece> pieces;
  pieces.reserve(2 * cuts.size());
  double value = 0;
  double error = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (!(cuts[i + 1] > cuts[i])) continue;
    pieces.push_back(measure_piece(f, cuts[i], cuts[i + 1]));
    value += pieces.back().value;
    error += pieces.back().error;
  }
  std::make_heap(pieces.begin(), pieces.end(), less_wrong);
  while (error > tolerance * std::abs(value) && !pieces.empty() && pieces.size() < kPiecesMax) {
    std::pop_heap(pieces.begin(), pieces.end(), less_wrong);
    const Piece worst = pieces.back();
    const double middle = (worst.from + worst.to) / 2;
    // Only rounding error is left, or the piece cannot be halved.
    if (worst.error <= 4e-16 * std::abs(value) || !(middle > worst.from && middle < worst.to)) break;
    pieces.pop_back();
    for (const auto& [from, to] : {std::pair(worst.from, middle), std::pair(middle, worst.to)}) {
      pieces.push_back(measure_piece(f, from, to));
      value += pieces.back().value;
      error += pieces.back().error;
      std::push_heap(pieces.begin(), pieces.end(), less_wrong);
    }
    value -= worst.value;
    error -= worst.error;
  }
  // Sums again, because the running sums above contain the rounding error of every step.
  Wide total = 0;
  for (const Piece& piece : pieces) total += piece.value;
  return static_cast<double>(total);
}

// A ray in light space: (x, y) across the beam, z along its axis.
struct LightRay {
  Wide ox, oy, oz;
  Wide dx, dy, dz;
};

Wide wide_dot(const glm::dvec3& a, const glm::dvec3& b) { return Wide(a.x) * b.x + Wide(a.y) * b.y + Wide(a.z) * b.z; }

LightRay light_ray(const JudgeBeam& beam, const Ray& ray) {
  const glm::dvec3 from_lens = ray.origin_m - beam.lens_m;
  return {wide_dot(from_lens, beam.x_axis),     wide_dot(from_lens, beam.y_axis),
          wide_dot(from_lens, beam.axis),       wide_dot(ray.direction, beam.x_axis),
          wide_dot(ray.direction, beam.y_axis), wide_dot(ray.direction, beam.axis)};
}

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Finds the part of the ray with 0 <= z <= range inside the cone: `from` < `to`. Returns false if there is none. Both
// are relative to `base`, the point nearest the axis within the slab, to avoid cancellation in the roots of far rays.
bool lit_interval(const JudgeBeam& beam, const LightRay& r, double t_min_m, double t_max_m, Wide& base, Wide& from,
                  Wide& to) {
  constexpr Wide kInfinity = std::numeric_limits<Wide>::infinity();
  Wide low = t_min_m;
  Wide high = t_max_m;
  if (r.dz == 0) {
    if (r.oz < 0 || r.oz > beam.range_m) return false;
  } else {
    const Wide at_lens = -r.oz / r.dz;
    const Wide at_end = (beam.range_m - r.oz) / r.dz;
    low = std::max(low, std::min(at_lens, at_end));
    high = std::min(high, std::max(at_lens, at_end));
  }
  if (!(high > low)) return false;

  const Wide across = r.dx * r.dx + r.dy * r.dy;
  base = across > 0 ? -(r.ox * r.dx + r.oy * r.dy) / across : low;
  base = std::clamp(base, low, high);
  const Wide bx = r.ox + base * r.dx;
  const Wide by = r.oy + base * r.dy;
  const Wide bw = beam.lens_radius_m + beam.spread * (r.oz + base * r.dz);
  const Wide slope = beam.spread * r.dz;
  // |xy|^2 - w^2 = a t^2 + 2 b t + c, t from the base.
  const Wide a = across - slope * slope;
  const Wide b = bx * r.dx + by * r.dy - bw * slope;
  const Wide c = bx * bx + by * by - bw * bw;
  const auto outside = [&](Wide t) { return (a * t + 2 * b) * t + c; };

  Wide cuts[4] = {low - base, high - base, kInfinity, kInfinity};
  int count = 2;
  const Wide discriminant = b * b - a * c;
  if (discriminant > 0) {
    const Wide q = -(b + std::copysign(std::sqrt(discriminant), b));
    for (const Wide root : {q / a, c / q}) {
      if (root > low - base && root < high - base) cuts[count++] = root;
    }
  }
  std::sort(cuts, cuts + count);
  // The slab contains one nappe of the cone, so the lit part is one interval. Neighbouring parts join at a double root.
  bool lit = false;
  for (int i = 0; i + 1 < count; ++i) {
    if (!(cuts[i + 1] > cuts[i])) continue;
    const Wide middle =
        // unbounded only if a cylinder contains the ray
        std::isfinite(cuts[i + 1]) ? (cuts[i] + cuts[i + 1]) / 2 : cuts[i] + 1;
    if (!(outside(middle) < 0)) continue;
    if (!lit) from = cuts[i];
    to = cuts[i + 1];
    lit = true;
  }
  return lit && to > from && std::isfinite(to);
}

double henyey_greenstein(double cosine, double g) {
  return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

double profile(double rho_square, double m) {
  if (!(rho_square < 1)) return 0.0;
  return m < 1 ? std::pow(1 - rho_square, 1 / m) : 1 - std::pow(rho_square, m);
}

// The same for a rectangular beam: between four planes that pass through one point.
bool lit_in_rectangle(const JudgeBeam& beam, const LightRay& r, double t_min_m, double t_max_m, Wide& base, Wide& from,
                      Wide& to) {
  Wide low = t_min_m;
  Wide high = t_max_m;
  // Keeps the part with a + b t >= 0.
  const auto keep = [&](Wide a, Wide b) {
    if (b == 0) {
      if (a < 0) high = low;
    } else if (b > 0) {
      low = std::max(low, -a / b);
    } else {
      high = std::min(high, -a / b);
    }
  };
  keep(r.oz, r.dz);
  keep(beam.range_m - r.oz, -r.dz);
  const Wide w = beam.lens_radius_m + beam.spread * r.oz;
  const Wide slope = beam.spread * r.dz;
  for (const int sign : {1, -1}) {
    keep(w - sign * r.ox, slope - sign * r.dx);
    keep(w / beam.aspect - sign * r.oy, slope / beam.aspect - sign * r.dy);
  }
  if (!(high > low) || !std::isfinite(high)) return false;
  base = std::clamp(-(r.ox * r.dx + r.oy * r.dy + r.oz * r.dz), low, high);
  from = low - base;
  to = high - base;
  return true;
}

bool has_gobo(const JudgeBeam& beam) {
  return beam.wheels[0].image > 0 || beam.wheels[1].image > 0 || beam.animation > 0 || beam.wheels[0].offset != 0 ||
         beam.wheels[1].offset != 0;
}

// Transmission of one wheel at a point of the gate.
double wheel_share(const JudgeWheel& wheel, const GoboTransmission& gobo, glm::dvec2 p) {
  int image = wheel.image;
  if (wheel.offset != 0) {
    glm::dvec2 at;
    if (f64::wheel_slot_at(p, wheel.offset, at)) image = wheel.next;
    p = at;
    if (glm::dot(p, p) > 1) return 0;
  }
  return image > 0 ? gobo(image, wheel.cos * p.x + wheel.sin * p.y, wheel.cos * p.y - wheel.sin * p.x) : 1;
}

// Transmission of all images at a point of the beam, z_m from the lens.
double gobo_share(const JudgeBeam& beam, const GoboTransmission& gobo, double x, double y, double z_m) {
  if (!gobo || !has_gobo(beam)) return 1;
  const auto sharp = [&](glm::dvec2 p) {
    double share = 1;
    for (const JudgeWheel& wheel : beam.wheels) {
      if (share > 0 && (wheel.image > 0 || wheel.offset != 0)) share *= wheel_share(wheel, gobo, p);
    }
    if (share > 0 && beam.animation > 0) {
      const glm::dvec2 at = (p - glm::dvec2(f64::kAnimationAwayX, 0)) / static_cast<double>(f64::kAnimationRadius);
      share *= gobo(beam.animation, beam.animation_cos * at.x + beam.animation_sin * at.y,
                    beam.animation_cos * at.y - beam.animation_sin * at.x);
    }
    return share;
  };
  // The image's disc passes through the corners of the rectangle, whose half width is 1.
  const double reach = beam.aspect > 0 ? std::hypot(1.0, 1 / beam.aspect) : 1;
  const glm::dvec2 p = glm::dvec2(x, y) * (beam.gobo_scale / reach);
  const double blur = std::max(beam.blur, f64::focus_blur(beam.lens_radius_m, beam.spread, z_m, beam.focus_per_m));
  if (!(blur > 1e-4)) return sharp(p);
  // Points of a sunflower pattern, each for an equal area.
  double sum = 0;
  for (int i = 0; i < beam.blur_points; ++i) {
    const double radius = blur * std::sqrt((i + 0.5) / beam.blur_points);
    const double angle = 2.399963229728653 * i;
    sum += sharp(p + radius * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  return sum / beam.blur_points;
}

double extinction_per_m(const fixtures::Haze& haze) { return haze.scattering_per_m + haze.absorption_per_m; }

// The light of a beam at a point: illuminance across the light over J0, before extinction.
struct LightAt {
  double illuminance = 0;   // 1/m^2, with gobos
  double distance_m = 0;    // along the light from the lens
  glm::dvec3 direction{0};  // of travel, unit, stage space
  glm::dvec2 rho{0};        // position in the beam, in its radii
  double z_m = 0;           // along the axis
};

// In the air blades have sharp edges.
bool passes_blades(const JudgeBeam& beam, const glm::dvec2& rho) {
  return std::all_of(beam.edges.begin(), beam.edges.end(),
                     [&](const glm::dvec3& edge) { return edge.x * rho.x + edge.y * rho.y <= edge.z; });
}

LightAt light_at(const JudgeBeam& beam, const GoboTransmission& gobo, const glm::dvec3& from_lens) {
  LightAt light;
  const double z = glm::dot(from_lens, beam.axis);
  const double w = beam.lens_radius_m + beam.spread * z;
  const double x = glm::dot(from_lens, beam.x_axis) / w;
  const double y = glm::dot(from_lens, beam.y_axis) / w;
  const double stretch = 1 + beam.spread * beam.spread * (x * x + y * y);
  light.direction = (beam.axis + beam.spread * (x * beam.x_axis + y * beam.y_axis)) / std::sqrt(stretch);
  light.distance_m = z * std::sqrt(stretch);
  light.rho = {x, y};
  light.z_m = z;
  double share = 0;
  const double high = y * beam.aspect;
  const bool inside = beam.aspect > 0 ? std::max(std::abs(x), std::abs(high)) < 1 : x * x + y * y < 1;
  const double square = beam.shown * beam.shown;
  if (!inside) {
    share = 0;
  } else if (beam.measured) {
    const double spread = beam.measured_spread * beam.shown;
    share = beam.measured(x * spread, y * spread);
  } else if (beam.aspect > 0) {
    share = profile(x * x * square, beam.profile_power) * profile(high * high * square, beam.profile_power);
  } else {
    share = profile((x * x + y * y) * square, beam.profile_power);
  }
  light.illuminance = share / (w * w * stretch);
  if (light.illuminance > 0) light.illuminance *= gobo_share(beam, gobo, x, y, z);
  return light;
}

// Whether the light of a beam can come near a solid at all.
bool may_hide(const JudgeBeam& beam, const JudgeSolid& solid) {
  const double radius = glm::length(solid.half_m[0]) + glm::length(solid.half_m[1]) + glm::length(solid.half_m[2]);
  const glm::dvec3 from_lens = solid.center_m - beam.lens_m;
  const double z = glm::dot(from_lens, beam.axis);
  if (z < -radius || z > beam.range_m + radius) return false;
  const double reach = beam.aspect > 0 ? std::hypot(1.0, 1 / beam.aspect) : 1;
  const double aside = std::hypot(glm::dot(from_lens, beam.x_axis), glm::dot(from_lens, beam.y_axis)) -
                       reach * (beam.lens_radius_m + beam.spread * std::max(z, 0.0));
  return aside <= radius * std::hypot(1.0, reach * beam.spread);
}

// A plate without thickness gets a nanometre, so that it is a body; what has less than two directions stays nothing.
JudgeSolid thickened(const JudgeSolid& solid) {
  JudgeSolid thick = solid;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 normal = glm::cross(solid.half_m[(i + 1) % 3], solid.half_m[(i + 2) % 3]);
    if (glm::length(solid.half_m[i]) == 0 && glm::length(normal) > 0) thick.half_m[i] = 1e-9 * glm::normalize(normal);
  }
  return thick;
}

// A place of the unit disc on the lens; of a rectangular beam the same share of each of its strips.
glm::dvec3 lens_place(const JudgeBeam& beam, const glm::dvec2& in_disc) {
  glm::dvec2 at = in_disc;
  if (beam.aspect > 0) {
    // A strip of the disc beside the axis has the area asin x + x sqrt(1 - x^2) over pi/2.
    const auto even = [](double x) {
      return std::clamp((std::asin(x) + x * std::sqrt(1 - x * x)) * 2 / std::numbers::pi, -1.0, 1.0);
    };
    const double half = std::sqrt(std::max(1 - in_disc.x * in_disc.x, 1e-12));
    at = {even(std::clamp(in_disc.x, -1.0, 1.0)), std::clamp(in_disc.y / half, -1.0, 1.0) / beam.aspect};
  }
  return beam.lens_m + beam.lens_radius_m * (at.x * beam.x_axis + at.y * beam.y_axis);
}

using DarkParts = std::vector<std::pair<double, double>>;

// Sorts places from..to of a ray and adds those parts between two of them in whose middle light is hidden.
template <class Hides>
void add_dark_between(std::vector<double>& places, const Hides& hides, DarkParts& dark) {
  std::sort(places.begin(), places.end());
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double middle = 0.5 * (places[i] + places[i + 1]);
    if (!(middle > places[i]) || !hides(middle)) continue;
    if (!dark.empty() && dark.back().second == places[i]) {
      dark.back().second = places[i + 1];
    } else {
      dark.emplace_back(places[i], places[i + 1]);
    }
  }
}

// The same for light from one point of the lens, which goes straight: planes through the faces, and through the point
// and each edge.
void add_dark_parts_from(const glm::dvec3& point_m, const JudgeSolid& given, const glm::dvec3& base_m,
                         const glm::dvec3& direction, double from, double to, DarkParts& dark) {
  const JudgeSolid solid = thickened(given);
  std::vector<double> places{from, to};
  const auto meet = [&](const glm::dvec3& normal, const glm::dvec3& on_plane_m) {
    const double t = -glm::dot(normal, base_m - on_plane_m) / glm::dot(normal, direction);
    if (t > from && t < to) places.push_back(t);
  };
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3& u = solid.half_m[i];
    const glm::dvec3& v = solid.half_m[(i + 1) % 3];
    const glm::dvec3& w = solid.half_m[(i + 2) % 3];
    for (const double side : {-1.0, 1.0}) {
      meet(glm::cross(v, w), solid.center_m + side * u);
      for (const double other : {-1.0, 1.0}) {
        meet(glm::cross(solid.center_m + side * v + other * w - point_m, u), point_m);
      }
    }
  }
  add_dark_between(
      places, [&](double t) { return judge_hides_from(point_m, solid, base_m + t * direction); }, dark);
}

// The share of a lens that lights places of a ray.
class LitShare {
 public:
  explicit LitShare(std::size_t points) : points_(static_cast<double>(points)) {}
  // Of one point.
  void add(DarkParts dark) {
    std::sort(dark.begin(), dark.end());
    for (std::size_t i = 0; i < dark.size();) {
      const double from = dark[i].first;
      double to = from;
      for (; i < dark.size() && (to == from || dark[i].first <= to); ++i) to = std::max(to, dark[i].second);
      changes_.emplace_back(from, -1 / points_);
      changes_.emplace_back(to, 1 / points_);
    }
  }
  void close() {
    std::sort(changes_.begin(), changes_.end());
    for (std::size_t i = 1; i < changes_.size(); ++i) changes_[i].second += changes_[i - 1].second;
  }
  double at(double t) const {
    const auto after = std::upper_bound(changes_.begin(), changes_.end(), std::pair(t, 2.0));
    return after == changes_.begin() ? 1.0 : std::max(1 + std::prev(after)->second, 0.0);
  }
  // Places and what has changed since the beginning.
  const DarkParts& changes() const { return changes_; }

 private:
  double points_;
  DarkParts changes_;
};

// Adds the parts from..to of a ray on which a solid hides the light. A part begins and ends where the ray meets a plane
// through a face, or a plane of light paths through an edge or through where a face meets the lens plane; between two
// such places a traced path in the middle decides.
void add_dark_parts(const JudgeBeam& beam, const JudgeSolid& given, const glm::dvec3& base_from_lens,
                    const glm::dvec3& direction, double from, double to, DarkParts& dark) {
  const JudgeSolid solid = thickened(given);
  const auto turned = [&](const glm::dvec3& v) {
    return glm::dvec3(glm::dot(v, beam.x_axis), glm::dot(v, beam.y_axis), glm::dot(v, beam.axis));
  };
  const auto weight = [&](const glm::dvec3& p, double one) { return beam.lens_radius_m * one + beam.spread * p.z; };
  const glm::dvec3 base = turned(base_from_lens);
  const glm::dvec3 way = turned(direction);
  std::vector<double> places{from, to};
  const auto meet = [&](double at, double rise) {
    const double t = -at / rise;
    if (t > from && t < to) places.push_back(t);
  };
  const auto meet_paths = [&](const glm::dvec3& plane) {
    meet(glm::dot(plane, glm::dvec3(base.x, base.y, weight(base, 1))),
         glm::dot(plane, glm::dvec3(way.x, way.y, weight(way, 0))));
  };
  const glm::dvec3 center = turned(solid.center_m - beam.lens_m);
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 u = turned(solid.half_m[i]);
    const glm::dvec3 v = turned(solid.half_m[(i + 1) % 3]);
    const glm::dvec3 w = turned(solid.half_m[(i + 2) % 3]);
    const glm::dvec3 normal = glm::cross(v, w);
    for (const double side : {-1.0, 1.0}) {
      const double offset = glm::dot(normal, center + side * u);
      meet(glm::dot(normal, base) - offset, glm::dot(normal, way));
      meet_paths({beam.lens_radius_m * normal.x, beam.lens_radius_m * normal.y, -offset});
      for (const double other : {-1.0, 1.0}) {
        const glm::dvec3 first = center + side * v + other * w - u;
        const glm::dvec3 last = first + 2.0 * u;
        meet_paths(
            glm::cross(glm::dvec3(first.x, first.y, weight(first, 1)), glm::dvec3(last.x, last.y, weight(last, 1))));
      }
    }
  }
  add_dark_between(
      places, [&](double t) { return judge_hides(beam, solid, beam.lens_m + base_from_lens + t * direction); }, dark);
}

// The air is visible up to `range_m` of the scene or to a nearer surface.
double visible_air_m(const JudgeScene& scene, const std::optional<SurfaceHit>& hit) {
  return hit ? std::min(hit->t_m, scene.range_m) : scene.range_m;
}

// `refinement` multiplies the number of pieces at the start of an integral.
const HazeDensity kEven;
struct Air {
  const fixtures::Haze& haze;
  const HazeDensity& density;
  bool even_extinction;
  const PlumeField* plumes = nullptr;
  std::span<const glm::dvec2> lens = {};  // points of it that cast shadows; none: paths of the model do
};
double inscatter(const JudgeBeam& beam, const Air& air, const Ray& ray, double t_min_m, double t_max_m,
                 const GoboTransmission& gobo, double tolerance, int refinement, std::span<const JudgeSolid> solids);

// Reflected light of a beam over its illuminance, of a surface with sheen.
glm::dvec3 sheen_share(const SurfaceHit& hit, const JudgeBeam& beam, const glm::dvec3& point_m, const glm::dvec3& ray) {
  const LightAt at = light_at(beam, {}, point_m - beam.lens_m);
  const f64::Sheen sheen = f64::sheen_of(hit.albedo, hit.albedo, hit.sheen->roughness, hit.sheen->metal);
  return f64::sheen_reflected(sheen, beam.lens_radius_m / at.distance_m, hit.normal, -ray, -at.direction);
}

glm::dvec3 radiance(const JudgeScene& scene, const Ray& ray, double tolerance, int refinement, double* hits);

// What a surface with sheen mirrors of the stage, less what it shows of the same light as even light, `even_lx`.
glm::dvec3 mirrored(const JudgeScene& scene, const SurfaceHit& hit, const glm::dvec3& point_m, const Ray& ray,
                    const glm::dvec3& even_lx, double tolerance, int refinement) {
  constexpr int kShareRays = 256;
  // What these rays meet mirrors nothing, as in a probe.
  JudgeScene seen = scene;
  seen.sheen_rays = 0;
  seen.matt = true;
  seen.bounced_side = 1;
  double others = 0;
  const auto light_from = [&](const glm::dvec3& direction) {
    return radiance(seen, {point_m, direction}, tolerance, refinement, &others);
  };
  const double rough = std::max(hit.sheen->roughness, static_cast<double>(f64::kSheenRoughnessLeast));
  const double cosine = std::max(-glm::dot(hit.normal, ray.direction), 0.0);
  const glm::dvec2 shares = sheen_shares(rough * rough, cosine, kShareRays);
  const double shown = glm::mix(static_cast<double>(f64::kSheenDielectric) * shares.x + shares.y, 1.0,
                                hit.sheen->metal);
  return judge_mirrored(*hit.sheen, hit.albedo, hit.normal, ray.direction, scene.sheen_rays, light_from) -
         shown * hit.albedo / std::numbers::pi * even_lx;
}

// Share of even light on what has triangles (work_light() of render/shaders/lib/surface_light.glsl).
double even_form(const glm::dvec3& normal, const glm::dvec3& way) {
  return 0.3 + 0.3 * (0.5 + 0.5 * normal.z) + 0.4 * std::max(-glm::dot(normal, way), 0.0);
}

glm::dvec3 radiance(const JudgeScene& scene, const Ray& ray, double tolerance, int refinement, double* hits) {
  glm::dvec3 total(0);
  const std::optional<SurfaceHit> hit = judge_hit(scene, ray);
  // Evaluates once for each of three channels if images are coloured, else only once.
  const auto in_colors = [&](const JudgeBeam& beam, const auto& share_through) {
    if (!scene.colors || !has_gobo(beam)) return glm::dvec3(share_through(scene.gobo));
    glm::dvec3 share(0);
    for (int c = 0; c < 3; ++c) {
      share[c] = share_through([&](int gobo, double x, double y) { return scene.colors(gobo, x, y)[c]; });
    }
    return share;
  };
  if (scene.haze.scattering_per_m > 0) {
    const double t_max_m = visible_air_m(scene, hit);
    for (const JudgeBeam& beam : scene.beams) {
      const glm::dvec3 share = in_colors(beam, [&](const GoboTransmission& gobo) {
        return inscatter(beam, {scene.haze, scene.density, scene.even_extinction, &scene.plumes, scene.lens}, ray,
                         0, t_max_m, gobo, tolerance, refinement, scene.solids);
      });
      if (share.x + share.y + share.z > 0) *hits += 1;
      total += scene.haze.scattering_per_m * share * beam.strength_lm;
    }
  }
  total += judge_shafts(scene, ray, hit ? hit->t_m : std::numeric_limits<double>::infinity());
  total += judge_displays(scene, ray, hit ? hit->t_m : std::numeric_limits<double>::infinity());
  if (hit) {
    const glm::dvec3 point_m = ray.origin_m + hit->t_m * ray.direction;
    glm::dvec3 even_lx(scene.ambient_lx * (hit->shaped ? even_form(hit->normal, ray.direction) : 1));
    if (scene.bounced_lx) even_lx += scene.bounced_lx(point_m, hit->normal, scene.bounced_side);
    glm::dvec3 lux = even_lx;
    glm::dvec3 of_sheen(0);
    for (const JudgeBeam& beam : scene.beams) {
      const glm::dvec3 open = in_colors(beam, [&](const GoboTransmission& gobo) {
        return judge_illuminance(beam, scene.haze, point_m, hit->normal, gobo);
      });
      if (!(open.x + open.y + open.z > 0)) continue;
      const double lit = judge_lit(beam, scene.lens, scene.solids, point_m);
      if (!(lit > 0)) continue;
      const glm::dvec3 beam_lux = lit * open * beam.strength_lm;
      if (hit->sheen) {
        of_sheen += beam_lux * sheen_share(*hit, beam, point_m, ray.direction);
      } else {
        lux += beam_lux;
      }
    }
    lux += judge_sun_lux(scene, point_m, hit->normal);
    lux += judge_display_lux(scene, point_m, hit->normal);
    glm::dvec3 light = hit->albedo * lux / std::numbers::pi + of_sheen;
    if (hit->sheen && scene.sheen_rays > 0) {
      light += mirrored(scene, *hit, point_m, ray, even_lx, tolerance, refinement);
    }
    if (const fixtures::GlossTop* gloss = hit->normal.z > 0 ? gloss_at(scene, point_m) : nullptr; gloss != nullptr) {
      const double share = gloss_share(gloss->gloss, -ray.direction.z);
      double others = 0;
      light = (1 - share) * light +
              share * mirrored_mean(gloss->gloss, ray.direction, scene.gloss_rays, [&](const glm::dvec3& direction) {
                return radiance(scene, {point_m, direction}, tolerance, refinement, &others);
              });
    }
    total += std::exp(-extinction_per_m(scene.haze) * hit->t_m - plume_depth(scene.plumes, ray, hit->t_m)) * light;
  }
  return total;
}

// Haze on a straight way, 1/m times m, by midpoints of 0.1 m.
double optical_depth(const Air& air, const glm::dvec3& from_m, const glm::dvec3& to_m) {
  const double length_m = glm::length(to_m - from_m);
  if (!air.density || air.even_extinction) return extinction_per_m(air.haze) * length_m;
  const int steps = std::max(1, static_cast<int>(std::ceil(length_m / 0.1)));
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += air.density(glm::mix(from_m, to_m, (i + 0.5) / steps));
  return (air.haze.scattering_per_m * sum / steps + air.haze.absorption_per_m) * length_m;
}

double inscatter(const JudgeBeam& beam, const Air& air, const Ray& ray, double t_min_m, double t_max_m,
                 const GoboTransmission& gobo, double tolerance, int refinement, std::span<const JudgeSolid> solids) {
  const fixtures::Haze& haze = air.haze;
  if (!is_finite(ray.origin_m) || !is_finite(ray.direction) || !std::isfinite(t_min_m) || !(t_max_m > t_min_m)) {
    return 0;
  }
  const LightRay light = light_ray(beam, ray);
  Wide base = 0;
  Wide from = 0;
  Wide to = 0;
  const auto interval = beam.aspect > 0 ? lit_in_rectangle : lit_interval;
  if (!interval(beam, light, t_min_m, t_max_m, base, from, to)) return 0;

  // Relative to the base, because that is far away if the camera is.
  const auto base_m = static_cast<double>(base);
  const glm::dvec3 base_from_lens = static_cast<double>(light.ox + base * light.dx) * beam.x_axis +
                                    static_cast<double>(light.oy + base * light.dy) * beam.y_axis +
                                    static_cast<double>(light.oz + base * light.dz) * beam.axis;
  const double sigma_t = extinction_per_m(haze);
  LitShare lit(std::max<std::size_t>(air.lens.size(), 1));
  for (std::size_t point = 0; point < std::max<std::size_t>(air.lens.size(), 1); ++point) {
    DarkParts dark;
    for (const JudgeSolid& solid : solids) {
      if (!may_hide(beam, solid)) continue;
      if (air.lens.empty()) {
        add_dark_parts(beam, solid, base_from_lens, ray.direction, static_cast<double>(from), static_cast<double>(to),
                       dark);
      } else {
        add_dark_parts_from(lens_place(beam, air.lens[point]), solid, beam.lens_m + base_from_lens, ray.direction,
                            static_cast<double>(from), static_cast<double>(to), dark);
      }
    }
    lit.add(std::move(dark));
  }
  lit.close();
  const auto integrand = [&](double t_m) {
    const double share = lit.at(t_m);
    if (!(share > 0)) return 0.0;
    const LightAt at = light_at(beam, gobo, base_from_lens + t_m * ray.direction);
    if (!(at.illuminance > 0) || !passes_blades(beam, at.rho)) return 0.0;
    const double scattering_cosine = -glm::dot(at.direction, ray.direction);
    const double light = share * at.illuminance * henyey_greenstein(scattering_cosine, haze.anisotropy);
    if (!air.density) return light * std::exp(-sigma_t * (base_m + t_m + at.distance_m));
    const glm::dvec3 place_m = beam.lens_m + base_from_lens + t_m * ray.direction;
    double depth = sigma_t * (base_m + t_m + at.distance_m);
    if (!air.even_extinction) {
      depth = optical_depth(air, ray.origin_m, place_m) +
              optical_depth(air, place_m - at.distance_m * at.direction, place_m);
    }
    if (air.even_extinction && air.plumes != nullptr) depth += plume_depth(*air.plumes, ray, base_m + t_m);
    return light * air.density(place_m) * std::exp(-depth);
  };

  // Cuts at points where the integrand can peak: nearest the lens, nearest the axis (the base), and at equal distances
  // on the gobo plane, because 1 / w^2 can change by decades. Rays through a gobo have more cuts, to resolve its
  // detail.
  const auto from_m = static_cast<double>(from);
  const auto to_m = static_cast<double>(to);
  std::vector<double> cuts{from_m, to_m};
  const auto cut = [&](double t_m) {
    if (t_m > from_m && t_m < to_m) cuts.push_back(t_m);
  };
  for (const auto& [place, change] : lit.changes()) cut(place);
  cut(0);
  cut(-glm::dot(base_from_lens, ray.direction) / glm::dot(ray.direction, ray.direction));
  const double w_base = beam.lens_radius_m + beam.spread * glm::dot(base_from_lens, beam.axis);
  const double w_slope = beam.spread * static_cast<double>(light.dz);
  const double w_from = w_base + from_m * w_slope;
  const double w_to = w_base + to_m * w_slope;
  const int parts = refinement * (has_gobo(beam) && gobo ? 48 : beam.measured ? 32 : beam.edges.empty() ? 4 : 16);
  for (int i = 1; i < parts; ++i) {
    const double x = static_cast<double>(i) / parts;
    cut(from_m + (to_m - from_m) * x * w_from / (w_to + x * (w_from - w_to)));
  }
  if (air.density) {
    const int clouds = refinement * std::min(static_cast<int>(std::ceil((to_m - from_m) / 0.25)), 400);
    for (int i = 1; i < clouds; ++i) cut(from_m + (to_m - from_m) * i / clouds);
  }
  std::sort(cuts.begin(), cuts.end());
  return integrate(integrand, cuts, tolerance);
}

}  // namespace

double judge_flux_factor(double spread, double profile_power, double shown) {
  // Substitutes q = rho^2: the area element of the disc is pi dq.
  const auto f = [&](double q) {
    return profile(q * shown * shown, profile_power) * std::pow(1 + spread * spread * q, -1.5);
  };
  return std::numbers::pi * integrate(f, {0.0, 1.0}, 1e-14);
}

double judge_rectangle_factor(double spread, double profile_power, double aspect, double shown) {
  const double square = shown * shown;
  const auto over_x = [&](double x) {
    const auto over_y = [&](double y) {
      return profile(x * x * square, profile_power) * profile(y * y * square, profile_power) *
             std::pow(1 + spread * spread * (x * x + y * y / (aspect * aspect)), -1.5);
    };
    return integrate(over_y, {0.0, 1.0}, 1e-12);
  };
  return 4 / aspect * integrate(over_x, {0.0, 1.0}, 1e-12);
}

namespace {

// Flux over J0 of the drawn beam.
double drawn_factor(const JudgeBeam& beam) {
  return beam.aspect > 0 ? judge_rectangle_factor(beam.spread, beam.profile_power, beam.aspect, beam.shown)
                         : judge_flux_factor(beam.spread, beam.profile_power, beam.shown);
}

// A measured beam's peak and edge, from the candela of its file.
struct MeasuredBeam {
  fixtures::Photometry photometry;
  fixtures::Side side = fixtures::Side::kFront;
  fixtures::MeasuredTable table;
};

// Flux over J0 at a spread, by the midpoint rule.
double measured_factor(const JudgeBeam& beam, double spread) {
  constexpr int kRings = 600;
  constexpr int kTurns = 360;
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    const double rho = (i + 0.5) / kRings;
    const double weight = rho * std::pow(1 + spread * spread * rho * rho, -1.5);
    for (int a = 0; a < kTurns; ++a) {
      const double turn = (a + 0.5) * 2 * std::numbers::pi / kTurns;
      sum += weight *
             beam.measured(rho * beam.measured_spread * std::cos(turn), rho * beam.measured_spread * std::sin(turn));
    }
  }
  return sum * 2 * std::numbers::pi / kRings / kTurns;
}

std::shared_ptr<const MeasuredBeam> measured_beam(const fixtures::Rig& rig, const fixtures::TypeSource& source) {
  const fixtures::FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
  const fixtures::Mode& mode = type.modes[static_cast<std::size_t>(source.mode)];
  const int index = mode.geometries[static_cast<std::size_t>(source.geometry)].beam;
  const fixtures::Beam& beam = type.beams[static_cast<std::size_t>(index)];
  auto photometry = fixtures::read_photometry_file(type.files, beam.photometry);
  FL_CHECK(photometry.has_value());  // compiling the rig has succeeded
  const auto side = beam.photometry_back ? fixtures::Side::kBack : fixtures::Side::kFront;
  fixtures::MeasuredTable table = fixtures::measured_table(*photometry, side, fixtures::zooms(mode));
  return std::make_shared<const MeasuredBeam>(MeasuredBeam{std::move(*photometry), side, std::move(table)});
}

}  // namespace

// Returns the edge of a blade. In a rectangular beam both insertions are shares of the beam's extent on that side, and
// the blade turns by true angles. The edge is computed from two points in half widths.
glm::dvec3 blade_of(double aspect, uint blade, double a, double b, double angle_rad) {
  if (!(aspect > 0)) return f64::blade_edge(blade, a, b, angle_rad);
  const glm::dvec3 edge = f64::blade_edge(blade, a, b, 0.0);
  // Two points of the edge in the square, then mapped to the rectangle.
  const glm::dvec2 n(edge.x, edge.y);
  const glm::dvec2 middle = n * edge.z;
  const auto in_rectangle = [&](const glm::dvec2& p) { return glm::dvec2(p.x, p.y / aspect); };
  const glm::dvec2 from = in_rectangle(middle);
  const glm::dvec2 along = in_rectangle(middle + glm::dvec2(-n.y, n.x)) - from;
  glm::dvec2 normal = glm::normalize(glm::dvec2(along.y, -along.x));
  const double distance = glm::dot(normal, from);
  normal = glm::dvec2(std::cos(angle_rad) * normal.x - std::sin(angle_rad) * normal.y,
                      std::sin(angle_rad) * normal.x + std::cos(angle_rad) * normal.y);
  return {normal.x, normal.y, distance};
}

JudgeScene judge_scene(const fixtures::Rig& rig, fixtures::f64::Walker& walker, GoboTransmission gobo,
                       std::int64_t time_ns) {
  JudgeScene scene;
  std::map<uint, std::shared_ptr<const MeasuredBeam>> measured;
  scene.boxes = rig.boxes;
  for (const fixtures::StageBox& box : rig.boxes) {
    const glm::dvec3 half = 0.5 * (box.max_m - box.min_m);
    scene.solids.push_back({0.5 * (box.min_m + box.max_m), {{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}}});
  }
  scene.glosses = fixtures::gloss_tops(rig);
  scene.haze = rig.haze;
  if (!rig.haze.even()) {
    scene.density = [field = haze_field(rig.haze, time_ns)](const glm::dvec3& place_m) {
      return f64::haze_density(field, place_m, 0.0);
    };
  }
  scene.ambient_lx = rig.ambient_lx;
  scene.range_m = kAirRangeM;
  const double range_m = light_range_m(rig);
  add_panes(scene, rig, range_m);
  add_displays(scene, rig, walker.rig, walker.levels);
  for (const fixtures::ScreenMotion& each : fixtures::screen_motions(rig, walker.rig)) {
    const auto& state = walker.states[each.head];
    const fixtures::HeadRow& row = walker.rig.heads[each.head];
    const fixtures::TypeRow& type = walker.rig.types[row.type];
    const auto turned = [&](const glm::dvec3& axis) {
      return walker.fixture_to_stage_direction(row, walker.chain_to_fixture(type, state, each.depth, axis, 0));
    };
    JudgeDisplay& display = scene.displays[each.display];
    if (each.lit) {
      for (glm::dvec3& pixel : display.pixels_cd_m2) pixel *= glm::dvec3(state.red, state.green, state.blue);
    }
    if (each.depth == 0) continue;
    display.center_m =
        walker.fixture_to_stage_point(row, walker.chain_to_fixture(type, state, each.depth, each.middle_m, 1));
    const glm::dvec3 up = glm::normalize(turned(each.up));
    const glm::dvec3 right = turned(each.right) - glm::dot(turned(each.right), up) * up;
    display.right_m = glm::normalize(right) * glm::length(display.right_m);
    display.up_m = up * glm::length(display.up_m);
  }
  scene.gobo = std::move(gobo);
  std::vector<std::size_t> heads;  // of the beams
  for (std::size_t i = 0; i < walker.states.size(); ++i) {
    const auto& state = walker.states[i];
    const fixtures::HeadRow& row = walker.rig.heads[i];
    const fixtures::TypeRow& type = walker.rig.types[row.type];
    const double flux_lm = static_cast<double>(type.flux_lm);
    const glm::dvec3 colour(state.red, state.green, state.blue);
    if (!(flux_lm > 0) || !(std::max({colour.x, colour.y, colour.z}) > 0)) continue;
    const auto pose = walker.beam_pose(row, type, state);
    JudgeBeam beam;
    beam.lens_m = pose.lens_m;
    beam.x_axis = pose.x_axis;
    beam.y_axis = pose.y_axis;
    beam.axis = pose.axis;
    beam.lens_radius_m = type.lens_radius_m;
    beam.spread = std::tan(f64::drawn_half_angle(state.zoom, static_cast<double>(type.aspect), type.measured != 0));
    const double zoom_spread = beam.spread;
    beam.profile_power = type.profile_power;
    beam.range_m = range_m;
    const bool shaped = row.optics != fixtures::kNoAddress;
    fixtures::f64::Walker::OpticsState optics{};
    beam.aspect = type.measured != 0 ? 0 : static_cast<double>(type.aspect);
    double passes = 1;  // share of the flux that passes the elements before the frost
    if (shaped) {
      optics = walker.optics_states[row.optics];
      const double rim = f64::focus_rim(beam.lens_radius_m, beam.spread, optics.focus);
      const double soft = std::max(optics.frost, rim);
      if (optics.iris < 1) {
        // The share of the lumens that pass the smaller opening.
        JudgeBeam within = beam;
        within.shown = optics.iris;
        within.spread *= optics.iris;
        passes = optics.iris * optics.iris * drawn_factor(within) / drawn_factor(beam);
        beam.shown = type.measured != 0 ? optics.iris : 1 - f64::iris_hidden(optics.iris, soft);
      }
      beam.profile_power = f64::softened_profile(beam.profile_power, soft);
      if (optics.frost > 0) {
        beam.spread = beam.spread * (1 + static_cast<double>(f64::kFrostWidens) * optics.frost) +
                      static_cast<double>(f64::kFrostAdds) * optics.frost;
      }
    }
    double measured_peak_cd = 0;
    if (type.measured != 0) {
      auto& known = measured[row.type];
      if (known == nullptr) known = measured_beam(rig, walker.rig.sources[row.type]);
      beam.measured = [shape = known](double x, double y) {
        return fixtures::beam_candela(shape->photometry, shape->side, x, y) / shape->table.peak_cd;
      };
      beam.measured_spread = std::tan(known->table.half_angle_rad);
      measured_peak_cd = known->table.peak_cd;
    }
    // Returns J0 of a beam whose spread is `scale` times that of `beam`, with the same lumens.
    const auto strength_lm = [&](const JudgeBeam& drawn, double scale) {
      if (!drawn.measured) return flux_lm * passes * colour / drawn_factor(drawn);
      // The candela of the file. If a zoom changes the spread, scaled to the same lumens.
      const double as_measured = drawn.measured_spread * drawn.measured_spread * measured_peak_cd;
      const double whole = beam.spread * scale;
      const bool zoomed = std::abs(whole / drawn.measured_spread - 1) > 1e-6;
      const double same_lumens =
          zoomed ? measured_factor(drawn, drawn.measured_spread) / measured_factor(drawn, whole) : 1;
      return colour * as_measured * same_lumens * drawn.shown * drawn.shown;
    };
    if (!shaped) {
      beam.strength_lm = strength_lm(beam, 1);
      scene.beams.push_back(beam);
      heads.push_back(i);
      continue;
    }
    const auto wheel = [](uint image, uint next, double offset, double angle) {
      return JudgeWheel{static_cast<int>(image), static_cast<int>(next), offset, std::cos(angle), std::sin(angle)};
    };
    beam.wheels[0] = wheel(optics.image_1, optics.next_1, optics.offset_1, optics.angle_1);
    beam.wheels[1] = wheel(optics.image_2, optics.next_2, optics.offset_2, optics.angle_2);
    beam.animation = static_cast<int>(optics.animation);
    beam.animation_cos = std::cos(optics.animation_angle);
    beam.animation_sin = std::sin(optics.animation_angle);
    beam.blur = static_cast<double>(f64::kFrostBlur) * optics.frost;
    beam.focus_per_m = optics.focus;
    double cut = 0;
    for (int b = 0; b < 4; ++b) cut += optics.blade_a[b] + optics.blade_b[b];
    for (uint b = 0; cut > 0 && b < 4; ++b) {
      beam.edges.push_back(blade_of(beam.aspect, b, optics.blade_a[b], optics.blade_b[b], optics.blade_angle[b]));
      beam.edges.back().z /= optics.iris;
    }
    // The iris passes the middle of the images.
    beam.gobo_scale = optics.iris;
    // Each facet of a prism maps the beam by p -> m p + at, in radii of the beam at its zoom.
    struct Copy {
      glm::dmat2 m{1};
      glm::dvec2 at{0};
      glm::dvec3 light{1};
    };
    std::vector<Copy> copies{{}};
    for (const auto& [prism, angle] :
         {std::pair(optics.prism, optics.prism_angle), std::pair(optics.prism_2, optics.prism_2_angle)}) {
      if (prism == 0) continue;
      const glm::dmat2 turn(std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle));
      const fixtures::WheelSlotRow& slot = walker.rig.wheel_slots[prism - 1];
      std::vector<Copy> next;
      for (uint f = 0; f < slot.facet_count; ++f) {
        const fixtures::FacetRow& facet = walker.rig.facets[slot.facet_first + f];
        const glm::dvec2 first(facet.turn_cos, facet.turn_sin);
        const glm::dmat2 image(first, static_cast<double>(facet.mirror) * glm::dvec2(-first.y, first.x));
        const glm::dmat2 m = turn * (static_cast<double>(facet.scale) * image) * glm::transpose(turn);
        const glm::dvec2 at = turn * glm::dvec2(facet.x, facet.y);
        const glm::dvec3 light = static_cast<double>(facet.share) * glm::dvec3(facet.red, facet.green, facet.blue);
        for (const Copy& copy : copies) next.push_back({m * copy.m, m * copy.at + at, light * copy.light});
      }
      copies = std::move(next);
    }
    JudgeBeam whole = beam;
    whole.lens_radius_m *= optics.iris;
    whole.spread *= optics.iris;
    for (const Copy& copy : copies) {
      JudgeBeam one = whole;
      const auto on_stage = [&](const glm::dvec2& v) { return v.x * pose.x_axis + v.y * pose.y_axis; };
      one.axis = glm::normalize(pose.axis + zoom_spread * on_stage(copy.at));
      const glm::dvec3 right = on_stage(copy.m[0]);
      one.x_axis = glm::normalize(right - one.axis * glm::dot(one.axis, right));
      one.y_axis = glm::cross(one.axis, one.x_axis);
      if (glm::dot(one.y_axis, on_stage(copy.m[1])) < 0) one.y_axis = -one.y_axis;
      const double scale = std::sqrt(std::abs(glm::determinant(copy.m)));
      one.spread = whole.spread * scale;
      one.strength_lm = strength_lm(one, scale) * copy.light;
      scene.beams.push_back(one);
      heads.push_back(i);
    }
  }
  add_mirrored(rig, walker, heads, scene);
  return scene;
}

double judge_inscatter(const JudgeBeam& beam, const fixtures::Haze& haze, const Ray& ray, double t_min_m,
                       double t_max_m, const GoboTransmission& gobo, double tolerance,
                       std::span<const JudgeSolid> solids, std::span<const glm::dvec2> lens) {
  return inscatter(beam, {haze, kEven, true, nullptr, lens}, ray, t_min_m, t_max_m, gobo, tolerance, 1, solids);
}

std::vector<glm::dvec2> judge_lens(int count) {
  std::vector<glm::dvec2> points;
  for (int i = 0; i < count; ++i) {
    const double r = std::sqrt((i + 0.5) / count);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    points.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return points;
}

double judge_lit(const JudgeBeam& beam, std::span<const glm::dvec2> lens, std::span<const JudgeSolid> solids,
                 const glm::dvec3& point_m) {
  const auto hidden = [&](const auto& hides) {
    return std::any_of(solids.begin(), solids.end(),
                       [&](const JudgeSolid& solid) { return may_hide(beam, solid) && hides(solid); });
  };
  if (lens.empty()) return hidden([&](const auto& solid) { return judge_hides(beam, solid, point_m); }) ? 0 : 1;
  double lit = 0;
  for (const glm::dvec2& place : lens) {
    const glm::dvec3 from_m = lens_place(beam, place);
    if (!hidden([&](const auto& solid) { return judge_hides_from(from_m, solid, point_m); })) lit += 1;
  }
  return lit / static_cast<double>(lens.size());
}

bool judge_hides(const JudgeBeam& beam, const JudgeSolid& solid, const glm::dvec3& point_m) {
  const glm::dvec3 from_lens = point_m - beam.lens_m;
  const double radius_m = beam.lens_radius_m + beam.spread * glm::dot(from_lens, beam.axis);
  const double scale = beam.lens_radius_m / radius_m;
  const glm::dvec3 lens_m = beam.lens_m + scale * (glm::dot(from_lens, beam.x_axis) * beam.x_axis +
                                                   glm::dot(from_lens, beam.y_axis) * beam.y_axis);
  return judge_hides_from(lens_m, solid, point_m);
}

bool judge_hides_from(const glm::dvec3& lens_m, const JudgeSolid& solid, const glm::dvec3& point_m) {
  const JudgeSolid thick = thickened(solid);
  const glm::dvec3 path = point_m - lens_m;
  double enter = 0;
  double leave = 1;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 normal = glm::cross(thick.half_m[(i + 1) % 3], thick.half_m[(i + 2) % 3]);
    const double reach = std::abs(glm::dot(normal, thick.half_m[i]));
    if (!(reach > 0)) return false;
    const double at = glm::dot(normal, lens_m - thick.center_m);
    const double rise = glm::dot(normal, path);
    if (rise == 0) {
      if (std::abs(at) > reach) return false;
      continue;
    }
    const double first = (-reach - at) / rise;
    const double last = (reach - at) / rise;
    enter = std::max(enter, std::min(first, last));
    leave = std::min(leave, std::max(first, last));
  }
  return leave >= enter && (1 - enter) * glm::length(path) > solid.slack_m;
}

double judge_illuminance(const JudgeBeam& beam, const fixtures::Haze& haze, const glm::dvec3& point_m,
                         const glm::dvec3& normal, const GoboTransmission& gobo) {
  const glm::dvec3 from_lens = point_m - beam.lens_m;
  const double z = glm::dot(from_lens, beam.axis);
  if (!(z > 0) || !(z <= beam.range_m)) return 0;
  const LightAt at = light_at(beam, gobo, from_lens);
  const double cosine = std::max(0.0, -glm::dot(normal, at.direction));
  double through = 1;
  const double soft = static_cast<double>(f64::kBladeSoft) +
                      2 * f64::focus_blur(beam.lens_radius_m, beam.spread, at.z_m, beam.focus_per_m);
  for (const glm::dvec3& edge : beam.edges) {
    through *= std::clamp((edge.z - edge.x * at.rho.x - edge.y * at.rho.y) / soft + 0.5, 0.0, 1.0);
  }
  return through * at.illuminance * cosine * std::exp(-extinction_per_m(haze) * at.distance_m);
}

std::optional<SurfaceHit> judge_hit(const JudgeScene& scene, const Ray& ray) {
  std::optional<SurfaceHit> nearest;
  for (const fixtures::StageBox& box : scene.boxes) {
    double enter = -std::numeric_limits<double>::infinity();
    double leave = std::numeric_limits<double>::infinity();
    int side = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray.direction[axis];
      const double o = ray.origin_m[axis];
      if (d == 0) {
        if (o < box.min_m[axis] || o > box.max_m[axis]) leave = -std::numeric_limits<double>::infinity();
        continue;
      }
      const double a = (box.min_m[axis] - o) / d;
      const double b = (box.max_m[axis] - o) / d;
      if (std::min(a, b) > enter) {
        enter = std::min(a, b);
        side = axis;
      }
      leave = std::min(leave, std::max(a, b));
    }
    if (!(enter > 0) || !(enter <= leave) || (nearest && nearest->t_m <= enter)) continue;
    SurfaceHit hit;
    hit.t_m = enter;
    hit.normal[side] = ray.direction[side] > 0 ? -1.0 : 1.0;
    hit.albedo = box.albedo;
    hit.sheen = box.sheen && !box.sheen->matt() ? box.sheen : std::nullopt;
    nearest = hit;
  }
  if (scene.others) {
    const std::optional<SurfaceHit> other = scene.others(ray);
    if (other && (!nearest || other->t_m < nearest->t_m)) nearest = other;
  }
  if (nearest && scene.matt) nearest->sheen.reset();
  return nearest;
}

glm::dvec3 judge_radiance(const JudgeScene& scene, const Ray& ray, double tolerance) {
  double hits = 0;
  return radiance(scene, ray, tolerance, 1, &hits);
}

Ray pixel_ray(const View& view, int width, int height, int x, int y) {
  const double across = (2 * (x + 0.5) / width - 1) * view.tan_half_fov * width / height;
  const double upward = (1 - 2 * (y + 0.5) / height) * view.tan_half_fov;
  return {view.position_m, glm::normalize(view.forward + view.right * across + view.up * upward)};
}

JudgedPixels judge_pixels(const JudgeScene& scene, const View& view, int width, int height,
                          std::span<const std::uint32_t> pixels, const JudgeOptions& options) {
  FL_CHECK_GT(width, 0);
  FL_CHECK_GT(height, 0);
  FL_CHECK(!pixels.empty());
  const std::size_t count = pixels.size();
  JudgedPixels judged;
  judged.rgb.resize(3 * count);
  judged.hits.resize(count);
  std::vector<double> coarse(options.stated_error ? 3 * count : 0);

  // Threads take a few pixels at a time, so that none waits for bright ones. Each pixel is computed independently, so
  // the picture does not depend on the number of threads.
  constexpr std::size_t kAtOnce = 16;
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> done{0};
  std::atomic<bool> ended{false};
  const auto caller = std::this_thread::get_id();
  const auto work = [&] {
    for (std::size_t first = next.fetch_add(kAtOnce); first < count && !ended; first = next.fetch_add(kAtOnce)) {
      if (options.go_on && std::this_thread::get_id() == caller &&
          !options.go_on(static_cast<int>(done.load()), static_cast<int>(count))) {
        ended = true;
        return;
      }
      const std::size_t last = std::min(first + kAtOnce, count);
      for (std::size_t i = first; i < last; ++i) {
        const auto across = static_cast<std::uint32_t>(width);
        const Ray ray =
            pixel_ray(view, width, height, static_cast<int>(pixels[i] % across), static_cast<int>(pixels[i] / across));
        // Starts with three times as many pieces. Otherwise both passes would use the same nodes in smooth light, and
        // their difference would not measure an error.
        const glm::dvec3 fine = radiance(scene, ray, options.tolerance / 100, 3, &judged.hits[i]);
        for (std::size_t c = 0; c < 3; ++c) judged.rgb[3 * i + c] = fine[static_cast<int>(c)];
        if (!options.stated_error) continue;
        const glm::dvec3 rough = judge_radiance(scene, ray, options.tolerance);
        for (std::size_t c = 0; c < 3; ++c) coarse[3 * i + c] = rough[static_cast<int>(c)];
      }
      done += last - first;
    }
  };
  on_threads(options.threads, work);
  judged.whole = !ended;

  Wide sum = 0;
  Wide square = 0;
  for (const double value : judged.rgb) {
    sum += value;
    square += Wide(value) * value;
  }
  if (options.stated_error && square > 0) {
    const auto floor_value = static_cast<double>(1e-2L * sum / static_cast<Wide>(judged.rgb.size()));
    Wide difference = 0;
    for (std::size_t i = 0; i < judged.rgb.size(); ++i) {
      const double d = std::abs(coarse[i] - judged.rgb[i]);
      difference += Wide(d) * d;
      judged.own_max = std::max(judged.own_max, d / (judged.rgb[i] + floor_value));
    }
    judged.own_rel_l2 = static_cast<double>(std::sqrt(difference / square));
  }
  return judged;
}

JudgedImage judge_image(const JudgeScene& scene, const View& view, int width, int height, const JudgeOptions& options) {
  std::vector<std::uint32_t> all(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::iota(all.begin(), all.end(), 0u);
  JudgedPixels pixels = judge_pixels(scene, view, width, height, all, options);
  JudgedImage judged;
  judged.image = {width, height, std::vector<float>(pixels.rgb.begin(), pixels.rgb.end())};
  judged.rgb = std::move(pixels.rgb);
  judged.own_rel_l2 = pixels.own_rel_l2;
  judged.own_max = pixels.own_max;
  for (const double hits : pixels.hits) judged.hits_per_px += hits / static_cast<double>(all.size());
  judged.whole = pixels.whole;
  return judged;
}

}  // namespace footlight::render
