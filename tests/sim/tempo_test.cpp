// Taps and the beats that they make, with times as numbers.
#include "sim/tempo.h"

#include <doctest/doctest.h>

#include <initializer_list>
#include <limits>
#include <string>

namespace footlight {
namespace {

constexpr TimeNs kMs = kNsPerMs;

double tapped(std::initializer_list<TimeNs> times_ms) {
  Tempo tempo;
  for (const TimeNs time_ms : times_ms) tempo.tap(time_ms * kMs);
  return tempo.beats_a_minute();
}

TEST_CASE("the tempo is the mean of the taps, whose errors between the first and the last one do not matter") {
  CHECK(tapped({}) == 120);
  CHECK(tapped({5'000}) == 120);  // one tap is no interval
  CHECK(tapped({5'000, 5'400}) == doctest::Approx(150));
  CHECK(tapped({5'000, 5'450, 5'800}) == doctest::Approx(150));
  CHECK(tapped({0, 600, 1'200, 1'800}) == doctest::Approx(100));
}

TEST_CASE("only the last eight taps count") {
  Tempo tempo;
  TimeNs now_ns = 0;
  for (int i = 0; i < 20; ++i) tempo.tap(now_ns += kNsPerS);
  CHECK(tempo.beats_a_minute() == doctest::Approx(60));
  for (int i = 0; i < 6; ++i) tempo.tap(now_ns += kNsPerS / 2);
  CHECK(tempo.beats_a_minute() < 119);  // one of the slow taps is still among them
  tempo.tap(now_ns += kNsPerS / 2);
  CHECK(tempo.beats_a_minute() == doctest::Approx(120));
}

TEST_CASE("a pause of more than two seconds begins anew, and keeps the tempo until the second tap after it") {
  CHECK(tapped({0, 2'000}) == doctest::Approx(30));
  CHECK(tapped({0, 400, 2'401}) == doctest::Approx(150));
  CHECK(tapped({0, 400, 2'401, 3'401}) == doctest::Approx(60));
}

TEST_CASE("a key that bounces is one tap") {
  CHECK(tapped({0, 30, 500, 520, 1'000}) == doctest::Approx(120));
  CHECK(tapped({0, 199, 200}) == doctest::Approx(300));
}

TEST_CASE("a beat begins with each tap from the second on, and none is counted back") {
  Tempo tempo;
  CHECK(tempo.at(1'250 * kMs) == TempoBeat{2, 0.5});
  tempo.tap(1'200 * kMs);
  CHECK(tempo.at(1'250 * kMs) == TempoBeat{2, 0.5});
  tempo.tap(1'600 * kMs);  // beat 3.2: the nearest one begins here
  CHECK(tempo.at(1'600 * kMs) == TempoBeat{3, 0});
  CHECK(tempo.at(1'800 * kMs) == TempoBeat{3, 0.5});
  CHECK(tempo.at(2'000 * kMs) == TempoBeat{4, 0});
  CHECK(tempo.at(1'200 * kMs) == TempoBeat{2, 0});
}

TEST_CASE("a tempo that is set moves no beat that has begun, and ends a row of taps") {
  Tempo tempo;
  tempo.tap(1'100 * kMs);
  REQUIRE(tempo.set(60, 1'250 * kMs));
  CHECK(tempo.beats_a_minute() == doctest::Approx(60));
  CHECK(tempo.at(1'250 * kMs) == TempoBeat{2, 0.5});
  CHECK(tempo.at(1'750 * kMs) == TempoBeat{3, 0});
  tempo.tap(1'800 * kMs);
  CHECK(tempo.beats_a_minute() == doctest::Approx(60));
}

TEST_CASE("a tempo outside of its range is refused and changes nothing") {
  Tempo tempo;
  for (const double wrong : {0.0, 29.9, 300.1, -120.0, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    const Status set = tempo.set(wrong, 0);
    REQUIRE(!set);
    CHECK(set.error().message.find("30 to 300") != std::string::npos);
  }
  CHECK(tempo.beats_a_minute() == 120);
  CHECK(tempo.set(30, 0).has_value());
  CHECK(tempo.set(300, 0).has_value());
}

TEST_CASE("after a year of beats the next one is exact to the nanosecond") {
  Tempo tempo;
  REQUIRE(tempo.set(128, 0));
  const DurationNs beat_ns = 468'750'000;
  const std::int64_t count = 365LL * 24 * 3'600 * kNsPerS / beat_ns;
  CHECK(tempo.at(count * beat_ns - 1).count == count - 1);
  CHECK(tempo.at(count * beat_ns) == TempoBeat{count, 0});
}

}  // namespace
}  // namespace footlight
