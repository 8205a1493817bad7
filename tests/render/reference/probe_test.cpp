// Reflection probes without a GPU: the map, the box, the blend and the shares of render/shaders/shared/probe.h against
// what they stand for.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "render/probe.h"
#include "render/reference/probe_judge.h"
#include "render/sheen_rays.h"
#include "sim/core/random.h"

namespace footlight::render {
namespace {

using glm::dvec2;
using glm::dvec3;

const dvec3 kLow(-6, -4, 0), kHigh(6, 5, 4), kCenter(0.5, -0.5, 1.5);

bool prints_probes() { return std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr; }

dvec3 any_way(SeededNumbers& numbers) {
  const double z = 2 * numbers.uniform() - 1, turn = 2 * std::numbers::pi * numbers.uniform();
  return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}
dvec3 any_place(SeededNumbers& numbers) {
  return kLow + (kHigh - kLow) * dvec3(numbers.uniform(), numbers.uniform(), numbers.uniform());
}

// The nearest of six walls, each cut by itself.
dvec3 wall_behind(const dvec3& from, const dvec3& way) {
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {kLow[axis], kHigh[axis]}) {
      const double t = (side - from[axis]) / way[axis];
      if (t > 0) nearest = std::min(nearest, t);
    }
  }
  return from + nearest * way;
}

TEST_CASE("a probe shows a mirrored ray in a box room the wall that it ends at, and without the box another one") {
  SeededNumbers numbers(3);
  double worst = 0, worst_float = 0, uncorrected = 0;
  for (int i = 0; i < 2000; ++i) {
    const dvec3 from = any_place(numbers), way = any_way(numbers);
    const dvec3 expected = glm::normalize(wall_behind(from, way) - kCenter);
    const dvec3 toward = glm::normalize(f64::probe_toward(from, way, kLow, kHigh, kCenter));
    const glm::vec3 in_float = f32::probe_toward(glm::vec3(from), glm::vec3(way), glm::vec3(kLow), glm::vec3(kHigh),
                                                 glm::vec3(kCenter));
    worst = std::max(worst, glm::length(toward - expected));
    worst_float = std::max(worst_float, glm::length(dvec3(glm::normalize(in_float)) - expected));
    uncorrected = std::max(uncorrected, glm::length(way - expected));
  }
  CHECK(worst < 1e-9);
  CHECK(worst_float < 1e-4);
  CHECK(uncorrected > 1);
  // A lamp's eye over the floor: the mirrored ray meets the wall at y = 5, z = 2.5.
  const dvec3 to_eye = glm::normalize(dvec3(0, -2, 1));
  const dvec3 mirrored = 2 * to_eye.z * dvec3(0, 0, 1) - to_eye;
  for (uint k = 0; k < f64::kProbeFacets; ++k) {  // all facets of a smooth floor
    CHECK(glm::length(f64::probe_facet(k, 1e-9, {0, 0, 1}, to_eye).way - mirrored) < 1e-7);
  }
  CHECK(glm::length(mirrored - glm::normalize(dvec3(0, 2, 1))) < 1e-12);
  const dvec3 toward = f64::probe_toward({1, 0, 0}, mirrored, kLow, kHigh, kCenter);
  CHECK(glm::length(toward - (dvec3(1, 5, 2.5) - kCenter)) < 1e-12);
}

