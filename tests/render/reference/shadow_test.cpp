// The shadows of render/shaders/shared/shadow.h, in float and in double, compared with the judge's traced paths.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/beam.h"
#include "render/reference/judge.h"
#include "tests/render/reference/kernel_cases.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using cases::Random;

struct ShadowCase {
  JudgeBeam beam;
  JudgeSolid solid;
  Ray ray;
};

// A box, 0.05 to 1.5 m a side, turned at random.
JudgeSolid random_box(Random& random, const glm::dvec3& center_m) {
  const glm::dvec3 x = random.direction();
  const glm::dvec3 y = glm::normalize(glm::cross(x, random.direction()));
  const glm::dvec3 z = glm::cross(x, y);
  return {center_m, {x * random.uniform(0.05, 1.5), y * random.uniform(0.05, 1.5), z * random.uniform(0.05, 1.5)}};
}

// A beam along a random axis, and a ray through a place in it.
ShadowCase random_case(Random& random, double k_min, double k_max, double depth_min, double depth_max) {
  ShadowCase c;
  c.beam.lens_m = {random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(-20, 20)};
  c.beam.axis = random.direction();
  c.beam.x_axis = glm::normalize(glm::cross(c.beam.axis, random.direction()));
  c.beam.y_axis = glm::cross(c.beam.axis, c.beam.x_axis);
  c.beam.lens_radius_m = random.uniform(0.01, 0.15);
  c.beam.spread = random.uniform(k_min, k_max);
  c.beam.range_m = 40;
  const auto place = [&](double z, double reach) {
    const double w = c.beam.lens_radius_m + c.beam.spread * std::max(z, 0.0);
    return c.beam.lens_m + z * c.beam.axis + w * reach * random.uniform(-1, 1) * c.beam.x_axis +
           w * reach * random.uniform(-1, 1) * c.beam.y_axis;
  };
  c.solid = random_box(random, place(random.uniform(depth_min, depth_max), 1.2));
  const glm::dvec3 target = place(random.uniform(0.1, 30), 0.7);
  c.ray.direction = random.direction();
  c.ray.origin_m = target - c.ray.direction * random.uniform(0.5, 40);
  return c;
}

struct Shadow {
  bool seen = false;  // the ray meets the beam
  bool any = false;
  double from_m = 0;  // of the chord, along the ray
  double to_m = 0;
  double dark_from_m = 0;
  double dark_to_m = 0;
};

// place_m: light comes from this place on the lens alone.
#define FL_TEST_SHADOW(name, space)                                                                             \
  Shadow name(const ShadowCase& c, const std::optional<glm::dvec2>& place_m = {}) {                             \
    namespace k = render::space;                                                                                \
    using R = k::Real;                                                                                          \
    const auto turned = [&](const glm::dvec3& v) {                                                              \
      return k::Vec3(glm::dot(v, c.beam.x_axis), glm::dot(v, c.beam.y_axis), glm::dot(v, c.beam.axis));         \
    };                                                                                                          \
    const k::BeamShape beam{static_cast<R>(c.beam.lens_radius_m), static_cast<R>(c.beam.spread),                \
                            static_cast<R>(c.beam.range_m), R(1)};                                              \
    const k::Vec3 eye = turned(c.ray.origin_m - c.beam.lens_m);                                                 \
    const k::Vec3 way = turned(c.ray.direction);                                                                \
    Shadow shadow;                                                                                              \
    k::Chord chord;                                                                                             \
    shadow.seen = k::beam_chord(beam, eye, way, R(0), R(1e30), chord);                                          \
    if (!shadow.seen) return shadow;                                                                            \
    k::ShadowSolid solid;                                                                                       \
    solid.center = turned(c.solid.center_m - c.beam.lens_m);                                                    \
    for (int i = 0; i < 3; ++i) solid.half_edge[i] = turned(c.solid.half_m[i]);                                 \
    shadow.from_m = static_cast<double>(chord.t_base_m + chord.t_from_m);                                       \
    shadow.to_m = static_cast<double>(chord.t_base_m + chord.t_to_m);                                           \
    k::ShadowPrism prism;                                                                                       \
    const glm::dvec2 at = place_m.value_or(glm::dvec2(0));                                                      \
    const k::Vec3 point(static_cast<R>(at.x), static_cast<R>(at.y), R(0));                                      \
    const bool has_shadow = place_m ? k::shadow_prism_from(point, solid, prism)                                 \
                                    : k::shadow_prism(beam.lens_radius_m, beam.spread, solid, prism);           \
    if (!has_shadow) return shadow;                                                                             \
    R x0 = 0;                                                                                                   \
    R x1 = 1;                                                                                                   \
    shadow.any = true;                                                                                          \
    for (unsigned i = 0; i < prism.count && shadow.any; ++i) {                                                  \
      const auto& plane = prism.planes[i];                                                                      \
      const auto h = [&](R t, R w) { return (k::dot(plane.normal, chord.base + way * t) - plane.offset) / w; }; \
      shadow.any = k::shadow_cut(h(chord.t_from_m, chord.w_from), h(chord.t_to_m, chord.w_to), x0, x1);         \
    }                                                                                                           \
    if (!shadow.any) return shadow;                                                                             \
    const k::Chord dark = k::chord_part(chord, x0, x1);                                                         \
    shadow.dark_from_m = static_cast<double>(dark.t_base_m + dark.t_from_m);                                    \
    shadow.dark_to_m = static_cast<double>(dark.t_base_m + dark.t_to_m);                                        \
    return shadow;                                                                                              \
  }
