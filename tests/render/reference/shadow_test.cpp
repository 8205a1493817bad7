// The shadows of render/shaders/shared/shadow.h, in float and in double, compared with the judge's traced paths.
#include <algorithm>
#include <cmath>
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

#define FL_TEST_SHADOW(name, space)                                                                             \
  Shadow name(const ShadowCase& c) {                                                                            \
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
    if (!k::shadow_prism(beam.lens_radius_m, beam.spread, solid, prism)) return shadow;                         \
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

}  // namespace