TEST_CASE("a probe counts whole in its box and loses no more at a step beside it than the step is of the blend") {
  constexpr double kBlendM = 0.8, kStepM = 0.01;
  CHECK(f64::probe_weight({-6, -4, 0}, kLow, kHigh, kBlendM) == 1);
  CHECK(f64::probe_weight({6, 5, 4}, kLow, kHigh, kBlendM) == 1);
  CHECK(f64::probe_weight({6.4, 0, 1}, kLow, kHigh, kBlendM) == doctest::Approx(0.5));
  CHECK(f64::probe_weight({0, 0, -0.8}, kLow, kHigh, kBlendM) == doctest::Approx(0));
  CHECK(f64::probe_weight({0, 20, 1}, kLow, kHigh, kBlendM) == 0);
  SeededNumbers numbers(5);
  for (int line = 0; line < 200; ++line) {
    const dvec3 way = any_way(numbers);
    dvec3 at = any_place(numbers) - 10.0 * way;
    // The second probe has what the first one leaves, as shaders have it.
    const auto weights = [&](const dvec3& place) {
      const double first = f64::probe_weight(place, kLow, kHigh, kBlendM);
      const double second = f64::probe_weight(place, {5.5, -4, 0}, {12, 5, 4}, 2 * kBlendM);
      return dvec2(first, std::min(second, 1 - first));
    };
    dvec2 before = weights(at);
    for (int step = 0; step < 2000; ++step) {
      at += kStepM * way;
      const dvec2 now = weights(at);
      REQUIRE(now.x >= 0);
      REQUIRE(now.x + now.y <= 1);
      REQUIRE(std::abs(now.x - before.x) <= kStepM / kBlendM + 1e-12);
      REQUIRE(std::abs(now.y - before.y) <= kStepM / kBlendM + 1e-12);
      before = now;
    }
  }
}

TEST_CASE("the map of a probe has each direction once, and goes on over its edges") {
  SeededNumbers numbers(7);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 way = any_way(numbers);
    REQUIRE(glm::length(glm::normalize(f64::probe_way(f64::probe_square(way))) - way) < 1e-12);
  }
  constexpr int kSide = 64;
  double solid_angle = 0;
  const auto way_of = [](int x, int y) { return f64::probe_way(dvec2(x + 0.5, y + 0.5) / double(kSide)); };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) solid_angle += f64::probe_texel_share(way_of(x, y)) * (4.0 / (kSide * kSide));
  }
  CHECK(solid_angle == doctest::Approx(4 * std::numbers::pi).epsilon(1e-3));
  double apart = 0;
  for (int i = 0; i < kSide; ++i) {
    const int beside[4][4] = {{-1, i, 0, i}, {kSide, i, kSide - 1, i}, {i, -1, i, 0}, {i, kSide, i, kSide - 1}};
    for (const auto& pair : beside) {
      const auto texel = static_cast<int>(f64::probe_texel(pair[0], pair[1], kSide));
      const dvec3 a = glm::normalize(way_of(texel % kSide, texel / kSide));
      apart = std::max(apart, glm::length(a - glm::normalize(way_of(pair[2], pair[3]))));
    }
  }
  CHECK(apart < 0.08);  // texels are 0.03 to 0.06 apart
  CHECK(f64::probe_first(FL_PROBE_LEVELS) == FL_PROBE_ALL);
  for (uint level = 1; level < 5; ++level) {
    CHECK(f64::probe_level(f64::probe_level_alpha(level)) == doctest::Approx(level).epsilon(1e-6));
  }
  CHECK(f64::probe_level(0.01) == 0);
}

// A level takes light by its weights as rays from a facet do that is seen straight from above.
TEST_CASE("a surface that is as rough as a level of a probe reads that level alone, also the last one") {
  for (uint level = 1; level <= 5; ++level) {
    CHECK(f64::probe_level(f64::probe_level_alpha(level)) == doctest::Approx(level).epsilon(1e-6));
  }
  CHECK(f64::probe_level(0.8) == doctest::Approx(4.5).epsilon(1e-6));  // half of the way in the logarithm
}