FL_TEST_SHADOW(in_float, f32)
FL_TEST_SHADOW(in_double, f64)

struct Count {
  int rays = 0;
  int shadows = 0;
  int wrong = 0;        // places farther than the slack from an end that are on the wrong side in double
  int wrong_float = 0;  // farther than 5 mm in float
};

void add(const ShadowCase& c, Random& random, Count& count) {
  const Shadow fine = in_double(c);
  const Shadow coarse = in_float(c);
  if (!fine.seen || !coarse.seen) return;
  ++count.rays;
  if (fine.any) ++count.shadows;
  for (int i = 0; i < 40; ++i) {
    const double t = random.uniform(fine.from_m, fine.to_m);
    const bool dark = judge_hides(c.beam, c.solid, c.ray.origin_m + t * c.ray.direction);
    const auto differs = [&](const Shadow& shadow, double slack_m) {
      const bool inside = shadow.any && t > shadow.dark_from_m && t < shadow.dark_to_m;
      if (inside == dark) return false;
      // Near an end either is right; so it is where the whole shadow is that short.
      const bool near =
          shadow.any && std::min(std::abs(t - shadow.dark_from_m), std::abs(t - shadow.dark_to_m)) < slack_m;
      const glm::dvec3 p = c.ray.origin_m + t * c.ray.direction;
      const bool both = judge_hides(c.beam, c.solid, p + slack_m * c.ray.direction) == dark &&
                        judge_hides(c.beam, c.solid, p - slack_m * c.ray.direction) == dark;
      return !near && both;
    };
    if (differs(fine, 1e-7)) ++count.wrong;
    if (differs(coarse, 5e-3)) ++count.wrong_float;
  }
}

TEST_CASE("the shadow of a box on a ray ends where traced paths say so, in every position of the box") {
  struct Range {
    const char* name;
    double k_min, k_max, depth_min, depth_max;
  };
  for (const Range& range :
       {Range{"narrow", 0.005, 0.05, 0.5, 25}, Range{"wash", 0.1, 0.6, 0.5, 25}, Range{"wide", 0.9, 4, 0.5, 20},
        Range{"cylinder", 0, 0, 0.5, 25}, Range{"across the lens plane", 0.05, 0.6, -1, 1},
        Range{"behind the lens", 0.05, 0.6, -3, -0.5}}) {
    CAPTURE(range.name);
    Random random(7);
    Count count;
    for (int i = 0; i < 1500; ++i) {
      add(random_case(random, range.k_min, range.k_max, range.depth_min, range.depth_max), random, count);
    }
    CHECK(count.rays > 800);
    CHECK(count.shadows > 50);
    CHECK(count.wrong == 0);
    CHECK(count.wrong_float <= 2);
  }
}

