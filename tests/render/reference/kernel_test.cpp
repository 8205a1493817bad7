// The light formulas of render/shaders/shared/beam.h, in float and in double, compared with the judge on random rays of
// every extreme case. FOOTLIGHT_PRINT_ERRORS=1 prints the measured errors that docs/numerics.md quotes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "render/reference/judge.h"
#include "sim/shared/shared.h"
#include "tests/render/reference/kernel_bounds.h"
#include "tests/render/reference/kernel_cases.h"

// A gobo of soft bars across x, for both precisions.
#define FL_TEST_BARS                                                        \
  inline Vec3 gobo_at(uint gobo, Vec2 rho, Real z_m) {                      \
    (void)gobo;                                                             \
    (void)z_m;                                                              \
    return Vec3(Real(0.5) + Real(0.5) * sin(Real(20) * rho.x + Real(0.3))); \
  }
namespace footlight::render::f32 {
using namespace ::footlight::f32;
FL_TEST_BARS
}  // namespace footlight::render::f32
namespace footlight::render::f64 {
using namespace ::footlight::f64;
FL_TEST_BARS
}  // namespace footlight::render::f64
#define FL_GOBO
#include "render/beam.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using cases::BeamRay;
using cases::Bound;
using cases::kBounds;
using cases::kFluxBound;
using cases::kFluxStageBound;
using cases::Random;

constexpr int kRays = 3000;
constexpr double kGoboCos = 0.8;
constexpr double kGoboSin = 0.6;

bool prints() { return std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr; }

enum class Rule { kGauss, kWide, kMarch, kGobo, kTaps };

// One kernel of one precision on one ray.
#define FL_TEST_KERNEL(name, space)                                                                             \
  double name(const BeamRay& ray, Rule rule, unsigned n) {                                                      \
    namespace k = render::space;                                                                                \
    const k::BeamShape beam{ray.lens_radius_m, ray.spread, ray.range_m, ray.profile_power};                     \
    const k::Medium medium{ray.anisotropy, ray.extinction_per_m};                                               \
    const k::Vec3 d(ray.direction);                                                                             \
    k::Chord chord;                                                                                             \
    if (!k::beam_chord(beam, k::Vec3(ray.origin_m), d, k::Real(0), k::Real(ray.t_max_m), chord)) return 0;      \
    switch (rule) {                                                                                             \
      case Rule::kGauss: return static_cast<double>(k::chord_inscatter_gauss(beam, medium, chord, d, n, true)); \
      case Rule::kWide: return static_cast<double>(k::chord_inscatter_wide(beam, medium, chord, d, n, true));   \
      case Rule::kMarch: return static_cast<double>(k::chord_inscatter_march(beam, medium, chord, d, n, true)); \
      case Rule::kGobo: break;                                                                                  \
      case Rule::kTaps: {                                                                                       \
        const k::ChordWeight weight = k::chord_weight(beam, medium, chord, d, true);                            \
        const k::Vec2 turn(kGoboCos, kGoboSin);                                                                 \
        return static_cast<double>(k::chord_inscatter_taps(beam, chord, weight, d, n, 1u, turn).x);             \
      }                                                                                                         \
    }                                                                                                           \
    return static_cast<double>(                                                                                 \
        k::chord_inscatter_gobo(beam, medium, chord, d, n, true, 1u, k::Vec2(kGoboCos, kGoboSin)).x);           \
  }
FL_TEST_KERNEL(in_float, f32)
FL_TEST_KERNEL(in_double, f64)

JudgeBeam judge_beam_of(const BeamRay& ray) {
  JudgeBeam beam;
  beam.lens_radius_m = static_cast<double>(ray.lens_radius_m);
  beam.spread = static_cast<double>(ray.spread);
  beam.profile_power = static_cast<double>(ray.profile_power);
  beam.range_m = static_cast<double>(ray.range_m);
  beam.wheels[0] = {1, 0, 0, kGoboCos, kGoboSin};
  return beam;
}

