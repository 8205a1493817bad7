// The difference of two pictures of the stage, and what is compared there.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "tools/footlight/preview/picture_difference.h"
#include "tools/footlight/preview/stage_comparison.h"

namespace footlight::tools {
namespace {

std::vector<std::uint8_t> grey(int pixels, std::uint8_t level) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < pixels; ++i) rgba.insert(rgba.end(), {level, level, level, 255});
  return rgba;
}

TEST_CASE("the largest and the mean difference are of the channel of a pixel that differs most") {
  std::vector<std::uint8_t> a = grey(8, 100);
  std::vector<std::uint8_t> b = a;
  b[4] = 151;   // red of the second pixel
  b[13] = 49;   // green of the fourth one
  b[14] = 101;  // and blue, which differs less
  std::vector<std::uint8_t> made;
  const PictureDifference difference = difference_of({a, 4, 2}, {b, 4, 2}, made);
  CHECK(difference.largest == doctest::Approx(0.2));
  CHECK(difference.mean == doctest::Approx(0.4 / 8));
  REQUIRE(made.size() == a.size());
  CHECK(made[0] == 0);
  CHECK(made[3] == 255);
  CHECK(std::equal(made.begin() + 4, made.begin() + 8, made.begin() + 12));  // equal differences, equal colours
  CHECK(made[4] > 100);
}

TEST_CASE("colours of differences go from black to white, and one step of 255 is not black") {
  const auto light = [](double difference) {
    const DifferenceColour colour = colour_of_difference(difference);
    return colour.r + colour.g + colour.b;
  };
  CHECK(light(0) == 0);
  CHECK(light(1) == doctest::Approx(3));
  CHECK(light(1.0 / 255) > 0.15f);
  for (int i = 0; i < 255; ++i) CHECK(light((i + 1) / 255.0) > light(i / 255.0));
}

// Two pictures of the stage: B and A, of one size.
bool shows(StageComparison& both, std::uint8_t b, std::uint8_t a, FlashMode flashes, DurationNs at_ns) {
  const std::vector<std::uint8_t> of_b = grey(64 * 36, b);
  const std::vector<std::uint8_t> of_a = grey(64 * 36, a);
  both.take_b({of_b, 64, 36});
  return both.take_a({of_a, 64, 36}, flashes, at_ns);
}

TEST_CASE("a difference that flashes is held back where flashes are limited, and both numbers are of what is shown") {
  StageComparison both;
  both.set_mode(StageCompare::kDifference);
  for (const FlashMode mode : {FlashMode::kOff, FlashMode::kWarn, FlashMode::kLimit}) {
    both.set_mode(StageCompare::kOff);
    both.set_mode(StageCompare::kDifference);
    int held = 0;
    for (int i = 0; i < 60; ++i) {
      const std::uint8_t level = i / 2 % 2 == 0 ? 0 : 255;  // 15 flashes a second
      const bool shown = shows(both, level, 0, mode, i * kNsPerS / 60);
      held += shown ? 0 : 1;
      if (shown) CHECK(both.difference()->largest == doctest::Approx(level / 255.0));
    }
    CHECK((held > 10) == (mode == FlashMode::kLimit));
    CHECK((both.watch() != nullptr && both.watch()->harmful()) == (mode != FlashMode::kOff));
  }
}

TEST_CASE("pictures of two sizes have no difference, and one is there only while the mode is on") {
  StageComparison both;
  both.set_mode(StageCompare::kDifference);
  const std::vector<std::uint8_t> rgba = grey(64 * 36, 9);
  CHECK(!both.take_a({rgba, 64, 36}, FlashMode::kOff, 0));
  both.take_b({rgba, 36, 64});
  CHECK(!both.take_a({rgba, 64, 36}, FlashMode::kOff, 0));
  CHECK(shows(both, 3, 5, FlashMode::kOff, 0));
  CHECK(both.difference());
  both.set_mode(StageCompare::kOff);
  CHECK(!both.difference());
  CHECK(!stage_compare_of("besides"));
  CHECK(stage_compare_of("beside") == StageCompare::kBeside);
}

TEST_CASE("a comparison that begins anew during a picture goes on with B, whose camera A needs") {
  const OrbitCamera camera{fixtures::Camera{}};
  StageComparison both;
  both.set_mode(StageCompare::kBeside);
  both.begin(camera, 40, 20);
  both.end();
  CHECK(both.next_side() == StageComparison::kA);
  both.begin(camera, 90, 50);  // of A: with the time and exposure of B
  CHECK(both.log_ns() == 40);
  CHECK(both.exposure_ns() == 20);
  both.end();
  both.begin(camera, 0, 0);
  both.begin_anew();
  both.end();
  CHECK(both.next_side() == StageComparison::kB);
  both.begin(camera, 0, 0);
  CHECK(both.camera());
}

}  // namespace
}  // namespace footlight::tools
