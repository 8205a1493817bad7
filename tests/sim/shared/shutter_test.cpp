// Shutters: the exposure integral of every kind.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "tests/sim/shared/cut.h"

namespace footlight {
namespace {

template <class T>
typename T::ShutterParams decoded_of(std::uint32_t kind, double rate_hz, double duty = 0.5) {
  typename T::ShutterParams params{};
  params.kind = kind;
  params.rate_hz = static_cast<typename T::Real>(rate_hz);
  params.duty = static_cast<typename T::Real>(duty);
  params.seed = 17;
  return params;
}

template <class T>
typename T::Shutter shutter_start() {
  if constexpr (std::is_same_v<T, Float>)
    return f32::shutter_begin();
  else
    return f64::shutter_begin();
}

// The mean of a kind over whole periods.
double true_mean(std::uint32_t kind, double duty) {
  if (kind == f64::kShutterClosed) return 0;
  if (kind == f64::kShutterOpen) return 1;
  if (kind == f64::kShutterStrobe || kind == f64::kShutterRandom) return duty;
  if (kind == f64::kShutterEffect) return duty / 2;  // four flashes, then a pause of the same length
  return duty / 2;                                   // ramps
}

TEST_CASE_TEMPLATE("over 10 s the mean of every kind is its duty to 1e-6, from 0.1 Hz to 1 kHz at any frame rate", T,
                   Float, Double) {
  double worst = 0;
  for (std::uint32_t kind = 0; kind < f64::kShutterKindCount; ++kind) {
    for (const double rate : {0.1, 0.7, 3.0, 24.0, 25.0, 30.0, 59.9, 60.0, 120.0, 1000.0}) {
      for (const std::int64_t frames_mHz : {15'000, 24'000, 30'000, 44'000, 60'000, 240'000}) {
        const auto params = decoded_of<T>(kind, rate, 0.3);
        auto shutter = shutter_start<T>();
        double light = 0;
        std::int64_t now = 0;
        for (std::int64_t frame = 1; now < 10 * kSecondNs; ++frame) {
          const std::int64_t next = std::min(frame * 1000 * kSecondNs / frames_mHz, 10 * kSecondNs);
          const double mean =
              static_cast<double>(shutter_step(shutter, params, words(static_cast<std::uint64_t>(next - now))));
          REQUIRE(mean >= 0);
          REQUIRE(mean <= 1);
          light += mean * static_cast<double>(next - now);
          now = next;
        }
        worst = std::max(worst, std::abs(light / (10.0 * kSecondNs) - true_mean(kind, 0.3)));
      }
    }
  }
  MESSAGE("largest difference: ", worst);
  CHECK(worst < 1e-6);
}

// All kinds in turn, with changing rates and duties.
template <class T>
struct Flasher {
  typename T::Shutter shutter = shutter_start<T>();
  double travel_s = 0;
  double light = 0;  // s
  double low = 0;
  void step(std::uint32_t change, glm::uvec2 dt_ns) {
    auto params = decoded_of<T>(f64::hash_two(3, change / 40) % f64::kShutterKindCount,
                                25 * chance(4, change / 15) * chance(5, change / 15), chance(6, change / 11));
    params.travel_s = static_cast<typename T::Real>(travel_s);
    params.offset = static_cast<typename T::Real>(0.25);
    params.low = static_cast<typename T::Real>(low);
    light += static_cast<double>(shutter_step(shutter, params, dt_ns)) * static_cast<double>(number(dt_ns)) * 1e-9;
  }
  [[nodiscard]] double value() const { return light; }
};

TEST_CASE_TEMPLATE("15 to 1000 frames a second have the same light over 60 s of demanding shutter changes", T, Float,
                   Double) {
  CHECK(rate_spread(Flasher<T>{}) <= (std::is_same_v<T, Float> ? 60e-6 / 10 : 1e-9));
  Flasher<T> blades;
  blades.travel_s = 0.012;
  blades.low = 0.05;
  CHECK(rate_spread(blades) <= (std::is_same_v<T, Float> ? 60e-6 / 10 : 1e-9));
}

TEST_CASE_TEMPLATE("an exposure of a + b has the light of its parts, for random kinds and up to 60 s each", T, Float,
                   Double) {
  std::mt19937_64 random(21);
  double worst = 0;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    auto params =
        decoded_of<T>(static_cast<std::uint32_t>(random() % f64::kShutterKindCount), 60 * chance(1, i), chance(2, i));
    params.travel_s = static_cast<typename T::Real>(i % 2 == 0 ? 0 : 0.03 * chance(3, i));
    auto whole = shutter_start<T>();
    shutter_step(whole, decoded_of<T>(f64::kShutterStrobe, 3), words(random() % kSecondNs));
    auto pieces = whole;
    const auto a = static_cast<std::uint64_t>(random_ns(random));
    const auto b = static_cast<std::uint64_t>(random_ns(random));
    const double both = static_cast<double>(shutter_step(whole, params, words(a + b)));
    const double first = static_cast<double>(shutter_step(pieces, params, words(a)));
    const double second = static_cast<double>(shutter_step(pieces, params, words(b)));
    if (a + b == 0) continue;
    const double share = static_cast<double>(a) / static_cast<double>(a + b);
    worst = std::max(worst, std::abs(both - (first * share + second * (1 - share))));
    CHECK(std::abs(static_cast<double>(whole.level - pieces.level)) <= 1e-4);
  }
  MESSAGE("largest difference: ", worst);
  CHECK(worst <= (std::is_same_v<T, Float> ? 1e-6 : 1e-12));
}

// A reference without integrals: blades that follow their command over a grid of instants.
double by_instants(double rate, double duty, double travel_s, double low, double from_s, double to_s) {
  constexpr double kStepS = 1e-6;
  double level = low;
  double light = 0;
  int count = 0;
  for (double t = kStepS / 2; t < to_s; t += kStepS) {
    const double place = t * rate - std::floor(t * rate);
    const double way = travel_s > 0 ? (1 - low) * kStepS / travel_s : 1;
    level = place < duty ? std::min(level + way, 1.0) : std::max(level - way, low);
    if (t >= from_s) {
      light += level;
      ++count;
    }
  }
  return light / count;
}

TEST_CASE("blades with a travel time pass the same light as a simulation in microseconds") {
  struct Row {
    double rate, duty, travel_s, low;
  };
  for (const Row& row : {Row{5, 0.5, 0.01, 0}, Row{10, 0.2, 0.05, 0}, Row{10, 0.8, 0.05, 0}, Row{20, 0.5, 0.2, 0},
                         Row{5, 0.3, 0.02, 0.25}, Row{10, 0.9, 0.03, 0.1}}) {
    CAPTURE(row.rate);
    CAPTURE(row.travel_s);
    auto params = decoded_of<Double>(f64::kShutterStrobe, row.rate, row.duty);
    params.travel_s = row.travel_s;
    params.low = row.low;
    f64::Shutter shutter = f64::shutter_begin();
    shutter_step(shutter, params, f64::time_ns(2));
    CHECK(shutter_step(shutter, params, f64::time_ns(0.137)) ==
          doctest::Approx(by_instants(row.rate, row.duty, row.travel_s, row.low, 2, 2.137)).epsilon(2e-3));
  }
}

TEST_CASE("a pulse is a triangle, an opening pulse rises, a closing one falls") {
  const auto level = [](std::uint32_t kind, double place) {
    f64::Shutter shutter = f64::shutter_begin();
    const auto params = decoded_of<Double>(kind, 1, 0.5);
    shutter_step(shutter, params, f64::time_ns(place));
    return shutter_step(shutter, params, words(0));
  };
  CHECK(level(f64::kShutterPulse, 0.125) == doctest::Approx(0.5));
  CHECK(level(f64::kShutterPulse, 0.25) == doctest::Approx(1.0));
  CHECK(level(f64::kShutterPulse, 0.375) == doctest::Approx(0.5));
  CHECK(level(f64::kShutterPulseOpen, 0.125) == doctest::Approx(0.25));
  CHECK(level(f64::kShutterPulseOpen, 0.499) == doctest::Approx(0.998));
  CHECK(level(f64::kShutterPulseClose, 0.125) == doctest::Approx(0.75));
  CHECK(level(f64::kShutterPulseClose, 0.001) == doctest::Approx(0.998));
  for (const std::uint32_t kind :
       {f64::kShutterPulse, f64::kShutterPulseOpen, f64::kShutterPulseClose, f64::kShutterStrobe})
    CHECK(level(kind, 0.75) == 0);
}

TEST_CASE("random flashes are one per period, at different places, and equal on replay for any division of time") {
  const auto params = decoded_of<Double>(f64::kShutterRandom, 10, 0.1);
  f64::Shutter shutter = f64::shutter_begin();
  std::vector<int> places;
  int flashes = 0;
  double before = 0;
  for (int i = 0; i < 100'000; ++i) {  // 100 s in ms
    const double mean = shutter_step(shutter, params, words(1'000'000));
    if (mean > 0 && before == 0) {
      ++flashes;
      places.push_back(i % 100);
    }
    before = mean;
  }
  CHECK(flashes == doctest::Approx(1000).epsilon(0.02));  // neighbours may touch
  int early = 0;
  for (const int place : places) early += place < 45;
  CHECK(early == doctest::Approx(flashes / 2.0).epsilon(0.15));
  f64::Shutter again = f64::shutter_begin();
  shutter_step(again, params, words(100'000'000'000));
  // Both have reached the edge of period 1000, to 2^-64 turn per step.
  CHECK(std::abs(f64::turns_way(again.phase, shutter.phase)) < 1e-13);
  double same = 0;
  for (int i = 0; i < 2000; ++i) {
    const double mean = shutter_step(again, params, words(7'000'000));
    same = std::max(same, std::abs(mean - shutter_step(shutter, params, words(7'000'000))));
  }
  CHECK(same < 1e-9);
  auto other = params;
  other.seed = 18;
  int differ = 0;
  f64::Shutter a = f64::shutter_begin(), b = f64::shutter_begin();
  for (int i = 0; i < 1000; ++i)
    differ += shutter_step(a, params, words(10'000'000)) != shutter_step(b, other, words(10'000'000));
  CHECK(differ > 100);
}

TEST_CASE("the time offset puts the flash later in its period, per fixture") {
  auto params = decoded_of<Double>(f64::kShutterStrobe, 1, 0.25);
  params.offset = 0.5;
  f64::Shutter shutter = f64::shutter_begin();
  CHECK(shutter_step(shutter, params, f64::time_ns(0.5)) == doctest::Approx(0));
  CHECK(shutter_step(shutter, params, f64::time_ns(0.25)) == doctest::Approx(1));
  CHECK(shutter_step(shutter, params, f64::time_ns(0.25)) == doctest::Approx(0));
}

TEST_CASE("a duration in seconds is constant when the rate changes") {
  for (const double rate : {1.0, 4.0, 10.0}) {
    auto params = decoded_of<Double>(f64::kShutterStrobe, rate);
    params.duration_s = 0.02;
    f64::Shutter shutter = f64::shutter_begin();
    CHECK(shutter_step(shutter, params, f64::time_ns(1)) == doctest::Approx(0.02 * rate));
  }
}

TEST_CASE("a 30 Hz strobe has the same mean at 24, 30 and 60 fps and over 44 Hz DMX, without beats at 30") {
  for (const std::int64_t fps : {24, 30, 60, 44}) {
    f64::Shutter shutter = f64::shutter_begin();
    const auto params = decoded_of<Double>(f64::kShutterStrobe, 30, 0.5);
    double least = 1, most = 0, sum = 0;
    for (std::int64_t frame = 0; frame < 10 * fps; ++frame) {
      const std::int64_t dt = (frame + 1) * kSecondNs / fps - frame * kSecondNs / fps;
      const double mean = shutter_step(shutter, params, words(static_cast<std::uint64_t>(dt)));
      least = std::min(least, mean);
      most = std::max(most, mean);
      sum += mean;
    }
    CHECK(sum / static_cast<double>(10 * fps) == doctest::Approx(0.5).epsilon(1e-6));
    if (fps == 30) CHECK(most - least < 1e-6);  // sampling at instants: all frames lit or all dark
  }
}

TEST_CASE("the phase of a strobe does not leak at 20 fps, where the old accumulator went dark for ever") {
  // phase += dt * rate with one subtraction of a turn: 185 rad/s at 20 fps gains more than a turn per frame.
  double leaking = 0;
  for (int i = 0; i < 400'000; ++i) {
    leaking += 185.0 / 20;
    if (leaking >= 2 * 3.14159265358979) leaking -= 2 * 3.14159265358979;
    leaking = std::min(leaking, 1e6);
  }
  CHECK(leaking == 1e6);
  f64::Shutter shutter = f64::shutter_begin();
  const auto params = decoded_of<Double>(f64::kShutterStrobe, 185 / (2 * 3.14159265358979), 0.5);
  shutter_step(shutter, params, f64::time_ns(4.7 * 3600));
  double light = 0;
  for (int i = 0; i < 400; ++i) light += shutter_step(shutter, params, words(50'000'000)) / 400;
  CHECK(light == doctest::Approx(0.5).epsilon(1e-3));
}

TEST_CASE("a flash is at its correct time after 30 days, when float seconds are a quarter of a second apart") {
  const auto params = decoded_of<Float>(f32::kShutterStrobe, 25, 0.5);
  f32::Shutter shutter = f32::shutter_begin();
  shutter_step(shutter, params, f32::time_ns(30.0f * 86'400));
  CHECK(shutter_step(shutter, params, words(20'000'000)) == doctest::Approx(1).epsilon(1e-5));
  CHECK(shutter_step(shutter, params, words(20'000'000)) == doctest::Approx(0).epsilon(1e-5));
  CHECK(30.0f * 86'400 + 0.02f == 30.0f * 86'400);
}

TEST_CASE("each fixture's strobe follows its own channel, independent of its neighbours") {
  f32::Shutter a = f32::shutter_begin(), b = f32::shutter_begin();
  shutter_step(a, decoded_of<Float>(f32::kShutterOpen, 0), words(1'000'000));
  CHECK(shutter_step(b, decoded_of<Float>(f32::kShutterStrobe, 10, 0.5), words(100'000'000)) == doctest::Approx(0.5));
  CHECK(shutter_step(a, decoded_of<Float>(f32::kShutterOpen, 0), words(100'000'000)) == 1);
}

TEST_CASE("a change of rate continues from the current phase") {
  f64::Shutter shutter = f64::shutter_begin();
  shutter_step(shutter, decoded_of<Double>(f64::kShutterStrobe, 4), f64::time_ns(0.1));
  const glm::uvec2 before = shutter.phase;
  shutter_step(shutter, decoded_of<Double>(f64::kShutterStrobe, 7), words(0));
  CHECK(shutter.phase == before);
}

TEST_CASE("blades take their travel time also in an effect, whose flashes are eight times as fast as its period") {
  f64::ShutterParams params{};
  params.kind = f64::kShutterEffect;
  params.rate_hz = 2;
  params.duty = 0.5;
  params.travel_s = 0.01;
  f64::Shutter shutter = f64::shutter_begin();
  shutter_step(shutter, params, words(5'000'000));
  CHECK(shutter_step(shutter, params, words(0)) == doctest::Approx(0.5));  // half way up
  shutter_step(shutter, params, words(5'000'001));
  CHECK(shutter_step(shutter, params, words(0)) == 1);
}

TEST_CASE("blades open and close in their travel time, from their current level") {
  auto open = decoded_of<Double>(f64::kShutterOpen, 0), closed = decoded_of<Double>(f64::kShutterClosed, 0);
  open.travel_s = closed.travel_s = 0.02;
  f64::Shutter shutter = f64::shutter_begin();
  CHECK(shutter_step(shutter, closed, words(0)) == 0);
  CHECK(shutter_step(shutter, open, f64::time_ns(0.01)) == doctest::Approx(0.25));
  CHECK(shutter.level == doctest::Approx(0.5));
  CHECK(shutter_step(shutter, closed, f64::time_ns(0.005)) == doctest::Approx(0.375));
  CHECK(shutter_step(shutter, open, f64::time_ns(0.03)) == doctest::Approx((0.015 * 0.625 + 0.015) / 0.03));
  CHECK(shutter.level == 1);
}

TEST_CASE_TEMPLATE("no time is the current state, and odd parameters give light between 0 and 1", T, Float, Double) {
  using Real = typename T::Real;
  auto shutter = shutter_start<T>();
  const auto params = decoded_of<T>(f64::kShutterStrobe, 1, 0.5);
  CHECK(shutter_step(shutter, params, words(0)) == 1);
  shutter_step(shutter, params, words(700'000'000));
  const auto before = shutter;
  CHECK(shutter_step(shutter, params, words(0)) == 0);
  CHECK(shutter.phase == before.phase);
  CHECK(shutter_step(shutter, params, words(1'000'000'000'000'000'000)) == doctest::Approx(0.5).epsilon(1e-6));
  std::mt19937_64 random(31);
  const double odd[] = {0, 1, -1, 0.5, 1e-30, 1e30, 1e-7, 1e6, 1e7, 2, std::nan(""), HUGE_VAL, -HUGE_VAL};
  const auto any = [&] { return static_cast<Real>(odd[random() % std::size(odd)]); };
  int bad = 0;
  for (int i = 0, trials = hunt_trials(); i < trials; ++i) {
    auto wild = decoded_of<T>(static_cast<std::uint32_t>(random() % 14), 1);
    wild.rate_hz = any();
    wild.duty = any();
    wild.duration_s = any();
    wild.offset = any();
    wild.low = any();
    wild.travel_s = any();
    const auto mean = shutter_step(shutter, wild, words(random() >> (random() % 64)));
    bad += !(mean >= 0 && mean <= 1) || !(shutter.level >= 0 && shutter.level <= 1);
  }
  CHECK(bad == 0);
}

TEST_CASE("blades faster than the resolution of their phase stay between closed and open") {
  f32::ShutterParams params = decoded_of<Float>(f32::kShutterStrobe, 1, 0.5);
  params.travel_s = 1e-7f;
  params.offset = 0.5f;
  params.low = 0.5f;
  f32::Shutter shutter = f32::shutter_begin();
  shutter_step(shutter, params, words(1));
  CHECK(shutter.level <= 1);
  CHECK(shutter.level >= 0.5f);
}

}  // namespace
}  // namespace footlight