double judged(const BeamRay& ray, const GoboTransmission& gobo, double tolerance) {
  fixtures::Haze haze;
  haze.scattering_per_m = static_cast<double>(ray.extinction_per_m);
  haze.absorption_per_m = 0;
  haze.anisotropy = static_cast<double>(ray.anisotropy);
  return judge_inscatter(judge_beam_of(ray), haze, {glm::dvec3(ray.origin_m), glm::dvec3(ray.direction)}, 0,
                         static_cast<double>(ray.t_max_m), gobo, tolerance);
}

struct Judged {
  std::vector<BeamRay> rays;
  std::vector<double> value;
  double mean = 0;
  double own_rel_l2 = 0;
};

const Judged& judged_case(const std::string& name, double profile_power, bool with_gobo = false) {
  static std::map<std::string, Judged> cache;
  Judged& c = cache[fmt::format("{} {} {}", name, profile_power, with_gobo)];
  if (!c.rays.empty()) return c;
  GoboTransmission gobo;
  if (with_gobo)
    gobo = [](int index, double x, double y) {
      return render::f64::gobo_at(static_cast<unsigned>(index), {x, y}, 0).x;
    };
  c.rays = cases::rays_of(name, kRays, profile_power);
  double square = 0;
  double own_square = 0;
  for (const BeamRay& ray : c.rays) {
    const double fine = judged(ray, gobo, 1e-9);
    const double rough = judged(ray, gobo, 1e-7);
    c.value.push_back(fine);
    c.mean += fine / kRays;
    square += fine * fine;
    own_square += (fine - rough) * (fine - rough);
  }
  c.own_rel_l2 = std::sqrt(own_square / square);
  return c;
}

struct Distance {
  double rel_l2 = 0;
  double max = 0;  // over value + 1e-2 mean
  int nonfinite = 0;
};

template <class F>
Distance error_of(const Judged& c, const F& kernel) {
  Distance error;
  double square = 0;
  double difference = 0;
  for (std::size_t i = 0; i < c.rays.size(); ++i) {
    const double value = kernel(c.rays[i]);
    if (!std::isfinite(value)) {
      ++error.nonfinite;
      continue;
    }
    const double d = value - c.value[i];
    difference += d * d;
    square += c.value[i] * c.value[i];
    error.max = std::max(error.max, std::abs(d) / (c.value[i] + 1e-2 * c.mean));
  }
  error.rel_l2 = std::sqrt(difference / square);
  return error;
}

constexpr std::array<unsigned, 5> kNodes{2, 3, 4, 5, 8};

}  // namespace

TEST_CASE("Gauss nodes stay within the stated error in every extreme case and return only finite values") {
  if (prints()) fmt::print("case | m | judge's own | f32 - f64 | n: f64 relL2, f32 relL2 (f32 max)\n");
  REQUIRE(std::size(kBounds) == cases::names().size());
  for (std::size_t i = 0; i < cases::names().size(); ++i) {
    const std::string& name = cases::names()[i];
    const Bound& bound = kBounds[i];
    REQUIRE(name == bound.name);
    for (const double m : {1.0, 4.0}) {
      const Judged& c = judged_case(name, m);
      CAPTURE(name);
      CAPTURE(m);
      CHECK(c.own_rel_l2 < 1e-11);
      const auto lit = std::count_if(c.value.begin(), c.value.end(), [](double v) { return v > 0; });
      CHECK(lit > kRays / 2);
      Judged reference = c;  // the kernel in double, to measure the error of float alone
      for (std::size_t k = 0; k < c.rays.size(); ++k) reference.value[k] = in_double(c.rays[k], Rule::kGauss, 8);
      const Distance rounding = error_of(reference, [](const BeamRay& r) { return in_float(r, Rule::kGauss, 8); });
      CHECK(rounding.rel_l2 < bound.rounding);
      if (prints()) fmt::print("{} | {} | {:.0e} | {:.1e} |", name, m, c.own_rel_l2, rounding.rel_l2);
      for (std::size_t j = 0; j < kNodes.size(); ++j) {
        const unsigned n = kNodes[j];
        CAPTURE(n);
        const Distance wide = error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kGauss, n); });
        const Distance real = error_of(c, [n](const BeamRay& r) { return in_float(r, Rule::kGauss, n); });
        const double allowed = (m < 2 ? bound.smooth : bound.flat)[j];
        CHECK(wide.rel_l2 <= allowed);
        CHECK(real.rel_l2 <= allowed + bound.rounding);
        CHECK(wide.nonfinite == 0);
        CHECK(real.nonfinite == 0);
        if (prints()) fmt::print(" {}: {:.1e} {:.1e} ({:.1e})", n, wide.rel_l2, real.rel_l2, real.max);
      }
      if (prints()) fmt::print("\n");
    }
  }
}

