// The judge compared with closed forms, brute force and conservation laws.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "render/reference/judge.h"
#include "tests/render/reference/kernel_cases.h"

namespace {

using namespace footlight;
using namespace footlight::render;
using cases::Random;

constexpr double kPi = std::numbers::pi;
const fixtures::Haze kClear{0, 0, 0};

// A random beam with orthonormal axes.
JudgeBeam posed_beam(Random& random) {
  JudgeBeam beam;
  beam.axis = random.direction();
  beam.x_axis = glm::normalize(glm::cross(beam.axis, random.direction()));
  beam.y_axis = glm::cross(beam.axis, beam.x_axis);
  beam.lens_m = 5.0 * random.direction();
  return beam;
}

glm::dvec3 stage_direction(const JudgeBeam& beam, const glm::dvec3& v) {
  return v.x * beam.x_axis + v.y * beam.y_axis + v.z * beam.axis;
}

// A midpoint sum and its largest value, without any code of the judge.
struct BruteForce {
  double sum = 0;
  double peak = 0;
};

BruteForce brute_force(const JudgeBeam& beam, const fixtures::Haze& haze, const Ray& ray, double t_max_m, int steps) {
  const double h = t_max_m / steps;
  const double sigma_t = haze.scattering_per_m + haze.absorption_per_m;
  BruteForce result;
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) * h;
    const glm::dvec3 p = ray.origin_m + t * ray.direction - beam.lens_m;
    const double z = glm::dot(p, beam.axis);
    if (z <= 0 || z > beam.range_m) continue;
    const double across = glm::length(p - z * beam.axis);
    const double w = beam.lens_radius_m + beam.spread * z;
    const double rho = across / w;
    if (rho >= 1) continue;
    // From the definition of the intensity: candela over the squared distance to the virtual apex.
    const glm::dvec3 apex = -beam.lens_radius_m / std::max(beam.spread, 1e-9) * beam.axis;
    const glm::dvec3 way = p - apex;
    const double r2 = glm::dot(way, way);
    const double intensity = (1 - std::pow(rho, 2 * beam.profile_power)) / (beam.spread * beam.spread);
    const double g = haze.anisotropy;
    const double cosine = -glm::dot(glm::normalize(way), ray.direction);
    const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
    const double from_lens_m = glm::length(way) * z / (z + beam.lens_radius_m / beam.spread);
    const double value = intensity / r2 * phase * std::exp(-sigma_t * (t + from_lens_m));
    result.sum += value * h;
    result.peak = std::max(result.peak, value);
  }
  return result;
}

}  // namespace

TEST_CASE("a chord across a cylinder of light has the integral of its polynomial") {
  JudgeBeam beam;
  beam.spread = 0;
  beam.lens_radius_m = 0.2;
  for (const double offset : {0.0, 0.05, 0.1, 0.19, 0.1999}) {
    const double judge = judge_inscatter(beam, kClear, {{offset, -3, 4}, {0, 1, 0}}, 0, 100, {}, 1e-10);
    const double half = std::sqrt(0.04 - offset * offset);
    const double exact = 4.0 / 3 * half * half * half / std::pow(0.2, 4) / (4 * kPi);
    CHECK(judge == doctest::Approx(exact).epsilon(1e-12));
  }
  CHECK(judge_inscatter(beam, kClear, {{0.2001, -3, 4}, {0, 1, 0}}, 0, 100, {}, 1e-10) == 0);
}

TEST_CASE(
    "a ray along the axis has the closed form T / (R0 (R0 + k T)) times the phase function of forward scattering") {
  JudgeBeam beam;
  beam.lens_radius_m = 0.05;
  beam.spread = 0.3;
  const double g = 0.6;
  for (const double end_m : {0.5, 10.0, 100.0}) {
    const double judge = judge_inscatter(beam, {0, 0, g}, {{0, 0, 0}, {0, 0, 1}}, 0, end_m, {}, 1e-12);
    const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g, 3));  // the light travels away from the camera
    CHECK(judge == doctest::Approx(phase * end_m / (0.05 * (0.05 + 0.3 * end_m))).epsilon(1e-11));
  }
}