TEST_CASE("plates without thickness, a lens inside a box and a lamp that shines along a face have the traced shadows") {
  Random random(11);
  Count plates;
  Count inside;
  Count along;
  for (int i = 0; i < 1500; ++i) {
    ShadowCase plate = random_case(random, 0.02, 0.5, 0.5, 20);
    plate.solid.half_m[static_cast<std::size_t>(random.uniform(0, 3))] = glm::dvec3(0);
    add(plate, random, plates);
    ShadowCase lens = random_case(random, 0.02, 0.5, 0.5, 20);
    lens.solid.center_m = lens.beam.lens_m + 0.02 * random.direction();
    add(lens, random, inside);
    // The apex lies in the plane of a face.
    ShadowCase face = random_case(random, 0.05, 0.5, 2, 20);
    const glm::dvec3 apex = face.beam.lens_m - face.beam.axis * (face.beam.lens_radius_m / face.beam.spread);
    const glm::dvec3 normal = glm::normalize(face.solid.half_m[0]);
    face.solid.center_m += normal * glm::dot(normal, apex - face.solid.center_m) - face.solid.half_m[0];
    add(face, random, along);
  }
  for (const Count& count : {plates, inside, along}) {
    CHECK(count.rays > 800);
    CHECK(count.shadows > 100);
    CHECK(count.wrong == 0);
    CHECK(count.wrong_float <= 2);
  }
}

TEST_CASE("what is nothing, a line or a point has no shadow, and numbers that are none give none") {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    ShadowCase c = random_case(random, 0.02, 0.5, 0.5, 20);
    const std::size_t kept = static_cast<std::size_t>(random.uniform(0, 4));
    for (std::size_t h = 0; h < 3; ++h) {
      if (h != kept) c.solid.half_m[h] = glm::dvec3(0);
    }
    CHECK(!in_double(c).any);
    c.solid.half_m[0] = glm::dvec3(std::nan(""));
    CHECK(!in_double(c).any);
  }
}

TEST_CASE("shadows that overlap are one, and of more than have a place the narrowest are given up") {
  namespace k = render::f64;
  Random random(5);
  for (int round = 0; round < 2000; ++round) {
    const int count = 1 + static_cast<int>(random.uniform(0, 12));
    k::ShadowParts parts;
    k::shadow_parts_clear(parts);
    std::vector<std::pair<double, double>> given;
    for (int i = 0; i < count; ++i) {
      const double from = random.uniform(0, 1);
      const double to = std::min(1.0, from + random.uniform(0, round % 2 == 0 ? 0.3 : 0.05));
      k::shadow_parts_add(parts, from, to);
      given.emplace_back(from, to);
    }
    double lit = 0;
    double x = 0;
    int shadows = 0;
    for (;;) {
      double from = 0;
      double to = 0;
      const bool more = k::shadow_parts_next(parts, x, from, to);
      lit += std::min(from, 1.0) - x;
      if (!more) break;
      CHECK(from >= x);
      x = to;
      ++shadows;
    }
    std::sort(given.begin(), given.end());
    std::vector<std::pair<double, double>> joined;
    for (const auto& part : given) {
      if (!joined.empty() && part.first <= joined.back().second) {
        joined.back().second = std::max(joined.back().second, part.second);
      } else {
        joined.push_back(part);
      }
    }
    double dark = 0;
    for (const auto& part : joined) dark += part.second - part.first;
    if (given.size() <= FL_SHADOW_PARTS) {
      CHECK(shadows == static_cast<int>(joined.size()));
      CHECK(lit == doctest::Approx(1 - dark).epsilon(1e-12));
    } else {
      CHECK(shadows <= FL_SHADOW_PARTS);
      CHECK(lit >= 1 - dark - 1e-12);
      if (joined.size() > FL_SHADOW_PARTS) CHECK(lit > 1 - dark);
    }
  }
}