TEST_CASE("five Gauss nodes draw the soft profiles within their stated error") {
  if (prints()) fmt::print("case | m | f64 relL2 of 3, 4, 5 nodes, f32 of 5\n");
  for (std::size_t i = 0; i < cases::names().size(); ++i) {
    const std::string& name = cases::names()[i];
    CAPTURE(name);
    for (const double m : {0.5, 1.0 / 3, 0.25}) {
      CAPTURE(m);
      const Judged& c = judged_case(name, m);
      const auto wide = [&](unsigned n) {
        return error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kGauss, n); }).rel_l2;
      };
      const Distance real = error_of(c, [](const BeamRay& r) { return in_float(r, Rule::kGauss, 5); });
      if (prints())
        fmt::print("{} | {:.2f} | {:.1e} {:.1e} {:.1e}, {:.1e}\n", name, m, wide(3), wide(4), wide(5), real.rel_l2);
      CHECK(wide(5) <= kBounds[i].soft);
      CHECK(real.nonfinite == 0);
      CHECK(real.rel_l2 <= kBounds[i].soft + kBounds[i].rounding);
    }
  }
}

TEST_CASE("four Gauss nodes are closer to the judge than a march of 64 steps in every extreme case") {
  for (const std::string& name : cases::names()) {
    CAPTURE(name);
    const Judged& c = judged_case(name, 1);
    const Distance gauss = error_of(c, [](const BeamRay& r) { return in_float(r, Rule::kGauss, 4); });
    Distance march;
    if (prints()) fmt::print("{}: gauss 4 {:.1e};", name, gauss.rel_l2);
    for (const unsigned n : {16u, 256u, 64u}) {
      march = error_of(c, [n](const BeamRay& r) { return in_float(r, Rule::kMarch, n); });
      CHECK(march.nonfinite == 0);
      if (prints()) fmt::print(" march {} {:.1e}", n, march.rel_l2);
    }
    if (prints()) fmt::print("\n");
    // For a laser the integrand is so smooth that the march, too, has only rounding error.
    CHECK(gauss.rel_l2 <= 1.1 * march.rel_l2 + 1e-6);
  }
}

TEST_CASE("the march converges to the judge with order two") {
  const Judged& c = judged_case("cut by depth", 1);
  const auto march = [&](unsigned n) {
    return error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kMarch, n); }).rel_l2;
  };
  const double order = std::log2(march(512) / march(2048)) / 2;
  CAPTURE(order);
  CHECK(order > 1.8);
  CHECK(order < 2.2);
}

TEST_CASE("gobo samples along the chord converge to the judge's gobo") {
  for (const char* name : {"generic", "inside the beam", "cut by depth", "camera at the lens", "into the lens"}) {
    CAPTURE(name);
    const Judged& c = judged_case(name, 1, true);
    CHECK(c.own_rel_l2 < 1e-7);
    std::array<double, 3> rel_l2{};
    std::size_t i = 0;
    for (const unsigned n : {16u, 64u, 256u}) {
      const Distance wide = error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kGobo, n); });
      const Distance real = error_of(c, [n](const BeamRay& r) { return in_float(r, Rule::kGobo, n); });
      CHECK(real.nonfinite == 0);
      CHECK(std::abs(real.rel_l2 - wide.rel_l2) < 1e-5);
      if (prints()) fmt::print("gobo, {}, {} samples: {:.1e}\n", name, n, real.rel_l2);
      rel_l2[i++] = wide.rel_l2;
    }
    // 20 rad of pattern across the disc and a smooth beam: order two once the samples resolve the pattern.
    CHECK(rel_l2[0] < 3e-2);
    CHECK(rel_l2[1] < 1.3e-3);
    CHECK(rel_l2[2] < 1.5e-4);
  }
}

