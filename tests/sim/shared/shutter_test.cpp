// The strobe's exposure integral.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "sim/shared/shared.h"

namespace footlight {
namespace {

TEST_CASE("an exposure of whole turns sees the duty, wherever it begins") {
  for (const double duty : {0.1, 0.4, 0.9}) {
    for (const double phase : {0.0, 0.05, 0.3, 0.77, 0.999}) {
      for (const double turns : {1.0, 2.0, 40.0}) {
        CHECK(f64::shutter_open_share(phase, turns, duty) == doctest::Approx(duty).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("exposures that follow each other add up to one exposure") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double duty = 0.05 + 0.9 * unit(random);
    const double phase = unit(random);
    const double a = 3 * unit(random) + 1e-3;
    const double b = 3 * unit(random) + 1e-3;
    const double middle = phase + a;
    const double parts = f64::shutter_open_share(phase, a, duty) * a +
                         f64::shutter_open_share(middle - std::floor(middle), b, duty) * b;
    REQUIRE(parts == doctest::Approx(f64::shutter_open_share(phase, a + b, duty) * (a + b)).epsilon(1e-10));
  }
}

TEST_CASE("within one flash the shutter is wholly open, between two wholly closed") {
  CHECK(f64::shutter_open_share(0.1, 0.2, 0.4) == doctest::Approx(1.0));
  CHECK(f64::shutter_open_share(0.5, 0.3, 0.4) == doctest::Approx(0.0));
  CHECK(f64::shutter_open_share(0.3, 0.2, 0.4) == doctest::Approx(0.5));
}

TEST_CASE("an exposure too short to integrate sees the state at its start") {
  for (const double turns : {0.0, 1e-9, -1.0, std::nan("")}) {
    CHECK(f64::shutter_open_share(0.39, turns, 0.4) == 1.0);
    CHECK(f64::shutter_open_share(0.41, turns, 0.4) == 0.0);
  }
}

TEST_CASE("the share agrees with counting over a fine grid of instants") {
  for (const double turns : {0.07, 0.9, 5.3}) {
    constexpr int kInstants = 200'000;
    int open = 0;
    for (int i = 0; i < kInstants; ++i) {
      const double p = 0.85 + turns * (i + 0.5) / kInstants;
      open += p - std::floor(p) < 0.3;
    }
    CHECK(f64::shutter_open_share(0.85, turns, 0.3) ==
          doctest::Approx(static_cast<double>(open) / kInstants).epsilon(1e-4));
  }
}

}  // namespace
}  // namespace footlight