TEST_CASE("the judge's light through a shadow is the light of the two parts beside it") {
  Random random(13);
  int shaded = 0;
  for (int i = 0; i < 400; ++i) {
    const ShadowCase c = random_case(random, 0.05, 0.4, 0.5, 20);
    const Shadow shadow = in_double(c);
    if (!shadow.any) continue;
    ++shaded;
    const fixtures::Haze haze{0.02, 0.001, 0.4, 0};
    const std::vector<JudgeSolid> solids{c.solid};
    const double through = judge_inscatter(c.beam, haze, c.ray, 0, 1000, {}, 1e-10, solids);
    const double before = judge_inscatter(c.beam, haze, c.ray, 0, std::max(shadow.dark_from_m, 0.0), {}, 1e-10);
    const double after = judge_inscatter(c.beam, haze, c.ray, std::max(shadow.dark_to_m, 0.0), 1000, {}, 1e-10);
    CHECK(through == doctest::Approx(before + after).epsilon(1e-6).scale(1e-9));
  }
  CHECK(shaded > 30);
}

// As add(), for straight lines from a random place on the lens.
void add_from_lens(const ShadowCase& c, Random& random, Count& count) {
  const double r = std::sqrt(random.uniform(0, 1));
  const double angle = random.uniform(0, 6.283185307179586);
  const glm::dvec2 place_m = c.beam.lens_radius_m * r * glm::dvec2(std::cos(angle), std::sin(angle));
  const glm::dvec3 lens_m = c.beam.lens_m + place_m.x * c.beam.x_axis + place_m.y * c.beam.y_axis;
  const Shadow fine = in_double(c, place_m);
  const Shadow coarse = in_float(c, place_m);
  if (!fine.seen || !coarse.seen) return;
  ++count.rays;
  if (fine.any) ++count.shadows;
  for (int i = 0; i < 40; ++i) {
    const double t = random.uniform(fine.from_m, fine.to_m);
    const auto dark_at = [&](double t_m) {
      return judge_hides_from(lens_m, c.solid, c.ray.origin_m + t_m * c.ray.direction);
    };
    const bool dark = dark_at(t);
    const auto differs = [&](const Shadow& shadow, double slack_m) {
      const bool inside = shadow.any && t > shadow.dark_from_m && t < shadow.dark_to_m;
      if (inside == dark) return false;
      const bool near =
          shadow.any && std::min(std::abs(t - shadow.dark_from_m), std::abs(t - shadow.dark_to_m)) < slack_m;
      return !near && dark_at(t + slack_m) == dark && dark_at(t - slack_m) == dark;
    };
    if (differs(fine, 1e-7)) ++count.wrong;
    if (differs(coarse, 5e-3)) ++count.wrong_float;
  }
}

TEST_CASE("the shadow from a place on the lens ends where straight lines say so, in every position of a box") {
  Random random(17);
  Count free;
  Count across;
  Count behind;
  Count plates;
  Count inside;
  for (int i = 0; i < 1500; ++i) {
    add_from_lens(random_case(random, 0, 1.5, 0.5, 25), random, free);
    add_from_lens(random_case(random, 0.05, 0.6, -1, 1), random, across);
    add_from_lens(random_case(random, 0.05, 0.6, -3, -0.5), random, behind);
    ShadowCase plate = random_case(random, 0.02, 0.5, 0.5, 20);
    plate.solid.half_m[static_cast<std::size_t>(random.uniform(0, 3))] = glm::dvec3(0);
    add_from_lens(plate, random, plates);
    ShadowCase lens = random_case(random, 0.02, 0.5, 0.5, 20);
    lens.solid.center_m = lens.beam.lens_m + 0.02 * random.direction();
    add_from_lens(lens, random, inside);
  }
  for (const Count& count : {free, across, behind, plates, inside}) {
    CHECK(count.rays > 800);
    CHECK(count.shadows > 50);
    CHECK(count.wrong == 0);
    CHECK(count.wrong_float <= 2);
  }
}

