// The sheen of render/shaders/shared/sheen.h against integrals that do not use its formula: facets by their slopes, and
// lenses by their points.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <glm/glm.hpp>

#include "render/probe.h"

namespace {

using namespace footlight::render;
using glm::dvec2;
using glm::dvec3;

constexpr double kPi = std::numbers::pi;
const dvec3 kUp(0, 0, 1);

bool prints() { return std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr; }

dvec3 direction(double angle_rad, double turn_rad = 0) {
  return {std::sin(angle_rad) * std::cos(turn_rad), std::sin(angle_rad) * std::sin(turn_rad), std::cos(angle_rad)};
}

// Integral over the directions above the surface of function times cosine. Half of the directions lie around the
// mirrored one of `to_eye`, so that narrow highlights are met.
template <class Function>
dvec3 over_hemisphere(const dvec3& to_eye, double alpha, const Function& function) {
  // Facets by slope tan = alpha t / sqrt(1 - t^2) and turn, and the direction that each mirrors; the Jacobian of the
  // reflection is 4 (eye . facet).
  constexpr int kAcross = 600, kAround = 400;
  dvec3 sum(0);
  for (int i = 0; i < kAcross; ++i) {
    const double share = (i + 0.5) / kAcross;
    const double slope = alpha * std::sqrt(share / (1 - share));
    const double cosine = 1 / std::sqrt(1 + slope * slope);
    const double density = std::pow((1 + slope * slope / (alpha * alpha)), -2) / (kPi * alpha * alpha) /
                           (cosine * cosine * cosine);  // per solid angle of facets
    for (int k = 0; k < kAround; ++k) {
      const double turn = 2 * kPi * (k + 0.5) / kAround;
      const dvec3 facet(slope * cosine * std::cos(turn), slope * cosine * std::sin(turn), cosine);
      const double facing = glm::dot(to_eye, facet);
      if (!(facing > 0)) continue;
      const dvec3 to_light = 2 * facing * facet - to_eye;
      if (!(to_light.z > 0)) continue;
      sum += function(to_light) * (to_light.z * 4 * facing / density);
    }
  }
  return sum / static_cast<double>(kAcross * kAround);
}

// The same by directions that are spread evenly, for what has no peak.
template <class Function>
dvec3 evenly(const Function& function) {
  constexpr int kAcross = 400, kAround = 400;
  dvec3 sum(0);
  for (int i = 0; i < kAcross; ++i) {
    for (int k = 0; k < kAround; ++k) {
      const double sine_square = (i + 0.5) / kAcross;
      const double turn = 2 * kPi * (k + 0.5) / kAround;
      const double sine = std::sqrt(sine_square);
      sum += function(dvec3(sine * std::cos(turn), sine * std::sin(turn), std::sqrt(1 - sine_square)));
    }
  }
  return sum * kPi / static_cast<double>(kAcross * kAround);
}

// Light that a surface of facets reflects once, of the light that comes along `to_eye`: each facet by its slope, with
// Fresnel's share, lit and seen as far as Smith's shadows leave it. No formula of the header.
struct FacetLight {
  double all = 0;
  double forward = 0;  // of it, to the side away from the eye, below 45 degrees
};
double smith(double cosine, double alpha) {
  const double tangent = std::sqrt(1 - cosine * cosine) / cosine;
  return (std::sqrt(1 + alpha * alpha * tangent * tangent) - 1) / 2;
}
FacetLight facet_light(const dvec3& to_eye, double alpha, double straight) {
  constexpr int kAcross = 1500, kAround = 800;
  FacetLight light;
  for (int i = 0; i < kAcross; ++i) {
    const double share = (i + 0.5) / kAcross;
    const double slope = alpha * std::sqrt(share / (1 - share));  // Student's distribution of slopes
    for (int k = 0; k < kAround; ++k) {
      const double turn = 2 * kPi * (k + 0.5) / kAround;
      const dvec3 across(slope * std::cos(turn), slope * std::sin(turn), 1);
      const double facing = glm::dot(to_eye, across);  // area of the facet towards the eye, over that of the surface
      if (!(facing > 0)) continue;
      const dvec3 facet = glm::normalize(across);
      const dvec3 to_light = 2 * glm::dot(to_eye, facet) * facet - to_eye;
      if (!(to_light.z > 0)) continue;
      const double fresnel = straight + (1 - straight) * std::pow(1 - glm::dot(to_eye, facet), 5);
      const double lit = 1 / (1 + smith(to_eye.z, alpha) + smith(to_light.z, alpha));
      const double value = fresnel * lit * facing / to_eye.z / (kAcross * kAround);
      light.all += value;
      if (to_light.x < 0 && to_light.z < std::sqrt(0.5)) light.forward += value;
    }
  }
  return light;
}

TEST_CASE("sheen sends light where facets of its slopes send it") {
  for (const double roughness : {0.2, 0.35, 0.5, 0.8, 1.0}) {
    const double alpha = roughness * roughness;
    for (const double angle_deg : {0.0, 30.0, 60.0, 80.0}) {
      const dvec3 to_eye = direction(angle_deg * kPi / 180);
      for (const double straight : {0.04, 1.0}) {
        const FacetLight facets = facet_light(to_eye, alpha, straight);
        const auto gloss = [&](const dvec3& to_light) {
          return f64::sheen_gloss(dvec3(straight), alpha, 0, kUp, to_eye, to_light);
        };
        const double all = over_hemisphere(to_eye, alpha, gloss).x;
        const double forward = over_hemisphere(to_eye, alpha, [&](const dvec3& to_light) {
                                 return to_light.x < 0 && to_light.z < std::sqrt(0.5) ? gloss(to_light) : dvec3(0);
                               }).x;
        CAPTURE(roughness);
        CAPTURE(angle_deg);
        CAPTURE(straight);
        CHECK(all == doctest::Approx(facets.all).epsilon(2e-3));
        CHECK(std::abs(forward - facets.forward) < 2e-3 * facets.all);
      }
    }
  }
}

TEST_CASE("a surface with sheen reflects no more light than comes, from any side, at any roughness, metal and colour") {
  double most = 0;
  for (const double roughness : {0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0}) {
    for (const double metal : {0.0, 0.5, 1.0}) {
      for (const double color : {0.0, 0.5, 1.0}) {
        const f64::Sheen sheen = f64::sheen_of(dvec3(color), dvec3(color), roughness, metal);
        if (prints() && color == 1.0) std::printf("roughness %.2f metal %.1f:", roughness, metal);
        for (const double angle_deg : {0.0, 30.0, 60.0, 80.0, 89.0}) {
          const dvec3 to_eye = direction(angle_deg * kPi / 180);
          const double gloss = over_hemisphere(to_eye, sheen.alpha, [&](const dvec3& to_light) {
                                 return f64::sheen_gloss(sheen.straight, sheen.alpha, 0, kUp, to_eye, to_light);
                               }).x;
          f64::Sheen matt = sheen;
          matt.straight = dvec3(0);
          const double rest = evenly([&](const dvec3& to_light) {
                                return f64::sheen_reflected(matt, 0, kUp, to_eye, to_light) -
                                       f64::sheen_gloss(dvec3(0), sheen.alpha, 0, kUp, to_eye, to_light);
                              }).x;
          CAPTURE(roughness);
          CAPTURE(metal);
          CAPTURE(color);
          CAPTURE(angle_deg);
          CHECK(gloss >= 0);
          CHECK(rest >= 0);
          CHECK(gloss + rest <= 1.0005);  // the error of the integrals
          most = std::max(most, gloss + rest);
          if (prints() && color == 1.0) std::printf(" %2.0f deg %.3f + %.3f", angle_deg, gloss, rest);
        }
        if (prints() && color == 1.0) std::printf("\n");
      }
    }
  }
  CHECK(most > 0.95);  // and they are not merely dark
}

TEST_CASE("sheen is the same with light and eye exchanged") {
  for (const double roughness : {0.1, 0.4, 1.0}) {
    const f64::Sheen sheen = f64::sheen_of({0.9, 0.5, 0.1}, {0.9, 0.5, 0.1}, roughness, 0.3);
    for (const double a : {0.0, 0.3, 0.9, 1.5}) {
      for (const double b : {0.1, 0.6, 1.2, 1.55}) {
        const dvec3 one = direction(a, 0.4);
        const dvec3 other = direction(b, 2.9);
        const dvec3 there = f64::sheen_reflected(sheen, 0.02, kUp, one, other);
        const dvec3 back = f64::sheen_reflected(sheen, 0.02, kUp, other, one);
        for (int c = 0; c < 3; ++c) CHECK(there[c] == doctest::Approx(back[c]).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("sheen in float is that in double, and finite in every direction") {
  double most = 0;
  for (const double roughness : {0.0, 0.1, 0.35, 1.0}) {
    const f64::Sheen sheen = f64::sheen_of(dvec3(0.6), dvec3(0.6), roughness, 0.5);
    const auto single = static_cast<float>(roughness);
    const f32::Sheen small = f32::sheen_of(glm::vec3(0.6F), glm::vec3(0.6F), single, 0.5F);
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 40; ++k) {
        const dvec3 to_eye = direction(i * kPi / 60, 0.3);
        // Every other one within some lobes of the mirrored direction.
        const dvec3 to_light =
            k % 2 == 0 ? direction(k * kPi / 80, 1.7) : direction(i * kPi / 60 + k * 1e-3, 0.3 + kPi);
        const dvec3 exact = f64::sheen_reflected(sheen, 0.001, kUp, to_eye, to_light);
        const glm::vec3 value =
            f32::sheen_reflected(small, 0.001F, glm::vec3(kUp), glm::vec3(to_eye), glm::vec3(to_light));
        REQUIRE(std::isfinite(value.x));
        if (to_eye.z > 0.02 && to_light.z > 0.02)
          most = std::max(most, std::abs(static_cast<double>(value.x) - exact.x) / exact.x);
      }
    }
  }
  if (prints()) std::printf("sheen: float against double, at most %.2g\n", most);
  CHECK(most < 2e-4);
  // Light and eye on one line along the surface, and a lens as wide as the sky.
  const f32::Sheen smooth = f32::sheen_of(glm::vec3(1), glm::vec3(1), 0, 1);
  const glm::vec3 x(1, 0, 0);
  for (const float lens_rad : {0.0F, 1.5F, 1e6F}) {
    CHECK(std::isfinite(f32::sheen_reflected(smooth, lens_rad, glm::vec3(0, 0, 1), x, -x).x));
    CHECK(std::isfinite(f32::sheen_reflected(smooth, lens_rad, glm::vec3(0, 0, 1), -x, -x).x));
  }
}

// What `points` of a lens give on average, and the widened highlight, along a line of places across the highlight:
// relative L2, and the ratio of the peaks.
struct Widened {
  double rel_l2 = 0;
  double peak = 0;
};
Widened widened(double alpha, double lens_rad, double angle_rad) {
  constexpr int kPlaces = 161, kPoints = 800;
  const double reach = 4 * (2 * alpha + lens_rad);
  double off = 0, all = 0, most = 0, most_widened = 0;
  const dvec3 to_eye = direction(angle_rad);
  for (int i = 0; i < kPlaces; ++i) {
    const double away = reach * (2.0 * i / (kPlaces - 1) - 1);
    const double at = angle_rad + away;
    if (!(std::abs(at) < 1.5)) continue;
    const dvec3 middle = direction(at, kPi);
    const dvec3 right(0, 1, 0);
    const dvec3 up = glm::cross(middle, right);
    double mean = 0;
    for (int p = 0; p < kPoints; ++p) {
      const double r = lens_rad * std::sqrt((p + 0.5) / kPoints);
      const double turn = p * kPi * (3 - std::sqrt(5.0));
      const dvec3 to_light = glm::normalize(middle + r * (std::cos(turn) * right + std::sin(turn) * up));
      mean += f64::sheen_gloss(dvec3(1), alpha, 0, kUp, to_eye, to_light).x * std::max(to_light.z, 0.0) / kPoints;
    }
    const double value = f64::sheen_gloss(dvec3(1), alpha, lens_rad, kUp, to_eye, middle).x * middle.z;
    off += (value - mean) * (value - mean);
    all += mean * mean;
    most = std::max(most, mean);
    most_widened = std::max(most_widened, value);
  }
  return {std::sqrt(off / all), most_widened / most};
}

TEST_CASE("a highlight widened by the angle of a lens is near the mean over the lens") {
  for (const double angle_deg : {0.0, 45.0, 70.0}) {
    for (const double roughness : {0.1, 0.2, 0.35, 0.5}) {
      for (const double lens_rad : {0.005, 0.02, 0.1}) {
        const double alpha = roughness * roughness;
        const Widened made = widened(alpha, lens_rad, angle_deg * kPi / 180);
        if (prints()) {
          std::printf("widened: %2.0f deg, roughness %.2f, lens %.3f rad: relL2 %.3f, peak %.3f\n", angle_deg,
                      roughness, lens_rad, made.rel_l2, made.peak);
        }
        CAPTURE(angle_deg);
        CAPTURE(roughness);
        CAPTURE(lens_rad);
        CHECK(made.rel_l2 < 0.36);
        CHECK(made.peak > 0.97);
        CHECK(made.peak < 1.13);
      }
    }
  }
}

}  // namespace