TEST_CASE("the judge agrees with a brute-force sum over intensity and distance from the virtual apex") {
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    JudgeBeam beam = posed_beam(random);
    beam.lens_radius_m = random.uniform(0.03, 0.1);
    beam.spread = std::tan(random.uniform(0.05, 1.0));
    beam.profile_power = 1 + i % 4;
    beam.range_m = 15;
    const fixtures::Haze haze{random.uniform(0.005, 0.05), random.uniform(0, 0.05), random.uniform(-0.5, 0.8)};
    const glm::dvec3 target = beam.lens_m + random.uniform(0.5, 12) * beam.axis;
    const glm::dvec3 eye = target + 8.0 * random.direction();
    const Ray ray{eye, glm::normalize(target - eye)};
    const double judge = judge_inscatter(beam, haze, ray, 0, 20, {}, 1e-10);
    constexpr int kSteps = 400'000;
    const BruteForce brute = brute_force(beam, haze, ray, 20, kSteps);
    CHECK(judge > 0);
    // A midpoint sum misplaces each end of the lit part by up to half a step. The rest of its error is of second order.
    CHECK(std::abs(judge - brute.sum) <= brute.peak * 20 / kSteps + 1e-8 * judge);
    CHECK(judge == doctest::Approx(brute.sum).epsilon(1e-3));
  }
}

TEST_CASE("the light on a ray does not depend on the common position of beam and ray") {
  Random random(4);
  const std::vector<cases::BeamRay> rays = cases::rays_of("generic", 100, 1);
  for (const cases::BeamRay& r : rays) {
    JudgeBeam here;
    here.spread = static_cast<double>(r.spread);
    here.lens_radius_m = static_cast<double>(r.lens_radius_m);
    JudgeBeam there = posed_beam(random);
    there.spread = here.spread;
    there.lens_radius_m = here.lens_radius_m;
    const Ray ray{glm::dvec3(r.origin_m), glm::dvec3(r.direction)};
    const Ray moved{there.lens_m + stage_direction(there, ray.origin_m), stage_direction(there, ray.direction)};
    const fixtures::Haze haze{0.02, 0.01, 0.5};
    const double a = judge_inscatter(here, haze, ray, 0, 50, {}, 1e-10);
    const double b = judge_inscatter(there, haze, moved, 0, 50, {}, 1e-10);
    CHECK(std::abs(a - b) <= 1e-9 * a + 1e-12);
  }
}

TEST_CASE("two parts of a ray add up to the whole") {
  for (const char* name : {"generic", "inside the beam", "laser", "1 km away", "no end"}) {
    for (const cases::BeamRay& r : cases::rays_of(name, 200, 4)) {
      JudgeBeam beam;
      beam.spread = static_cast<double>(r.spread);
      beam.lens_radius_m = static_cast<double>(r.lens_radius_m);
      beam.profile_power = 4;
      const Ray ray{glm::dvec3(r.origin_m), glm::dvec3(r.direction)};
      const fixtures::Haze haze{0.02, 0, 0.3};
      const double middle = glm::length(ray.origin_m);  // in or near the beam
      const double first = judge_inscatter(beam, haze, ray, 0, middle, {}, 1e-10);
      const double second = judge_inscatter(beam, haze, ray, middle, 1e4, {}, 1e-10);
      const double whole = judge_inscatter(beam, haze, ray, 0, 1e4, {}, 1e-10);
      CHECK(std::abs(first + second - whole) <= 1e-9 * whole);
    }
  }
}