TEST_CASE("points of a lens have the moments of its disc, and their weights are all of it") {
  namespace k = render::f64;
  for (const unsigned points : {1u, 4u, 7u}) {
    double all = 0;
    double square = 0;
    double mixed = 0;
    double fourth = 0;
    glm::dvec3 mean(0);
    for (unsigned i = 0; i < points; ++i) {
      const glm::dvec3 p = k::lens_point(points, i, 1.0);
      const double weight = k::lens_point_weight(points, i);
      CHECK(p.z == 0);
      all += weight;
      mean += weight * p;
      square += weight * p.x * p.x;
      mixed += weight * p.x * p.y;
      fourth += weight * p.x * p.x * p.x * p.x;
    }
    CHECK(all == doctest::Approx(1).epsilon(1e-14));
    CHECK(glm::length(mean) < 1e-14);
    if (points > 1) CHECK(square == doctest::Approx(0.25).epsilon(1e-12));
    CHECK(std::abs(mixed) < 1e-12);
    if (points == 7) CHECK(fourth == doctest::Approx(0.125).epsilon(1e-12));
  }
}

TEST_CASE("weights of a whole chord's nodes give the light of its parts, and of all parts together that of the chord") {
  namespace k = render::f64;
  Random random(19);
  for (int round = 0; round < 200; ++round) {
    const unsigned nodes = 2 + static_cast<unsigned>(round % 7);
    const double from = random.uniform(0, 1);
    const double to = random.uniform(from, 1);
    k::ShadowWeights some;
    k::shadow_weights_clear(some);
    k::shadow_weights_add(some, 0.3, from, to);
    k::ShadowWeights rest;
    k::shadow_weights_clear(rest);
    k::shadow_weights_add(rest, 1.0, 0.0, from);
    k::shadow_weights_add(rest, 0.7, from, to);
    k::shadow_weights_add(rest, 1.0, to, 1.0);
    k::shadow_weights_invert(rest);
    // Any polynomial of a degree below the number of nodes is exact.
    double sum = 0;
    for (unsigned i = 0; i < nodes; ++i) {
      const double x = k::kGaussNode[k::gauss_index(nodes, i)];
      const double weight = k::kGaussWeight[k::gauss_index(nodes, i)];
      CHECK(k::shadow_weight(some, nodes, x) == doctest::Approx(k::shadow_weight(rest, nodes, x)).epsilon(1e-9));
      sum += weight * k::shadow_weight(some, nodes, x) * std::pow(x, nodes - 1);
    }
    const double exact = 0.3 * (std::pow(to, nodes) - std::pow(from, nodes)) / nodes;
    CHECK(sum == doctest::Approx(exact).epsilon(1e-9).scale(1e-3));
  }
}

// Error of the polynomial of so many nodes for parts of chords, in beams up to 0.35, which 4 nodes are for: relative L2
// against 8 nodes for each part.
template <class ToReal, class Light>
double series_error(unsigned nodes, const ToReal& until, const Light& light) {
  Random random(31);
  double error = 0, square = 0;
  for (const cases::BeamRay& ray : cases::rays_of("generic", 400, 1)) {
    if (ray.spread > 0.35F) continue;
    const double from = random.uniform(0, 1);
    const double to = random.uniform(from, 1);
    const double expected = light(ray, from, to);
    const double own = until(ray, nodes, from, to);
    error += (own - expected) * (own - expected);
    square += expected * expected;
  }
  return std::sqrt(error / square);
}

