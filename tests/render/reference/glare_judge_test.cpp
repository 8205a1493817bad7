// The definition of the camera's glare: its integral, the light between pixels, and the Gaussians that it is a mixture
// of.
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include "render/beam.h"
#include "render/reference/glare_judge.h"

namespace {

using namespace footlight::render;

// The integral over the plane within `to`, by midpoints in the logarithm of the distance.
double within(double to) {
  constexpr int kSteps = 20'000;
  const double from = 1e-7;
  const double step = std::log(to / from) / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double r = from * std::exp((i + 0.5) * step);
    sum += 2 * std::numbers::pi * r * r * glare_density(r) * step;
  }
  return sum;
}

TEST_CASE("the density of the glare holds all of its light") {
  // Beyond 100 focal lengths is only the steep power: its share times the core.
  const double beyond = f64::kGlareSteep * f64::kGlareCore / 100;
  CHECK(std::abs(within(100) + beyond - 1) < 1e-7);
}

TEST_CASE("the glare falls as 10 / theta^3 + 5 / theta^2 between one and ten degrees") {
  const auto form = [](double degrees) { return 10 / (degrees * degrees * degrees) + 5 / (degrees * degrees); };
  const auto density = [](double degrees) { return glare_density(degrees * std::numbers::pi / 180); };
  for (const double degrees : {2.0, 3.0, 5.0, 10.0}) {
    CHECK(std::abs(density(degrees) / density(1) / (form(degrees) / form(1)) - 1) < 0.05);
  }
}

TEST_CASE("the light between pixels is the density times their size where they are far apart, and adds up to all") {
  const double pixel = 0.0021;
  CHECK(std::abs(glare_between(30, -40, pixel) / (pixel * pixel * glare_density(50 * pixel)) - 1) < 2e-3);
  CHECK(glare_between(30, -40, pixel) == glare_between(-40, 30, pixel));
  double sum = 0;
  for (int y = -30; y <= 30; ++y) {
    for (int x = -30; x <= 30; ++x) sum += glare_between(x, y, pixel);
  }
  // A square of that side lies between these circles.
  CHECK(sum > within(30 * pixel));
  CHECK(sum < within(31 * std::numbers::sqrt2 * pixel));
  // Of a pixel of a micrometre in a focal length of a metre nearly nothing stays in it, of a large one most.
  CHECK(glare_between(0, 0, 1e-6) < 1e-6);
  CHECK(glare_between(0, 0, 0.1) > 0.7);
}

TEST_CASE("one Gaussian an octave gives the density within 4 %") {
  double worst = 0;
  for (double r = 1e-4; r < 1; r *= 1.07) {
    double sum = 0;
    for (double variance = 1e-14; variance < 100; variance *= 4) {
      sum += f64::glare_octave(variance) * std::exp(-r * r / (2 * variance)) / (2 * std::numbers::pi * variance);
    }
    worst = std::max(worst, std::abs(sum / glare_density(r) - 1));
  }
  MESSAGE("worst ", worst);
  CHECK(worst < 0.04);
}

}  // namespace