TEST_CASE("a gobo turns with its phase and dims by what it stops") {
  JudgeBeam beam;
  beam.spread = 0.2;
  beam.wheels[0].image = 3;
  const GoboTransmission right_half = [](int gobo, double x, double) { return gobo == 3 && x > 0 ? 1.0 : 0.0; };
  const Ray across{{-10, 0, 5}, {1, 0, 0}};  // along x of the beam, through both halves
  const double open = judge_inscatter(beam, kClear, across, 0, 100, {}, 1e-9);
  CHECK(judge_inscatter(beam, kClear, across, 0, 100, right_half, 1e-9) == doctest::Approx(open / 2).epsilon(1e-6));
  const auto lit = [&](double x, double y) {
    return judge_illuminance(beam, kClear, {x, y, 5}, {0, 0, -1}, right_half) > 0;
  };
  CHECK(lit(0.5, 0.0));
  CHECK_FALSE(lit(-0.5, 0.0));
  beam.wheels[0].cos = 0;  // a quarter turn: the open half has moved from +x to +y
  beam.wheels[0].sin = 1;
  CHECK(lit(0.0, 0.5));
  CHECK_FALSE(lit(0.0, -0.5));
  beam.wheels[0].image = 0;
  CHECK(lit(0.0, -0.5));
}

TEST_CASE("input that is not finite gives no light, and an infinite ray gives some") {
  JudgeBeam beam;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const Ray good{{0, -5, 3}, {0, 1, 0}};
  CHECK(judge_inscatter(beam, kClear, good, 0, infinity, {}, 1e-9) > 0);
  CHECK(judge_inscatter(beam, kClear, good, 0, nan, {}, 1e-9) == 0);
  CHECK(judge_inscatter(beam, kClear, good, nan, 5, {}, 1e-9) == 0);
  CHECK(judge_inscatter(beam, kClear, good, 5, 5, {}, 1e-9) == 0);
  CHECK(judge_inscatter(beam, kClear, {{nan, -5, 3}, {0, 1, 0}}, 0, 9, {}, 1e-9) == 0);
  CHECK(judge_inscatter(beam, kClear, {{0, infinity, 3}, {0, 1, 0}}, 0, 9, {}, 1e-9) == 0);
  CHECK(judge_inscatter(beam, kClear, {{0, -5, 3}, {0, nan, 0}}, 0, 9, {}, 1e-9) == 0);
}

TEST_CASE("the flux factor of a narrow beam is pi m / (m + 1)") {
  for (int m = 1; m <= 4; ++m) {
    CHECK(judge_flux_factor(0, m) == doctest::Approx(kPi * m / (m + 1)).epsilon(1e-13));
    CHECK(judge_flux_factor(1, m) < judge_flux_factor(0, m));
  }
}

