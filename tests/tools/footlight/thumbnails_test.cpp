// Small pictures of a log: their order, which one a time has, and which is made next.
#include "tools/footlight/preview/ui/thumbnails.h"

#include <algorithm>
#include <set>
#include <vector>

#include <doctest/doctest.h>

namespace footlight::tools {
namespace {

std::vector<std::uint8_t> grey(std::uint8_t level) {
  return std::vector<std::uint8_t>(std::size_t{4} * Thumbnails::kWidth * Thumbnails::kHeight, level);
}

TEST_CASE("small pictures are kept by time, and one at the same time replaces the other") {
  Thumbnails thumbnails;
  for (const TimeNs at_s : {5, 1, 3}) thumbnails.add(at_s * kNsPerS, grey(static_cast<std::uint8_t>(at_s)));
  thumbnails.add(3 * kNsPerS, grey(200));
  REQUIRE(thumbnails.all().size() == 3);
  CHECK(thumbnails.all()[0].at_ns == kNsPerS);
  CHECK(thumbnails.all()[2].at_ns == 5 * kNsPerS);
  CHECK(thumbnails.all()[1].pixels.front() == 0xffc8c8c8u);
  CHECK(thumbnails.nearest(3900 * kNsPerMs, kNsPerS)->at_ns == 3 * kNsPerS);
  CHECK(thumbnails.nearest(4100 * kNsPerMs, kNsPerS)->at_ns == 5 * kNsPerS);
  CHECK(thumbnails.nearest(8 * kNsPerS, kNsPerS) == nullptr);
}

TEST_CASE("the smaller size of a picture has the means of four pixels, channel by channel") {
  Thumbnails thumbnails;
  std::vector<std::uint8_t> rgba = grey(0);
  const auto set = [&](std::size_t x, std::size_t y, std::uint8_t red, std::uint8_t blue) {
    rgba[4 * (y * Thumbnails::kWidth + x)] = red;
    rgba[4 * (y * Thumbnails::kWidth + x) + 2] = blue;
  };
  set(2, 4, 255, 0);
  set(3, 4, 255, 8);
  set(3, 5, 0, 8);
  thumbnails.add(0, rgba);
  const auto& half = thumbnails.all().front().half;
  REQUIRE(half.size() == std::size_t{Thumbnails::kWidth / 2} * (Thumbnails::kHeight / 2));
  CHECK(half[2 * Thumbnails::kWidth / 2 + 1] == 0xff040080u);
  CHECK(half[0] == 0xff000000u);
}

TEST_CASE("the next pictures are spread over the log, and each part gets one when it is known") {
  Thumbnails thumbnails;
  constexpr DurationNs kLog = 64 * kNsPerS;
  CHECK(thumbnails.next(kLog, 0) == 0);
  std::vector<TimeNs> times;
  while (const auto next = thumbnails.next(kLog, kLog)) {
    times.push_back(*next);
    thumbnails.pass_over(*next);
  }
  CHECK(times.size() == Thumbnails::kCountMax);
  CHECK(std::set(times.begin(), times.end()).size() == times.size());
  CHECK(std::vector(times.begin(), times.begin() + 4) ==
        std::vector<TimeNs>{0, 32 * kNsPerS, 16 * kNsPerS, 48 * kNsPerS});
  Thumbnails part;
  while (const auto next = part.next(kLog, 10 * kNsPerS)) {
    CHECK(*next <= 10 * kNsPerS);
    part.pass_over(*next);
  }
  CHECK(part.next(kLog, 11 * kNsPerS) == 11 * kNsPerS);
  CHECK(Thumbnails().next(0, 0) == 0);  // an empty log has one
}

}  // namespace
}  // namespace footlight::tools
