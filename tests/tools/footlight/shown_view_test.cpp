// False colours and the numbers behind them.
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "tools/footlight/pictures/shown_view.h"

namespace footlight::tools {
namespace {

TEST_CASE("words of --show that are none are refused with those that are") {
  CHECK(shown_view_of("lux").value() == ShownView::kLux);
  const auto none = shown_view_of("luxx");
  REQUIRE(!none);
  CHECK(none.error().message.find("expected picture, classes, hits, steps, lux or error") != std::string::npos);
}

TEST_CASE("shares of classes are those of all hits, and zero where nothing is hit") {
  const ClassShares shares = class_shares({2, 1, {1, 2, 0, 0, 4, 3}});
  CHECK(shares.hits_per_px == doctest::Approx(5));
  CHECK(shares.pixel == doctest::Approx(0.1));
  CHECK(shares.smooth == doctest::Approx(0.6));
  CHECK(shares.record == doctest::Approx(0.3));
  CHECK(class_shares({1, 1, {0, 0, 0}}).hits_per_px == 0);
}

TEST_CASE("the error of a pixel is relative to its light and a hundredth of the mean") {
  const render::RadianceImage reference{2, 1, {1, 1, 1, 0, 0, 0}};
  const Values errors = error_of({2, 1, {1, 1.1f, 1, 0, 0, 0.001f}}, reference);
  CHECK(errors.values[0] == doctest::Approx(0.1 / 1.005));
  CHECK(errors.values[1] == doctest::Approx(0.001 / 0.005));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(std::isnan(error_of({2, 1, {nan, 1, 1, 0, 0, 0}}, reference).values[0]));
}

TEST_CASE("false colours are black below the scale, white for NaN, and go from blue to red") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const render::ScreenImage screen = heat_picture({4, 1, {0.5f, nan, 1.0f, 1000.0f}}, 1, 100);
  const auto at = [&](std::size_t pixel, std::size_t channel) { return int{screen.rgba[4 * pixel + channel]}; };
  CHECK(at(0, 0) + at(0, 1) + at(0, 2) == 0);
  CHECK(at(1, 0) + at(1, 1) + at(1, 2) == 3 * 255);
  CHECK(at(2, 2) > at(2, 0));
  CHECK(at(3, 0) > at(3, 2));
  for (std::size_t pixel = 0; pixel < 4; ++pixel) CHECK(at(pixel, 3) == 255);
}

TEST_CASE("the picture of classes is red, green and blue by their shares, and black without beams") {
  const render::ScreenImage screen = class_picture({2, 1, {0, 8, 0, 0, 0, 0}});
  CHECK(int{screen.rgba[0]} == 0);
  CHECK(int{screen.rgba[1]} == 255);
  CHECK(int{screen.rgba[5]} == 0);
}

}  // namespace
}  // namespace footlight::tools