TEST_CASE("a gobo's samples with the smooth part at four nodes are as close as samples of the whole") {
  for (const char* name : {"generic", "inside the beam", "cut by depth", "into the lens"}) {
    CAPTURE(name);
    const Judged& c = judged_case(name, 1, true);
    for (const unsigned n : {16u, 64u, 256u}) {
      CAPTURE(n);
      const Distance whole = error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kGobo, n); });
      const Distance split = error_of(c, [n](const BeamRay& r) { return in_double(r, Rule::kTaps, n); });
      const Distance real = error_of(c, [n](const BeamRay& r) { return in_float(r, Rule::kTaps, n); });
      if (prints())
        fmt::print("gobo, {}, {} samples: {:.1e} whole, {:.1e} split\n", name, n, whole.rel_l2, split.rel_l2);
      CHECK(real.nonfinite == 0);
      CHECK(std::abs(real.rel_l2 - split.rel_l2) < 1e-5);
      CHECK(split.rel_l2 < 1.1 * whole.rel_l2 + 1e-3);  // what four nodes leave
    }
  }
}

TEST_CASE("a ray with NaN is dark") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<BeamRay> rays = cases::rays_of("generic", 50, 1);
  for (const BeamRay& good : rays) {
    for (int i = 0; i < 7; ++i) {
      BeamRay bad = good;
      if (i < 3) bad.origin_m[i] = nan;
      if (i >= 3 && i < 6) bad.direction[i - 3] = nan;
      if (i == 6) bad.t_max_m = nan;
      CAPTURE(i);
      CHECK(in_float(bad, Rule::kGauss, 4) == 0);
      CHECK(in_double(bad, Rule::kGauss, 4) == 0);
      CHECK(judged(bad, {}, 1e-7) == 0);
    }
  }
}

TEST_CASE("illuminance of the kernels equals the judge's at random points, and is dark in the same places") {
  Random random(11);
  int lit = 0;
  double worst_wide = 0;
  double worst_real = 0;
  for (int i = 0; i < 20'000; ++i) {
    JudgeBeam beam;
    beam.lens_radius_m = static_cast<double>(static_cast<float>(random.uniform(0.01, 0.1)));
    beam.spread = static_cast<double>(static_cast<float>(std::tan(random.uniform(0, 1.3))));
    beam.profile_power = 1 + i % 4;
    beam.range_m = 30;
    const double z = random.uniform(-2, 32);
    const double w = beam.lens_radius_m + beam.spread * z;
    const glm::vec3 p(glm::dvec3(random.uniform(-1, 1) * w, random.uniform(-1, 1) * w, z));
    const double judge = judge_illuminance(beam, {0, 0, 0}, glm::dvec3(p), {0, 0, -1}, {});
    const auto of_kernel = [&]<class Shape, class Vec3, class Vec2>(Shape shape, Vec3 point, Vec2 rho, auto illuminance,
                                                                    auto direction) {
      auto r_m = point.x;
      const auto value = illuminance(shape, point, rho, r_m);
      // The judge's surface is perpendicular to the axis, so its cosine is the direction's z.
      return value > 0 ? static_cast<double>(value * direction(shape, rho).z) : 0.0;
    };
    const double wide =
        of_kernel(render::f64::BeamShape{beam.lens_radius_m, beam.spread, 30, beam.profile_power}, glm::dvec3(p),
                  glm::dvec2(0), render::f64::beam_illuminance, render::f64::beam_direction);
    const double real =
        of_kernel(render::f32::BeamShape{static_cast<float>(beam.lens_radius_m), static_cast<float>(beam.spread), 30.0f,
                                         static_cast<float>(beam.profile_power)},
                  p, glm::vec2(0), render::f32::beam_illuminance, render::f32::beam_direction);
    if (judge > 0) ++lit;
    // Relative to the light at the beam's centre, because it falls to 0 at the edge.
    const double scale = w > 0 ? 1 / (w * w) : 1;
    worst_wide = std::max(worst_wide, std::abs(wide - judge) / scale);
    worst_real = std::max(worst_real, std::abs(real - judge) / scale);
  }
  CHECK(lit > 5000);
  CHECK(worst_wide < 1e-14);
  CHECK(worst_real < 5e-6);
  if (prints()) fmt::print("illuminance over its middle: f64 {:.1e} f32 {:.1e}\n", worst_wide, worst_real);
}