TEST_CASE("the polynomial of a chord's light gives that of its parts, nearer with more nodes, and as near in float") {
  namespace k = render::f64;
  namespace kf = render::f32;
  const auto light = [](const cases::BeamRay& ray, double from, double to) {
    const k::BeamShape beam{ray.lens_radius_m, ray.spread, ray.range_m, ray.profile_power};
    const k::Medium medium{ray.anisotropy, ray.extinction_per_m};
    const glm::dvec3 way(ray.direction);
    k::Chord chord;
    if (!k::beam_chord(beam, glm::dvec3(ray.origin_m), way, 0, ray.t_max_m, chord)) return 0.0;
    return k::chord_inscatter_gauss(beam, medium, k::chord_part(chord, from, to), way, 8, true);
  };
  const auto in_double = [](const cases::BeamRay& ray, unsigned nodes, double from, double to) {
    const k::BeamShape beam{ray.lens_radius_m, ray.spread, ray.range_m, ray.profile_power};
    const k::Medium medium{ray.anisotropy, ray.extinction_per_m};
    const glm::dvec3 way(ray.direction);
    k::Chord chord;
    if (!k::beam_chord(beam, glm::dvec3(ray.origin_m), way, 0, ray.t_max_m, chord)) return 0.0;
    k::ShadowSeries series;
    k::shadow_series(beam, medium, chord, way, nodes, true, series);
    const double whole = k::chord_inscatter_gauss(beam, medium, chord, way, nodes, true);
    CHECK(series.whole == doctest::Approx(whole).epsilon(1e-12));
    CHECK(k::shadow_series_until(series, 1) == doctest::Approx(whole).epsilon(1e-12));
    CHECK(std::abs(k::shadow_series_until(series, 0)) < 1e-12 * whole + 1e-300);
    return k::shadow_series_until(series, to) - k::shadow_series_until(series, from);
  };
  const auto in_float = [](const cases::BeamRay& ray, unsigned nodes, double from, double to) {
    const kf::BeamShape beam{ray.lens_radius_m, ray.spread, ray.range_m, ray.profile_power};
    const kf::Medium medium{ray.anisotropy, ray.extinction_per_m};
    kf::Chord chord;
    if (!kf::beam_chord(beam, ray.origin_m, ray.direction, 0, ray.t_max_m, chord)) return 0.0;
    kf::ShadowSeries series;
    kf::shadow_series(beam, medium, chord, ray.direction, nodes, true, series);
    return static_cast<double>(kf::shadow_series_until(series, static_cast<float>(to)) -
                               kf::shadow_series_until(series, static_cast<float>(from)));
  };
  const double four = series_error(4, in_double, light);
  const double six = series_error(6, in_double, light);
  const double six_float = series_error(6, in_float, light);
  std::fprintf(stderr, "light of parts by a polynomial: 4 nodes %.3g, 6 nodes %.3g, in float %.3g\n", four, six,
               six_float);
  CHECK(four < 3e-3);
  CHECK(six < 0.1 * four);
  CHECK(six_float < six + 1e-5);
  // Profiles of a higher degree, with as many nodes as exact shadows have for them (plainbeams.comp).
  for (const double power : {4.0, 3.0, 1.0 / 3, 0.25}) {
    CAPTURE(power);
    const auto shaped = [power](const auto& light_of) {
      return [power, &light_of](cases::BeamRay ray, auto... rest) {
        ray.profile_power = static_cast<float>(power);
        return light_of(ray, rest...);
      };
    };
    const double eight = series_error(8, shaped(in_double), shaped(light));
    const double eight_float = series_error(8, shaped(in_float), shaped(light));
    std::fprintf(stderr, "profile of m = %.3g: 8 nodes %.3g, in float %.3g\n", power, eight, eight_float);
    CHECK(eight < 3e-3);
    CHECK(eight_float < eight + 1e-5);
  }
}

