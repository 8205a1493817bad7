#include "render/reference/glare_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>

namespace footlight::render {
namespace {

// The definition, not the constants that the renderer computes from it.
const double kCoreRadius = std::tan(0.1 * std::numbers::pi / 180);
constexpr double kReachRadius = 1;

double steep_density(double q) { return kCoreRadius / (2 * std::numbers::pi * q * q * q); }
double wide_density(double q) {
  static const double kAll =
      2 * std::numbers::pi * kReachRadius * boost::math::cyl_bessel_k(0, kCoreRadius / kReachRadius);
  return boost::math::cyl_bessel_k(1, q / kReachRadius) / (q * kAll);
}

// Of both powers, by 10 / theta^3 + 5 / theta^2 in degrees and the integral of each.
double steep_share() {
  const double degrees = 180 / std::numbers::pi;
  const double steep = 10 / (degrees * degrees * degrees) * 2 * std::numbers::pi / kCoreRadius;
  const double wide =
      5 / (degrees * degrees) * 2 * std::numbers::pi * boost::math::cyl_bessel_k(0, kCoreRadius / kReachRadius);
  return steep / (steep + wide);
}

// Integral over part of the unit cell from (x, y), of side `side`, of the tents round dx and dy times g. Cells at the
// middle are cut until g is smooth in them.
double over_cell(double x, double y, double side, int dx, int dy, double pixel) {
  const double nearest = std::hypot(x, y);  // x, y >= 0
  if (nearest < side && side * pixel > kCoreRadius / 4) {
    const double half = side / 2;
    return over_cell(x, y, half, dx, dy, pixel) + over_cell(x + half, y, half, dx, dy, pixel) +
           over_cell(x, y + half, half, dx, dy, pixel) + over_cell(x + half, y + half, half, dx, dy, pixel);
  }
  const auto rows = [&](double v) {
    return boost::math::quadrature::gauss<double, 7>::integrate(
        [&](double u) {
          const double tents = (1 - std::abs(u - dx)) * (1 - std::abs(v - dy));
          return tents * glare_density(pixel * std::hypot(u, v));
        },
        x, x + side);
  };
  return pixel * pixel * boost::math::quadrature::gauss<double, 7>::integrate(rows, y, y + side);
}

}  // namespace

double glare_density(double r) {
  static const double kSteep = steep_share();
  const double q = std::hypot(r, kCoreRadius);
  return kSteep * steep_density(q) + (1 - kSteep) * wide_density(q);
}

double glare_between(int dx, int dy, double pixel) {
  dx = std::abs(dx);
  dy = std::abs(dy);
  double sum = 0;
  for (const int x : {dx - 1, dx}) {
    for (const int y : {dy - 1, dy}) {
      // Left of the middle is as right of it.
      sum += over_cell(x < 0 ? 0 : x, y < 0 ? 0 : y, 1, dx, dy, pixel);
    }
  }
  return sum;
}

std::vector<double> judge_glare(const RadianceImage& light, double pixel) {
  const int width = light.width;
  const int height = light.height;
  const auto at = [width](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  std::vector<double> between(at(0, height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) between[at(x, y)] = glare_between(x, y, pixel);
  }
  std::vector<double> scattered(between.size() * 3);
  for (int from_y = 0; from_y < height; ++from_y) {
    for (int from_x = 0; from_x < width; ++from_x) {
      const float* from = &light.rgb[3 * at(from_x, from_y)];
      const std::array<double, 3> own{std::max<double>(from[0], 0), std::max<double>(from[1], 0),
                                      std::max<double>(from[2], 0)};
      if (!(own[0] + own[1] + own[2] > 0)) continue;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double share = between[at(std::abs(x - from_x), std::abs(y - from_y))];
          for (std::size_t c = 0; c < 3; ++c) scattered[3 * at(x, y) + c] += share * own[c];
        }
      }
    }
  }
  return scattered;
}

}  // namespace footlight::render