TEST_CASE("floods of 60 to 175 degrees have light in the air and lumens within the stated errors") {
  static_assert(render::f64::kWideSpread == static_cast<double>(fixtures::kWideSpread));
  struct Flood {
    double full_deg;
    double air_max;  // relL2 with the nodes that a picture uses at the setting 3: 3, or 8 in wide beams
  };
  if (prints()) fmt::print("full angle | m | relL2 in the air | with twice the nodes | float | lumens\n");
  for (const Flood& flood : {Flood{60, 5e-2},
                             {80, 6e-2},
                             {100, 2e-4},
                             {120, 2e-4},
                             {140, 3e-4},
                             {150, 4e-4},
                             {160, 7e-4},
                             {170, 5e-4},
                             {175, 5e-4}}) {
    for (const double m : {0.25, 1.0, 4.0}) {
      CAPTURE(flood.full_deg);
      CAPTURE(m);
      const double spread = std::tan(glm::radians(flood.full_deg / 2));
      const bool wide = spread > static_cast<double>(render::f64::kWideSpread);
      Random random(31);
      double square = 0;
      double difference = 0;
      double difference_twice = 0;
      double difference_real = 0;
      // Rays of a camera in the light, towards a point 2 to 20 m away and up to 20 m beside the axis.
      for (int i = 0; i < 600; ++i) {
        BeamRay ray{};
        ray.lens_radius_m = static_cast<float>(random.uniform(0.03, 0.1));
        ray.spread = static_cast<float>(spread);
        ray.range_m = 60;
        ray.profile_power = static_cast<float>(m);
        ray.anisotropy = static_cast<float>(random.uniform(0, 0.8));
        ray.extinction_per_m = static_cast<float>(random.uniform(0.005, 0.03));
        const double z = random.uniform(0.1, 8);
        const double away_m = std::min(1.05 * spread * z, 20.0) * std::sqrt(random.uniform(0, 1));
        const double phi = random.uniform(0, 6.283185307179586);
        const glm::dvec3 d = random.direction();
        const glm::dvec3 target(away_m * std::cos(phi), away_m * std::sin(phi), z);
        ray.origin_m = glm::vec3(target - random.uniform(2, 20) * d);
        ray.direction = glm::vec3(d);
        ray.t_max_m = static_cast<float>(random.uniform(0, 1) < 0.5 ? 200.0 : random.uniform(5, 40));
        const double exact = judged(ray, {}, 1e-9);
        const auto rule = [&](unsigned times) {
          return in_double(ray, wide ? Rule::kWide : Rule::kGauss, wide ? times : 3 * times);
        };
        square += exact * exact;
        difference += std::pow(rule(1) - exact, 2);
        difference_twice += std::pow(rule(2) - exact, 2);
        difference_real += std::pow(in_float(ray, wide ? Rule::kWide : Rule::kGauss, wide ? 1 : 3) - exact, 2);
      }
      const double air = std::sqrt(difference / square);
      // Lumens: J0 / k^2 f over the directions, by the midpoint rule in the angle.
      double factor = 0;
      constexpr int kSteps = 100'000;
      for (int i = 0; i < kSteps; ++i) {
        const double angle = glm::radians(flood.full_deg / 2) * (i + 0.5) / kSteps;
        const double rho = std::tan(angle) / spread;
        const double f = m < 1 ? std::pow(1 - rho * rho, 1 / m) : 1 - std::pow(rho, 2 * m);
        factor += f * std::sin(angle);
      }
      factor *= 2 * 3.141592653589793 * glm::radians(flood.full_deg / 2) / kSteps / (spread * spread);
      const render::f32::BeamShape shape{0.05f, static_cast<float>(spread), 60, static_cast<float>(m)};
      const double lumens = std::abs(static_cast<double>(render::f32::beam_flux_factor(shape)) / factor - 1);
      if (prints()) {
        fmt::print("{} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e}\n", flood.full_deg, m, air,
                   std::sqrt(difference_twice / square), std::sqrt(difference_real / square), lumens);
      }
      CHECK(air < flood.air_max);
      CHECK(std::sqrt(difference_real / square) < flood.air_max);
      CHECK(lumens < 2e-6);
    }
  }
}

