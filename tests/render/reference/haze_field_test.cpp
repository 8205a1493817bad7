// The density of haze that is not even, in double.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "render/haze.h"

namespace footlight::render {
namespace {

fixtures::Haze clouds(double noise, std::uint32_t seed) {
  fixtures::Haze haze;
  haze.noise = noise;
  haze.size_m = 2;
  haze.wind_m_s = {0.3, -0.2, 0.1};
  haze.seed = seed;
  return haze;
}

// Mean, and the least and the greatest value, over a cube of 200 m.
struct Spread {
  double mean = 0;
  double deviation = 0;
  double least = 1e9;
  double most = -1e9;
};
Spread spread_of(const f64::HazeField& field, double z_from) {
  Spread spread;
  constexpr int kSide = 60;
  double squares = 0;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      for (int z = 0; z < kSide; ++z) {
        const glm::dvec3 place = glm::dvec3(x, y, z) * 3.337 + glm::dvec3(-100, -100, z_from);
        const double density = f64::haze_density(field, place, 0.0);
        spread.mean += density;
        squares += density * density;
        spread.least = std::min(spread.least, density);
        spread.most = std::max(spread.most, density);
      }
    }
  }
  spread.mean /= kSide * kSide * kSide;
  spread.deviation = std::sqrt(squares / (kSide * kSide * kSide) - spread.mean * spread.mean);
  return spread;
}

TEST_CASE("the mean density of clouds is that of even haze, whatever their seed, and none is below 0") {
  for (const std::uint32_t seed : {0u, 1u, 4294967295u}) {
    const Spread spread = spread_of(haze_field(clouds(1, seed), 1'000'000'000), -100);
    CAPTURE(seed);
    CHECK(std::abs(spread.mean - 1) < 0.01);
    CHECK(spread.least >= 0);
    CHECK(spread.most <= 2);
    CHECK(spread.deviation == doctest::Approx(0.5).epsilon(0.05));
  }
  const Spread half = spread_of(haze_field(clouds(0.5, 1), 0), -100);
  CHECK(half.least >= 0.5);
  CHECK(half.most <= 1.5);
}

TEST_CASE("clouds have no edge, and another seed has other clouds") {
  const f64::HazeField field = haze_field(clouds(1, 1), 0);
  const f64::HazeField other = haze_field(clouds(1, 2), 0);
  double apart = 0;
  for (int i = 0; i < 20'000; ++i) {
    const glm::dvec3 place = glm::dvec3(0.37, 0.11, 0.05) * (0.01 * i);
    const double here = f64::haze_density(field, place, 0.0);
    const double near = f64::haze_density(field, place + glm::dvec3(1e-4, 0, 0), 0.0);
    CHECK(std::abs(here - near) < 2e-3);
    apart += std::abs(here - f64::haze_density(other, place, 0.0)) / 20'000;
  }
  CHECK(apart > 0.2);
}

TEST_CASE("wind moves clouds of one size without a change, also after a year") {
  fixtures::Haze haze = clouds(1, 3);
  f64::HazeField still = haze_field(haze, 0);
  // The largest ones alone.
  for (int i = 1; i < FL_HAZE_LAYERS; ++i) still.layers[i].weight = 0;
  for (const double seconds : {10.0, 31'536'000.0}) {
    f64::HazeField later = haze_field(haze, static_cast<std::int64_t>(seconds * 1e9));
    for (int i = 1; i < FL_HAZE_LAYERS; ++i) later.layers[i].weight = 0;
    const glm::dvec3 place(1.2, 3.4, 2.1);
    // 32 cubes on, the signs of a row repeat.
    const double moved = f64::haze_density(later, place + haze.wind_m_s * seconds, 0.0);
    CHECK(moved == doctest::Approx(f64::haze_density(still, place, 0.0)).epsilon(1e-6));
  }
}

TEST_CASE("haze in float is that in double") {
  const f64::HazeField field = haze_field(clouds(1, 3), 3'600'000'000'000);
  const f32::HazeField single = haze_field_in_float(field);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 place(0.013 * i - 13, 0.007 * i, 0.004 * i);
    CHECK(static_cast<double>(f32::haze_density(single, glm::vec3(place), 0.0f)) ==
          doctest::Approx(f64::haze_density(field, place, 0.0)).epsilon(1e-3));
  }
}

TEST_CASE("the noise of plumes has no jump in time, also where its shift begins again") {
  constexpr double kAgainS = 32 * f64::kPlumeCubeM / f64::kPlumeNoiseMS;
  const std::vector<fixtures::PlumePuff> puffs(1);
  const auto factor = [&](double seconds, const glm::dvec3& axis, const glm::dvec3& place) {
    const PlumeField field = plume_field(puffs, 0.01, std::llround(seconds * 1e9));
    const double exact = f64::haze_plume_factor(axis, 3, field.head.shift_m, place, 0);
    const float single =
        f32::haze_plume_factor(glm::vec3(axis), 3, plume_rows(field).head.shift_m, glm::vec3(place), 0.0f);
    CHECK(std::abs(static_cast<double>(single) - exact) < 1e-3);
    return exact;
  };
  double change = 0;
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 place(0.13 * i - 20, 0.07 * i - 9, 0.021 * i);
    const glm::dvec3 axis = glm::normalize(glm::dvec3(std::sin(i), std::cos(i), 0.02 * (i % 100)));
    for (const double at_s : {kAgainS, 100 * kAgainS, 0.3 * kAgainS}) {
      CHECK(std::abs(factor(at_s - 1e-3, axis, place) - factor(at_s + 1e-3, axis, place)) < 5e-3);
    }
    change += std::abs(factor(0, axis, place) - factor(0.5, axis, place)) / 300;
  }
  CHECK(change > 0.05);  // it moves
}

TEST_CASE("puffs beyond those that the GPU has room for are left out") {
  const PlumeField field = plume_field(std::vector<fixtures::PlumePuff>(FL_PUFFS_MAX + 3), 0.01, 0);
  CHECK(field.head.count == FL_PUFFS_MAX);
  CHECK(plume_rows(field).puffs.size() == FL_PUFFS_MAX);
}

TEST_CASE("at its height half of the haze is left, and at twice of it a seventeenth") {
  fixtures::Haze haze;
  haze.height_m = 5;
  const f64::HazeField field = haze_field(haze, 0);
  CHECK(f64::haze_density(field, {1, 2, -3}, 0.0) == 1);
  CHECK(f64::haze_density(field, {1, 2, 0}, 0.0) == 1);
  CHECK(f64::haze_density(field, {1, 2, 5}, 0.0) == doctest::Approx(0.5));
  CHECK(f64::haze_density(field, {1, 2, 10}, 0.0) == doctest::Approx(1.0 / 17));
}

}  // namespace
}  // namespace footlight::render
