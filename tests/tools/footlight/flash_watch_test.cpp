#include "tools/footlight/pictures/flash_watch.h"

#include <cmath>
#include <cstddef>

#include <doctest/doctest.h>

namespace footlight::tools {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 36;

// Grey, except for the columns from `from` on, which have the given colour.
render::ScreenImage picture(int from, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  render::ScreenImage image{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight * 4, 60)};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = from; x < kWidth; ++x) {
      std::uint8_t* pixel = &image.rgba[static_cast<std::size_t>(y * kWidth + x) * 4];
      pixel[0] = red;
      pixel[1] = green;
      pixel[2] = blue;
    }
  }
  return image;
}

// A picture every 20 ms for 4 s, of which every `period` pictures the first half is lit. Returns the brightest byte of
// the last second.
int play(FlashWatch& watch, int period, int from, std::uint8_t level) {
  int brightest = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint8_t now = i % period < period / 2 ? level : std::uint8_t{0};
    render::ScreenImage image = picture(from, now, now, now);
    watch.check(i * 20 * kNsPerMs, image);
    if (i >= 150) brightest = std::max<int>(brightest, image.rgba[(std::size_t{kWidth} * 18 + 60) * 4]);
  }
  return brightest;
}

TEST_CASE("five flashes a second over half of the picture are one harmful period, two a second are none") {
  FlashWatch fast(false);
  play(fast, 10, kWidth / 2, 255);
  REQUIRE(fast.stretches().size() == 1);
  CHECK(fast.stretches()[0].from_ns < kNsPerS);
  CHECK(fast.stretches()[0].until_ns > 3 * kNsPerS);
  CHECK(fast.stretches()[0].flashes == doctest::Approx(5).epsilon(0.11));
  CHECK(fast.stretches()[0].area == doctest::Approx(0.5));
  CHECK_FALSE(fast.stretches()[0].red);
  FlashWatch slow(false);
  play(slow, 25, kWidth / 2, 255);
  CHECK(slow.stretches().empty());
}

TEST_CASE("fast flashes over an eighth of the picture, or hardly brighter than the dark, are not harmful") {
  FlashWatch small(false);
  play(small, 10, kWidth * 7 / 8, 255);
  CHECK(small.stretches().empty());
  FlashWatch dim(false);
  play(dim, 10, kWidth / 2, 60);
  CHECK(dim.stretches().empty());
}

TEST_CASE("a watch that only warns changes no byte, and one that limits makes the same sequence harmless") {
  FlashWatch looking(false);
  CHECK(play(looking, 10, 0, 255) == 255);
  CHECK(looking.least_gain() == 1);

  FlashWatch limiting(true);
  FlashWatch judge(false);
  for (int i = 0; i < 200; ++i) {
    const std::uint8_t now = i % 10 < 5 ? std::uint8_t{255} : std::uint8_t{0};
    render::ScreenImage image = picture(0, now, now, now);
    limiting.check(i * 20 * kNsPerMs, image);
    judge.check(i * 20 * kNsPerMs, image);
  }
  CHECK(limiting.stretches().size() == 1);  // of the input
  CHECK(limiting.least_gain() < 0.5);
  CHECK(judge.stretches().empty());
}

TEST_CASE("red flashes that hardly change luminance are detected by their colour") {
  FlashWatch watch(false);
  for (int i = 0; i < 100; ++i) {
    // 0.2126 x 0.32 of 200 cd/m^2 against 0.07: a change of 13 cd/m^2.
    render::ScreenImage image = i % 10 < 5 ? picture(0, 155, 0, 0) : picture(0, 10, 10, 10);
    watch.check(i * 20 * kNsPerMs, image);
  }
  REQUIRE(watch.stretches().size() == 1);
  CHECK(watch.stretches()[0].red);
}

TEST_CASE("holding pictures back leaves at most three flashes a second, and harmless pictures are not held") {
  FlashWatch guard(false);
  FlashWatch seen(false);
  render::ScreenImage standing = picture(0, 0, 0, 0);
  int waited = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint8_t now = i % 10 < 5 ? std::uint8_t{255} : std::uint8_t{0};
    const render::ScreenImage next = picture(kWidth / 2, now, now, now);
    const bool waits = guard.must_wait(i * 20 * kNsPerMs, next);
    waited += waits ? 1 : 0;
    if (!waits) standing = next;
    render::ScreenImage shown = standing;
    seen.check(i * 20 * kNsPerMs, shown);
  }
  CHECK(waited > 20);
  CHECK(guard.harmful());
  CHECK(seen.stretches().empty());
  FlashWatch slow(false);
  for (int i = 0; i < 200; ++i) {
    const std::uint8_t now = i % 40 < 20 ? std::uint8_t{255} : std::uint8_t{0};
    REQUIRE_FALSE(slow.must_wait(i * 20 * kNsPerMs, picture(kWidth / 2, now, now, now)));
  }
}

TEST_CASE("a watch that begins to hold pictures back counts the flashes that were shown before") {
  FlashWatch warned(false);
  FlashWatch fresh(false);
  const auto lit = [](int i) { return i % 10 < 5 ? std::uint8_t{255} : std::uint8_t{0}; };
  for (int i = 0; i < 35; ++i) {  // three flashes and a half
    render::ScreenImage image = picture(0, lit(i), lit(i), lit(i));
    warned.check(i * 20 * kNsPerMs, image);
  }
  warned.hold_from_here();
  int held = 0;
  int held_by_fresh = 0;
  for (int i = 35; i < 45; ++i) {
    const render::ScreenImage image = picture(0, lit(i), lit(i), lit(i));
    held += warned.must_wait(i * 20 * kNsPerMs, image) ? 1 : 0;
    held_by_fresh += fresh.must_wait(i * 20 * kNsPerMs, image) ? 1 : 0;
  }
  CHECK(held > 0);
  CHECK(held_by_fresh == 0);
}

}  // namespace
}  // namespace footlight::tools