TEST_CASE("the flux factor of eight nodes is within its stated error up to 87.5 degrees") {
  double worst = 0;
  double worst_stage = 0;  // up to 30 degrees
  for (const double m : {0.25, 1.0 / 3, 0.5, 1.0, 2.0, 3.0, 4.0}) {
    for (double degrees = 0; degrees <= 87.5; degrees += 0.5) {
      const double k = std::tan(glm::radians(degrees));
      const render::f64::BeamShape wide{0.05, k, 30, m};
      const render::f32::BeamShape real{0.05f, static_cast<float>(k), 30, static_cast<float>(m)};
      const double error = std::abs(render::f64::beam_flux_factor(wide) / judge_flux_factor(k, m) - 1);
      worst = std::max(worst, error);
      if (degrees <= 30) worst_stage = std::max(worst_stage, error);
      const auto real_factor = static_cast<double>(render::f32::beam_flux_factor(real));
      CHECK(std::abs(real_factor / render::f64::beam_flux_factor(wide) - 1) < 1e-6);
    }
  }
  if (prints()) fmt::print("flux factor: {:.1e} up to 87.5 degrees, {:.1e} up to 30\n", worst, worst_stage);
  CHECK(worst < kFluxBound);
  CHECK(worst_stage < kFluxStageBound);
}

TEST_CASE("a tile that beam_miss rejects has no ray that crosses the beam") {
  Random random(5);
  int rejected = 0;
  int dark_tiles = 0;
  int wrong = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double radius = random.uniform(0.001, 0.1);
    const double spread = i % 5 == 0 ? 0.0 : std::tan(random.uniform(0.001, 1.3));
    // Cameras around the lens, in the beam, behind it, far away.
    const double distance = std::exp(random.uniform(std::log(0.01), std::log(100)));
    const glm::dvec3 o = distance * random.direction();
    const glm::dvec3 target(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(0, 20));
    const glm::dvec3 forward = glm::normalize(target - o);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, random.direction()));
    const glm::dvec3 up = glm::cross(right, forward);
    const double size = std::exp(random.uniform(std::log(1e-3), std::log(0.5)));

    const auto direction = [&](double x, double y) { return forward + size * (x * right + y * up); };
    bool miss_left = true;
    bool miss_right = true;
    const render::f32::BeamShape shape{static_cast<float>(radius), static_cast<float>(spread), 60, 1};
    for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(-1, 1), std::pair(1, 1)}) {
      const glm::vec3 d(direction(x, y));
      miss_left = miss_left && render::f32::beam_miss(shape, glm::vec3(o), d, 1.0f) > 0;
      miss_right = miss_right && render::f32::beam_miss(shape, glm::vec3(o), d, -1.0f) > 0;
    }
    JudgeBeam beam;
    beam.lens_radius_m = radius;
    beam.spread = spread;
    beam.range_m = 60;
    bool lit = false;
    for (int r = 0; r < 40 && !lit; ++r) {
      const Ray ray{o, glm::normalize(direction(random.uniform(-1, 1), random.uniform(-1, 1)))};
      // Only light above rounding at the beam's edge counts: more than 1e-4 of a full crossing.
      const double value = judge_inscatter(beam, {0, 0, 0}, ray, 0, 200, {}, 1e-4);
      lit = value > 0;
      if (lit && (miss_left || miss_right)) ++wrong;
    }
    if (!lit) ++dark_tiles;
    if (miss_left || miss_right) ++rejected;
  }
  if (prints()) fmt::print("beam_miss: {} of {} dark tiles rejected, {} wrong\n", rejected, dark_tiles, wrong);
  CHECK(wrong == 0);
  CHECK(rejected > dark_tiles / 2);
}
