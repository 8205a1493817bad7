// The flash guard: its counts, and that limited light is never harmful.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "sim/photosensitive.h"

namespace footlight {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

TileLight grey(double luminance_cd_m2) {
  const double share = luminance_cd_m2 / 200;
  return {luminance_cd_m2, share, share, share};
}
TileLight red(double share) { return {share * 42, share, 0, 0}; }

// A whole picture of one tile that flashes at `hz` between two lights, at 100 frames a second for `length_s`.
FlashVerdict flash(PhotosensitiveGuard& guard, double hz, TileLight dark, TileLight bright, double length_s = 1.5) {
  FlashVerdict verdict;
  for (int frame = 0; frame < static_cast<int>(length_s * 100); ++frame) {
    const double place = frame / 100.0 * hz;
    const TileLight light = place - std::floor(place) < 0.5 ? dark : bright;
    verdict = guard.measure(frame * kSecondNs / 100, std::vector{light});
  }
  return verdict;
}

FlashVerdict flash(double hz, TileLight dark, TileLight bright, double area = 1) {
  PhotosensitiveGuard guard(FlashLimits(), {area});
  return flash(guard, hz, dark, bright);
}

TEST_CASE("three flashes a second pass and four do not") {
  CHECK(flash(3, grey(0), grey(200)).flashes == 3);
  CHECK_FALSE(flash(3, grey(0), grey(200)).harmful);
  CHECK(flash(4, grey(0), grey(200)).flashes == 4);
  CHECK(flash(4, grey(0), grey(200)).harmful);
}

TEST_CASE("a change of less than 20 cd/m2 is not a flash, and one of 20 is") {
  CHECK(flash(10, grey(50), grey(69.9)).flashes == 0);
  CHECK(flash(10, grey(50), grey(70)).harmful);
}

TEST_CASE("flashes whose darker side is 160 cd/m2 or more do not count") {
  CHECK(flash(10, grey(160), grey(400)).flashes == 0);
  CHECK(flash(10, grey(159), grey(400)).harmful);
}

TEST_CASE("a quarter of the picture may flash, more may not") {
  CHECK_FALSE(flash(10, grey(0), grey(200), 0.25).harmful);
  CHECK(flash(10, grey(0), grey(200), 0.26).harmful);
}

TEST_CASE("saturated red counts at luminances that grey may have, and unsaturated red does not") {
  CHECK(flash(10, red(0), red(0.2)).red_flashes == 10);
  CHECK(flash(10, red(0), red(0.2)).flashes == 0);  // 8 cd/m2
  CHECK(flash(10, red(0), red(0.2)).harmful);
  CHECK(flash(10, red(0), red(0.05)).red_flashes == 0);  // 0.05 x 320 = 16
  CHECK(flash(10, grey(0), {8, 0.3, 0.1, 0.05}).red_flashes == 0);
}

TEST_CASE("a fade up and down is one flash however many frames it takes, and noise on it adds none") {
  PhotosensitiveGuard guard(FlashLimits(), {1});
  std::mt19937 random(1);
  FlashVerdict verdict;
  for (int frame = 0; frame < 90; ++frame) {
    const double level = 100 - 100 * std::cos(frame / 90.0 * 2 * 3.14159265358979);
    verdict =
        guard.measure(frame * kSecondNs / 100, std::vector{grey(level + static_cast<double>(random() % 100) / 10)});
  }
  CHECK(verdict.flashes == 1);
}

TEST_CASE("flashes expire after a second, and when time goes back") {
  PhotosensitiveGuard guard(FlashLimits(), {1});
  CHECK(flash(guard, 10, grey(0), grey(200)).harmful);
  CHECK(guard.measure(10 * kSecondNs, std::vector{grey(200)}).flashes <= 0.5);  // its own change
  CHECK(flash(guard, 10, grey(0), grey(200)).harmful);                          // from 0 s again
  CHECK_FALSE(guard.measure(0, std::vector{grey(200)}).harmful);
}

TEST_CASE("two flashes a second for more than 5 s are a long sequence, and end with the flashing") {
  PhotosensitiveGuard guard(FlashLimits(), {1});
  CHECK_FALSE(flash(guard, 2, grey(0), grey(200), 4.9).long_sequence);
  PhotosensitiveGuard longer(FlashLimits(), {1});
  const FlashVerdict verdict = flash(longer, 2, grey(0), grey(200), 7);
  CHECK(verdict.long_sequence);
  CHECK_FALSE(verdict.harmful);
  CHECK_FALSE(longer.measure(9 * kSecondNs, std::vector{grey(0)}).long_sequence);
}

TEST_CASE("flashes made by dimmers count like those of shutters") {
  // Eight fixtures of an eighth each; a chase of their dimmers at 8 steps a second lights each once a second.
  PhotosensitiveGuard guard(FlashLimits(), std::vector<double>(8, 0.125));
  FlashVerdict verdict;
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<TileLight> tiles(8, grey(0));
    tiles[static_cast<std::size_t>(frame / 12 % 8)] = grey(200);
    verdict = guard.measure(frame * kSecondNs / 100, tiles);
  }
  CHECK_FALSE(verdict.harmful);
  for (int frame = 200; frame < 400; ++frame)  // all together at 5 Hz, shutters open
    verdict = guard.measure(frame * kSecondNs / 100, std::vector<TileLight>(8, grey(frame / 10 % 2 * 200)));
  CHECK(verdict.harmful);
}