TEST_CASE("a level of a probe takes the light that a surface of its roughness mirrors, seen from above") {
  const dvec3 normal = glm::normalize(dvec3(0.3, -0.5, 0.6));
  const auto light = [](const dvec3& way) { return 1 + way.x + 2 * way.y * way.y + std::exp(3 * way.z); };
  for (uint level = 1; level < FL_PROBE_LEVELS; ++level) {
    const double alpha = f64::probe_level_alpha(level);
    double sum = 0, weights = 0;
    for (int i = 0; i < FL_PROBE_TEXELS; ++i) {
      const dvec3 way = f64::probe_way(dvec2(i % 64 + 0.5, i / 64 + 0.5) / 64.0);
      const double weight =
          f64::probe_lobe(alpha, glm::dot(glm::normalize(way), normal)) * f64::probe_texel_share(way);
      sum += weight * light(glm::normalize(way));
      weights += weight;
    }
    const fixtures::Sheen sheen{std::sqrt(alpha), 1};
    const auto mirrored = [&](const LightFrom& from) {
      return judge_mirrored(sheen, dvec3(1), normal, -normal, 4096, from).x;
    };
    const double expected =
        mirrored([&](const dvec3& way) { return dvec3(light(way)); }) / mirrored([](const dvec3&) { return dvec3(1); });
    if (prints_probes()) std::fprintf(stderr, "level %u: %.4f of %.4f\n", level, sum / weights, expected);
    CHECK(sum / weights == doctest::Approx(expected).epsilon(0.03));
  }
}

TEST_CASE("a surface in even light mirrors what the sheen reflects of it, by the table within 0.02 of all light") {
  const std::vector<vec4> table = probe_share_table();
  REQUIRE(table.size() == FL_PROBE_SHARES * FL_PROBE_SHARES);
  double of_samples = 0, of_table = 0;
  for (const double roughness : {0.1, 0.2, 0.35, 0.5, 0.8, 1.0}) {
    for (const double cosine : {0.05, 0.2, 0.35, 0.5, 0.8, 0.98}) {
      const dvec3 to_eye(std::sqrt(1 - cosine * cosine), 0, cosine);
      const double alpha = roughness * roughness;
      for (const double straight : {0.04, 1.0}) {
        // The lobe itself, by a midpoint rule over facets: the lobe is narrow around them. Four times their cosine is
        // what a solid angle of facets becomes.
        constexpr int kAcross = 600, kAround = 240;
        double whole = 0;
        for (int i = 0; i < kAcross; ++i) {
          // Slopes alpha u / sqrt(1 - u^2), so that equal steps of u have similar shares.
          const double u = (i + 0.5) / kAcross, slope = alpha * u / std::sqrt(1 - u * u);
          const double z = 1 / std::sqrt(1 + slope * slope), across = slope * z;
          const double slope_step = alpha / std::pow(1 - u * u, 1.5) / kAcross;
          for (int j = 0; j < kAround; ++j) {
            const double turn = 2 * std::numbers::pi * (j + 0.5) / kAround;
            const dvec3 facet(across * std::cos(turn), across * std::sin(turn), z);
            const double along = glm::dot(to_eye, facet);
            const dvec3 to_light = 2 * along * facet - to_eye;
            if (!(along > 0) || !(to_light.z > 0)) continue;
            const double gloss =
                f64::sheen_gloss(dvec3(straight), alpha, 0, {0, 0, 1}, to_eye, to_light).x * to_light.z;
            whole += gloss * 4 * along * across * z * z * slope_step * (2 * std::numbers::pi / kAround);
          }
        }
        const dvec2 sampled = sheen_shares(alpha, cosine, 4096), looked_up = table_shares(table, alpha, cosine);
        of_samples = std::max(of_samples, std::abs(straight * sampled.x + sampled.y - whole));
        of_table = std::max(of_table, std::abs(straight * looked_up.x + looked_up.y - whole));
      }
    }
  }
  if (prints_probes()) {
    std::fprintf(stderr, "shares: by samples within %.2g, by table within %.2g\n", of_samples, of_table);
  }
  CHECK(of_samples < 0.01);
  CHECK(of_table < 0.02);
}

}  // namespace
}  // namespace footlight::render