// Light of a beam along a ray through the shadows of a body, seen from so many points of the lens.
double soft_light(const ShadowCase& c, const fixtures::Haze& haze, unsigned points, unsigned nodes) {
  namespace k = render::f64;
  const auto turned = [&](const glm::dvec3& v) {
    return glm::dvec3(glm::dot(v, c.beam.x_axis), glm::dot(v, c.beam.y_axis), glm::dot(v, c.beam.axis));
  };
  const k::BeamShape beam{c.beam.lens_radius_m, c.beam.spread, c.beam.range_m, 1};
  const glm::dvec3 way = turned(c.ray.direction);
  k::Chord chord;
  if (!k::beam_chord(beam, turned(c.ray.origin_m - c.beam.lens_m), way, 0, 1e30, chord)) return 0;
  k::ShadowSolid solid;
  solid.center = turned(c.solid.center_m - c.beam.lens_m);
  for (int i = 0; i < 3; ++i) solid.half_edge[i] = turned(c.solid.half_m[i]);
  k::ShadowWeights weights;
  k::shadow_weights_clear(weights);
  for (unsigned p = 0; p < points; ++p) {
    k::ShadowPrism prism;
    bool any = points > 1 ? k::shadow_prism_from(k::lens_point(points, p, beam.lens_radius_m), solid, prism)
                          : k::shadow_prism(beam.lens_radius_m, beam.spread, solid, prism);
    if (!any) continue;
    const glm::dvec3 point = k::lens_point(points, p, beam.lens_radius_m);
    const double radius = points > 1 ? k::lens_part_radius(points) * beam.lens_radius_m : 0;
    const auto h = [&](unsigned i, double t, double w) {
      return (glm::dot(prism.planes[i].normal, chord.base + way * t) - prism.planes[i].offset) / w;
    };
    const unsigned outline = prism.count - prism.fronts;
    glm::dvec2 rise(1e9);
    for (unsigned i = outline; i < prism.count; ++i) {
      const double at_point = glm::dot(prism.planes[i].normal, point) - prism.planes[i].offset;
      rise.x = std::min(rise.x, -h(i, chord.t_from_m, chord.w_from) / std::max(at_point, 1e-9));
      rise.y = std::min(rise.y, -h(i, chord.t_to_m, chord.w_to) / std::max(at_point, 1e-9));
    }
    rise = glm::max(rise, glm::dvec2(0));
    glm::dvec2 hard(0, 1), outer(0, 1), inner(0, 1);
    std::vector<glm::dvec4> ramps;
    for (unsigned i = 0; i < prism.count; ++i) {
      const double across = i < outline ? radius * glm::length(glm::dvec2(prism.planes[i].normal)) : 0;
      const glm::dvec4 ramp(h(i, chord.t_from_m, chord.w_from), h(i, chord.t_to_m, chord.w_to), across * rise.x,
                            across * rise.y);
      k::shadow_cut_soft(ramp.x, ramp.y, ramp.z, ramp.w, hard, outer, inner);
      if (i < outline) ramps.push_back(ramp);
    }
    const double weight = k::lens_point_weight(points, p);
    if (inner.y > inner.x || points == 1) {
      if (hard.y > hard.x) k::shadow_weights_add(weights, weight, hard.x, hard.y);
    } else if (outer.y > outer.x) {
      glm::dvec3 shares(1);
      for (int s = 0; s < 3; ++s) {
        const double x = outer.x + 0.25 * (s + 1) * (outer.y - outer.x);
        for (const glm::dvec4& ramp : ramps) {
          shares[s] =
              std::min(shares[s], k::shadow_ramp(ramp.x + x * (ramp.y - ramp.x), ramp.z + x * (ramp.w - ramp.z)));
        }
      }
      const glm::dvec2 part = k::shadow_soft_part(hard, outer, shares);
      if (part.y > part.x) k::shadow_weights_add(weights, weight, part.x, part.y);
    }
  }
  k::shadow_weights_invert(weights);
  const k::Medium medium{haze.anisotropy, haze.scattering_per_m + haze.absorption_per_m};
  return k::chord_inscatter_shaded(beam, medium, chord, way, nodes, weights, true);
}

// The share of the part of the lens around a point that a body hides from a place on a surface.
double hidden_share(const ShadowCase& c, unsigned points, unsigned which, const glm::dvec3& place_m) {
  namespace k = render::f64;
  const auto turned = [&](const glm::dvec3& v) {
    return glm::dvec3(glm::dot(v, c.beam.x_axis), glm::dot(v, c.beam.y_axis), glm::dot(v, c.beam.axis));
  };
  k::ShadowSolid solid;
  solid.center = turned(c.solid.center_m - c.beam.lens_m);
  for (int i = 0; i < 3; ++i) solid.half_edge[i] = turned(c.solid.half_m[i]);
  const glm::dvec3 point = k::lens_point(points, which, c.beam.lens_radius_m);
  const glm::dvec3 p = turned(place_m - c.beam.lens_m);
  k::ShadowPrism prism;
  if (!k::shadow_prism_from(point, solid, prism)) return 0;
  double at = 0;
  const unsigned outline = prism.count - prism.fronts;
  for (unsigned i = outline; i < prism.count; ++i) {
    const double here = glm::dot(prism.planes[i].normal, p) - prism.planes[i].offset;
    if (here > -1e-4) return 0;
    at = std::max(at, k::shadow_front_at(glm::dot(prism.planes[i].normal, point) - prism.planes[i].offset, here));
  }
  double share = 1;
  for (unsigned i = 0; i < outline; ++i) {
    const glm::dvec3& normal = prism.planes[i].normal;
    const double outside_m = glm::dot(normal, p) - prism.planes[i].offset;
    share = std::min(share, k::shadow_edge_share(outside_m, glm::length(glm::dvec2(normal)),
                                                 k::lens_part_radius(points) * c.beam.lens_radius_m, at));
  }
  return share;
}