TEST_CASE("limited light passes the first flashes unchanged, then stays constant, and returns after a second") {
  PhotosensitiveGuard guard(FlashLimits(), {1});
  std::vector<double> gains;
  int passed = 0;
  for (int frame = 0; frame < 100; ++frame) {
    const bool bright = frame / 5 % 2 == 1;
    const FlashVerdict verdict = guard.limit(frame * kSecondNs / 100, std::vector{grey(bright ? 200 : 0)}, gains);
    CHECK_FALSE(verdict.harmful);
    passed += bright && gains[0] == 1 && frame % 5 == 0;
    if (gains[0] < 1) {
      CHECK(verdict.held_area == 1);
      CHECK(verdict.least_gain == gains[0]);
      CHECK(gains[0] * 200 < 20);
    }
  }
  CHECK(passed == 3);
  guard.limit(3 * kSecondNs, std::vector{grey(200)}, gains);
  CHECK(gains[0] == 1);
}

TEST_CASE("limited light is never harmful to another guard, and the limiter never adds light") {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    std::vector<double> areas;
    for (int i = 0; i < 12; ++i) areas.push_back(static_cast<double>(1 + random() % 20) / 120);
    PhotosensitiveGuard guard(FlashLimits(), areas);
    PhotosensitiveGuard judge(FlashLimits(), areas);
    std::vector<double> gains;
    std::vector<TileLight> tiles(areas.size());
    std::vector<unsigned> period(areas.size());
    for (unsigned& p : period) p = 1 + static_cast<unsigned>(random() % 60);
    const bool together = round % 3 == 0;
    bool held = false;
    for (int frame = 0; frame < 600; ++frame) {
      for (std::size_t i = 0; i < tiles.size(); ++i) {
        const unsigned slow = period[together ? 0 : i];
        if (static_cast<unsigned>(frame) % slow != 0) continue;
        const double level = static_cast<double>(random() % 1000) / 1000;
        tiles[i] = round % 2 == 0 ? grey(level * 400) : random() % 2 == 0 ? red(level) : grey(level * 150);
      }
      const std::int64_t now = frame * kSecondNs / 60;
      const FlashVerdict own = guard.limit(now, tiles, gains);
      std::vector<TileLight> shown = tiles;
      for (std::size_t i = 0; i < shown.size(); ++i) {
        REQUIRE(gains[i] >= 0);
        REQUIRE(gains[i] <= 1);
        shown[i] = {shown[i].luminance_cd_m2 * gains[i], shown[i].red * gains[i], shown[i].green * gains[i],
                    shown[i].blue * gains[i]};
      }
      held = held || own.held_area > 0;
      REQUIRE_FALSE(own.harmful);
      REQUIRE_FALSE(judge.measure(now, shown).harmful);
    }
    if (together && period[0] < 6) CHECK(held);
  }
}

TEST_CASE("light within the limits is not changed") {
  PhotosensitiveGuard guard(FlashLimits(), {0.5, 0.5});
  std::vector<double> gains;
  for (int frame = 0; frame < 600; ++frame) {
    guard.limit(frame * kSecondNs / 60, std::vector{grey(frame / 20 % 2 * 200), grey(30 + frame % 2 * 15)}, gains);
    CHECK(gains[0] == 1);
    CHECK(gains[1] == 1);
  }
}

TEST_CASE("NaN light and missing tiles are dark, and odd times do no harm") {
  PhotosensitiveGuard guard(FlashLimits(), {0.5, 0.5});
  std::vector<double> gains;
  const double odd[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, -1, 1e300, 0, 100};
  const std::int64_t times[] = {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(), 0,
                                -5};
  std::mt19937 random(2);
  for (int i = 0; i < 1000; ++i) {
    const auto any = [&] { return odd[random() % std::size(odd)]; };
    std::vector<TileLight> tiles(random() % 4, TileLight{any(), any(), any(), any()});
    const FlashVerdict verdict = guard.limit(times[random() % 4], tiles, gains);
    REQUIRE(gains.size() == 2);
    REQUIRE((gains[0] >= 0 && gains[0] <= 1 && gains[1] >= 0 && gains[1] <= 1));
    REQUIRE(std::isfinite(verdict.area));
  }
  PhotosensitiveGuard none(FlashLimits(), {});
  CHECK_FALSE(none.measure(0, {}).harmful);
}

}  // namespace
}  // namespace footlight