TEST_CASE("a floor that receives the whole beam has its flux, at a right angle or tilted") {
  for (const double tilt : {0.0, 0.4, 0.8}) {
    for (const double spread : {0.05, 0.3}) {
      for (const double m : {1.0, 4.0}) {
        CAPTURE(tilt);
        CAPTURE(spread);
        JudgeBeam beam;  // the lens is at z = 6 above the floor z = 0, tilted towards x
        beam.lens_m = {0, 0, 6};
        beam.axis = {std::sin(tilt), 0, -std::cos(tilt)};
        beam.y_axis = {0, 1, 0};
        beam.x_axis = glm::cross(beam.y_axis, beam.axis);
        beam.spread = spread;
        beam.profile_power = m;
        // The floor around the beam in a grid of 1000 x 1000 midpoints.
        const double half_angle = std::atan(spread);
        const double from_x = 6 * std::tan(tilt - half_angle) - 0.3;
        const double to_x = 6 * std::tan(tilt + half_angle) + 0.3;
        const double half_y = 6 / std::cos(tilt) * spread * 2 + 0.3;
        constexpr int kCells = 1000;
        double flux = 0;
        for (int i = 0; i < kCells; ++i) {
          for (int j = 0; j < kCells; ++j) {
            const glm::dvec3 p(from_x + (i + 0.5) / kCells * (to_x - from_x), half_y * (2 * (j + 0.5) / kCells - 1), 0);
            flux += judge_illuminance(beam, kClear, p, {0, 0, 1}, {});
          }
        }
        flux *= (to_x - from_x) / kCells * 2 * half_y / kCells;
        // The error of the grid: measured 4.7e-7 at most.
        CHECK(flux == doctest::Approx(judge_flux_factor(spread, m)).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("a ray hits the nearest box that it enters from outside, on the side that it enters") {
  JudgeScene scene;
  scene.boxes = {{"floor", {-10, -10, -1}, {10, 10, 0}, glm::dvec3(0.1)},
                 {"riser", {-1, -1, 0}, {1, 1, 0.5}, glm::dvec3(0.2)},
                 {"room", {-100, -100, -100}, {100, 100, 100}, glm::dvec3(0.9)}};
  const auto down = judge_hit(scene, {{0, 0, 5}, {0, 0, -1}});
  REQUIRE(down);
  CHECK(down->t_m == 4.5);
  CHECK(down->normal == glm::dvec3(0, 0, 1));
  CHECK(down->albedo == glm::dvec3(0.2));
  const auto beside = judge_hit(scene, {{3, 0, 5}, {0, 0, -1}});
  REQUIRE(beside);
  CHECK(beside->t_m == 5);
  const auto side = judge_hit(scene, {{-5, 0, 0.25}, {1, 0, 0}});
  REQUIRE(side);
  CHECK(side->t_m == 4);
  CHECK(side->normal == glm::dvec3(-1, 0, 0));
  CHECK_FALSE(judge_hit(scene, {{0, 0, 5}, {0, 0, 1}}));
  CHECK_FALSE(judge_hit(scene, {{0, 0, 5}, {1, 0, 0}}));
}

TEST_CASE("work light alone has the radiance albedo / pi times its illuminance, less the extinction of haze") {
  JudgeScene scene;
  scene.boxes = {{"floor", {-10, -10, -1}, {10, 10, 0}, {0.1, 0.2, 0.4}}};
  scene.ambient_lx = 50;
  scene.haze = {0.02, 0.01, 0.5};
  const glm::dvec3 seen = judge_radiance(scene, {{0, 0, 5}, {0, 0, -1}}, 1e-9);
  for (int c = 0; c < 3; ++c) {
    CHECK(seen[c] == doctest::Approx(scene.boxes[0].albedo[c] / kPi * 50 * std::exp(-0.03 * 5)).epsilon(1e-13));
  }
}

TEST_CASE("a surface hides the air behind it") {
  JudgeScene scene;
  scene.haze = {0.02, 0, 0};
  scene.beams.emplace_back();  // along z from the origin
  const Ray ray{{-5, 0, 3}, {1, 0, 0}};
  const double open = judge_radiance(scene, ray, 1e-9).x;
  CHECK(open > 0);
  scene.boxes = {{"wall", {-3, -9, -9}, {-2, 9, 9}, glm::dvec3(0)}};
  CHECK(judge_radiance(scene, ray, 1e-9) == glm::dvec3(0));
  scene.boxes[0].min_m.x = 2;
  scene.boxes[0].max_m.x = 3;
  CHECK(judge_radiance(scene, ray, 1e-9).x == open);
  scene.boxes.clear();
  scene.range_m = 4;  // the air is visible only to here
  CHECK(judge_radiance(scene, ray, 1e-9).x == 0);
}

TEST_CASE("a picture is the same for every number of threads and states its own error") {
  JudgeScene scene;
  scene.haze = {0.02, 0, 0.5};
  scene.boxes = {{"floor", {-10, -10, -1}, {10, 10, 0}, glm::dvec3(0.3)}};
  Random random(9);
  for (int i = 0; i < 4; ++i) {
    JudgeBeam beam = posed_beam(random);
    beam.lens_m = {3 * i - 4.5, 2, 6};
    beam.axis = {0, 0, -1};
    beam.x_axis = {1, 0, 0};
    beam.y_axis = glm::cross(beam.axis, beam.x_axis);
    beam.spread = 0.1 + 0.1 * i;
    beam.strength_lm = {3000.0 * (i + 1), 2000, 1000};
    scene.beams.push_back(beam);
  }
  fixtures::Camera camera;
  const View view = view_of(camera);
  JudgeOptions options;
  options.threads = 1;
  const JudgedImage one = judge_image(scene, view, 33, 17, options);
  options.threads = 3;
  const JudgedImage three = judge_image(scene, view, 33, 17, options);
  CHECK(one.rgb == three.rgb);
  CHECK(one.hits_per_px == three.hits_per_px);
  CHECK(one.own_rel_l2 > 0);
  CHECK(one.own_rel_l2 < 1e-8);
  CHECK(one.own_max < 1e-7);
  CHECK(one.hits_per_px > 0.1);
  CHECK(one.image.rgb.size() == 33 * 17 * 3);
  CHECK(one.whole);

  // Single pixels in any order equal those of the whole picture.
  const std::vector<std::uint32_t> some = {8 * 33 + 16, 3, 16 * 33 + 32};
  const JudgedPixels pixels = judge_pixels(scene, view, 33, 17, some, options);
  REQUIRE(pixels.rgb.size() == 9);
  for (std::size_t i = 0; i < 9; ++i) CHECK(pixels.rgb[i] == one.rgb[some[i / 3] * 3 + i % 3]);
  CHECK(pixels.own_rel_l2 < 1e-8);

  // go_on can end it early.
  int most = 0;
  options.threads = 1;
  options.go_on = [&](int done, int all) {
    CHECK(all == 33 * 17);
    most = std::max(most, done);
    return done < 100;
  };
  CHECK(!judge_image(scene, view, 33, 17, options).whole);
  CHECK(most >= 100);
  CHECK(most < 200);
  // The middle pixel looks along the camera's axis.
  const Ray middle = pixel_ray(view, 33, 17, 16, 8);
  CHECK(glm::length(middle.direction - view.forward) < 1e-12);
  CHECK(judge_radiance(scene, middle, 1e-9).x == doctest::Approx(one.rgb[(8 * 33 + 16) * 3]).epsilon(1e-8));
}

TEST_CASE("the scene of a rig has the pose, the shape and the lumens of the walker's states") {
  fixtures::Rig rig;
  rig.haze = {0.02, 0, 0};
  rig.fixtures.emplace_back();
  rig.fixtures[0].position_m = {1, 2, 6};
  fixtures::CompiledRig compiled;
  fixtures::TypeRow type{};
  type.flux_lm = 8000;
  type.lens_radius_m = 0.06f;
  type.profile_power = 2;
  fixtures::JointRow lens{};  // no joint: the lens 0.75 m below
  lens.pose_0 = {1, 0, 0, 0};
  lens.pose_1 = {0, 1, 0, 0};
  lens.pose_2 = {0, 0, 1, -0.75f};
  fixtures::HeadRow row{};
  row.pose_0 = {1, 0, 0, 1};
  row.pose_1 = {0, 1, 0, 2};
  row.pose_2 = {0, 0, 1, 6};
  row.strobe = row.optics = fixtures::kNoAddress;
  compiled.types = {type};
  compiled.joints = {lens};
  compiled.heads = {row, row, row};
  fixtures::f64::Walker walker(compiled);
  for (auto& state : walker.states) {
    state = {};
    state.zoom = 0.3;
    state.red = 0.25;
    state.green = 0.125;
  }
  walker.states[1].red = walker.states[1].green = 0;  // dark
  walker.states[2].red = walker.states[2].green = 0;
  walker.states[2].blue = -1;  // counts as dark, too

  const JudgeScene scene = judge_scene(rig, walker);
  REQUIRE(scene.beams.size() == 1);
  const JudgeBeam& beam = scene.beams[0];
  CHECK(beam.axis == glm::dvec3(0, 0, -1));  // points straight down
  CHECK(glm::length(beam.lens_m - glm::dvec3(1, 2, 6 - 0.75)) < 1e-12);
  CHECK(beam.spread == std::tan(0.3));
  CHECK(beam.range_m == light_range_m(rig));
  CHECK(scene.range_m == kAirRangeM);
  const double factor = judge_flux_factor(beam.spread, 2);
  CHECK(beam.strength_lm.x * factor == doctest::Approx(2000));
  CHECK(beam.strength_lm.y * factor == doctest::Approx(1000));
  CHECK(beam.strength_lm.z == 0);
  CHECK(glm::cross(beam.x_axis, beam.y_axis) == beam.axis);
}