TEST_CASE("shadows from 4 points of a lens are nearer to those of its disc than hard ones, and from 7 points nearer") {
  const fixtures::Haze haze{0.02, 0.001, 0.4, 0};
  const std::vector<glm::dvec2> disc = judge_lens(400);
  for (const double half_m : {0.025, 0.1, 0.3, 1.0}) {
    Random random(23);
    double square = 0;
    double air[3] = {};
    double wall[3] = {};
    double flux[3] = {};
    double hidden = 0;
    int rays = 0;
    int places = 0;
    for (int i = 0; i < 300; ++i) {
      ShadowCase c = random_case(random, 0.05, 0.4, 2, 8);
      c.beam.lens_radius_m = random.uniform(0.04, 0.12);
      const double z = random.uniform(2, 8);
      const double w = c.beam.lens_radius_m + c.beam.spread * z;
      c.solid = random_box(random, c.beam.lens_m + z * c.beam.axis + 0.3 * w * random.uniform(-1, 1) * c.beam.x_axis);
      for (glm::dvec3& half : c.solid.half_m) half = half_m * glm::normalize(half);
      // A place behind the body, half a body or a lens beside its middle at most.
      const double behind = random.uniform(1.05, 3);
      const glm::dvec3 target = c.beam.lens_m + behind * (c.solid.center_m - c.beam.lens_m) +
                                1.5 * (half_m + c.beam.lens_radius_m) * behind *
                                    (random.uniform(-1, 1) * c.beam.x_axis + random.uniform(-1, 1) * c.beam.y_axis);
      c.ray.origin_m = target - 10.0 * c.ray.direction;
      const std::vector<JudgeSolid> solids{c.solid};
      const double lens = judge_inscatter(c.beam, haze, c.ray, 0, 1000, {}, 1e-6, solids, disc);
      const double lit = judge_lit(c.beam, disc, solids, target);
      if (lens > 0) ++rays;
      square += lens * lens;
      hidden += 1 - lit;
      const bool partly = lit > 0 && lit < 1;
      if (partly) ++places;
      for (int m = 0; m < 3; ++m) {
        const unsigned points = m == 0 ? 1 : m == 1 ? 4 : 7;
        const double off = soft_light(c, haze, points, 6) - lens;
        air[m] += off * off;
        double share = 0;
        for (unsigned p = 0; p < points && points > 1; ++p) {
          share += render::f64::lens_point_weight(points, p) * (1 - hidden_share(c, points, p, target));
        }
        if (points == 1) share = judge_lit(c.beam, {}, solids, target);
        if (partly) wall[m] += (share - lit) * (share - lit);
        flux[m] += 1 - share;
      }
    }
    std::fprintf(stderr, "half %.3f m, %d rays, relL2 in the air: hard %.3g, 4 points %.3g, 7 points %.3g;", half_m,
                 rays, std::sqrt(air[0] / square), std::sqrt(air[1] / square), std::sqrt(air[2] / square));
    std::fprintf(stderr, " rms in %d half shadows: %.3g, %.3g, %.3g; hidden %.3g, %.3g, %.3g\n", places,
                 std::sqrt(wall[0] / places), std::sqrt(wall[1] / places), std::sqrt(wall[2] / places),
                 flux[0] / hidden, flux[1] / hidden, flux[2] / hidden);
    CHECK(air[1] < air[0] / 4);
    CHECK(air[2] < air[1] * 1.7);  // squares
    CHECK(wall[1] < wall[0] / 5);
    CHECK(wall[2] < wall[1]);
    CHECK(flux[1] == doctest::Approx(hidden).epsilon(0.05));
    CHECK(flux[2] == doctest::Approx(hidden).epsilon(0.03));
  }
}

}  // namespace
