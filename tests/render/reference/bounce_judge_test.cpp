// The judge of reflected light: what closed forms give.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <doctest/doctest.h>

#include "render/reference/bounce_judge.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using glm::dvec3;

// The inside of a box of 4 x 3 x 2 m, as six walls.
std::vector<fixtures::StageBox> room(double albedo) {
  const dvec3 size(4, 3, 2);
  std::vector<fixtures::StageBox> walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      dvec3 low(-0.5), high = size + 0.5;
      low[axis] = far ? size[axis] : -0.5;
      high[axis] = far ? size[axis] + 0.5 : 0;
      walls.push_back({"wall", low, high, dvec3(albedo)});
    }
  }
  return walls;
}

TEST_CASE("in a closed room whose walls emit, traced light adds up to emission over absorption") {
  PathScene scene{room(0.5), std::vector<dvec3>(6, dvec3(10, 20, 5)), {}};
  PathOptions options;
  options.bounces = 30;
  for (const auto& [point, normal] : {std::pair{dvec3(2, 1.5, 0), dvec3(0, 0, 1)}, {{0, 0.01, 1}, {1, 0, 0}}}) {
    const dvec3 lx = judge_bounced(scene, point, normal, options);
    for (int c = 0; c < 3; ++c) CHECK(lx[c] == doctest::Approx(2 * scene.emitted[0][c]).epsilon(0.005));
  }
  // Nothing is absorbed: each surface on a path adds its emission, and no path leaves the room.
  scene.boxes = room(1);
  options.bounces = 40;
  CHECK(judge_bounced(scene, {1, 1, 2}, {0, 0, -1}, options).x == doctest::Approx(40 * 10).epsilon(0.005));
}

// Mean over the receiver's points, of an emitter with 1 lm/m^2: the form factor.
double form_factor(const fixtures::StageBox& emitter, const dvec3& corner, const dvec3& u, const dvec3& v,
                   const dvec3& normal) {
  const PathScene scene{{emitter}, {dvec3(1)}, {}};
  constexpr int kPoints = 16;
  double sum = 0;
  for (int i = 0; i < kPoints * kPoints; ++i) {
    const dvec3 point = corner + (i % kPoints + 0.5) / kPoints * u + (i / kPoints + 0.5) / kPoints * v;
    PathOptions options;
    options.seed = static_cast<std::uint64_t>(i + 1);
    options.side = 24;
    sum += judge_bounced(scene, point, normal, options).x;
  }
  return sum / (kPoints * kPoints);
}

TEST_CASE("traced light between two squares is that of their form factor") {
  const fixtures::StageBox emitter{"emitter", {0, 0, -0.1}, {1, 1, 0}, dvec3(0)};
  // Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", C-11 with X = Y = 1: opposite squares.
  const double opposite =
      2 / std::numbers::pi *
      (0.5 * std::log(4.0 / 3) + 2 * std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) - 2 * std::atan(1.0));
  CHECK(opposite == doctest::Approx(0.199825).epsilon(1e-5));
  const double above = form_factor(emitter, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1});
  // C-14 with H = W = 1: squares at right angles with an edge in common.
  const double corner = 1 / std::numbers::pi *
                        (2 * std::atan(1.0) - std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) +
                         0.25 * std::log(4.0 / 3 * std::pow(3.0 / 4, 1) * std::pow(3.0 / 4, 1)));
  CHECK(corner == doctest::Approx(0.200044).epsilon(1e-5));
  const double beside = form_factor(emitter, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0});
  std::fprintf(stderr, "form factors: opposite %.6f (%.6f), at a corner %.6f (%.6f)\n", above, opposite, beside,
               corner);
  CHECK(above == doctest::Approx(opposite).epsilon(0.005));
  CHECK(beside == doctest::Approx(corner).epsilon(0.005));
}

TEST_CASE("a lamp's light is reflected once by the albedo of what it lights, and shadows hold") {
  // A floor with one lit square metre, seen from a point 2 m above its middle.
  PathScene scene{{{"floor", {-9, -9, -1}, {9, 9, 0}, dvec3(0.5, 0.25, 0)}}, {}, {}};
  scene.direct_lx = [](const dvec3& point, const dvec3&) {
    return std::abs(point.x) < 0.5 && std::abs(point.y) < 0.5 && std::abs(point.z) < 0.1 ? dvec3(1000) : dvec3(0);
  };
  PathOptions options;
  options.side = 256;
  // Of a point to a square: four corners of 0.5 x 0.5 m at 2 m (Howell, B-4).
  const double a = 0.25;
  const double factor = 4 / (2 * std::numbers::pi) * 2 * a / std::sqrt(1 + a * a) * std::atan(a / std::sqrt(1 + a * a));
  const dvec3 lx = judge_bounced(scene, {0, 0, 2}, {0, 0, -1}, options);
  CHECK(lx.x == doctest::Approx(500 * factor).epsilon(0.02));
  CHECK(lx.y == doctest::Approx(0.5 * lx.x).epsilon(1e-12));
  CHECK(lx.z == 0);
  options.bounces = 1;  // a second reflection would come from below the lid
  scene.boxes.push_back({"lid", {-1, -1, 0.5}, {1, 1, 0.6}, dvec3(0.9)});
  CHECK(judge_bounced(scene, {0, 0, 2}, {0, 0, -1}, options).x == 0);
}

}  // namespace
