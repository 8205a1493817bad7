#include "sim/pattern.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

namespace footlight {
namespace {

struct Taker final : FrameReceiver {
  void receive(const FrameView& frame) override {
    levels[frame.universe].assign(frame.slots.begin(), frame.slots.end());
    priority = frame.priority;
    ++frames;
  }
  std::map<Universe, std::vector<std::uint8_t>> levels;
  int priority = -1;
  int frames = 0;
};

TEST_CASE("a chase lights every fourth slot, and the next one after half a second") {
  PatternSource source("mock:chase", Pattern::kChase, every_slot({1, 3}));
  Taker taker;
  for (const int step : {0, 1, 2, 3, 4, 5}) {
    INFO(step);
    REQUIRE(source.poll(step * kChaseStepNs + 20 * kNsPerMs, taker));
    for (const auto& [universe, levels] : taker.levels) {
      REQUIRE(levels.size() == 512);
      for (int slot = 0; slot < 512; ++slot) {
        CHECK(levels[static_cast<std::size_t>(slot)] == (slot % 4 == step % 4 ? 255 : 0));
      }
    }
  }
  CHECK(taker.levels.size() == 2);
  CHECK(taker.levels.count(3) == 1);
  CHECK(taker.priority == 0);  // every console wins
}

TEST_CASE("a sine takes each voice from its dark to its lit level and back in four seconds") {
  CHECK(pattern_light(Pattern::kSine, 0, 4, Tempo().at(0)) == doctest::Approx(0));
  CHECK(pattern_light(Pattern::kSine, 0, 4, Tempo().at(kSineNs / 2)) == doctest::Approx(1));
  CHECK(pattern_light(Pattern::kSine, 0, 4, Tempo().at(kSineNs)) == doctest::Approx(0));
  CHECK(pattern_light(Pattern::kSine, 2, 4, Tempo().at(0)) == doctest::Approx(1));  // the other end of the wave
  CHECK(pattern_light(Pattern::kSine, 0, 0, Tempo().at(kSineNs / 4)) == doctest::Approx(0.5));
  PatternPlan plan;
  plan.universes = {7};
  plan.levels.assign(512, 9);
  plan.voices = {{{.index = 3, .dark = 200, .lit = 20}, {.index = 4}}};
  PatternSource source("mock:sine", Pattern::kSine, plan);
  Taker taker;
  REQUIRE(source.poll(0, taker));
  CHECK(taker.levels[7][3] == 200);
  CHECK(taker.levels[7][4] == 0);
  CHECK(taker.levels[7][5] == 9);
  REQUIRE(source.poll(kSineNs / 2, taker));
  CHECK(taker.levels[7][3] == 20);
  CHECK(taker.levels[7][4] == 255);
  plan.voices.clear();
  source.play(plan);
  REQUIRE(source.poll(kSineNs, taker));
  CHECK(taker.levels[7][3] == 9);
}

TEST_CASE("a pattern sends 40 frames a second, and none for time that was lost") {
  PatternSource source("mock:full", Pattern::kFull, every_slot({1}));
  Taker taker;
  for (TimeNs now_ns = 0; now_ns < kNsPerS; now_ns += kNsPerMs) REQUIRE(source.poll(now_ns, taker));
  CHECK(taker.frames == 40);
  CHECK(source.counters().frames == 40);
  CHECK(taker.levels[1] == std::vector<std::uint8_t>(512, 255));
  REQUIRE(source.poll(10 * kNsPerS + 7, taker));
  CHECK(taker.frames == 41);
  CHECK(source.next_deadline_ns() == 10 * kNsPerS + 25 * kNsPerMs);
}

TEST_CASE("a word that is no pattern is refused with those that are") {
  for (const std::string_view word : kPatternWords) CHECK(is_pattern(word));
  const auto wrong = pattern_of("rainbow");
  REQUIRE(!wrong);
  CHECK(wrong.error().message.find("rainbow") != std::string::npos);
  CHECK(wrong.error().message.find("chase, full or sine") != std::string::npos);
}

TEST_CASE("a chase follows the tempo that is tapped while it plays, and a light never goes back") {
  const auto tempo = std::make_shared<Tempo>();
  PatternSource source("mock:chase", Pattern::kChase, every_slot({1}), tempo);
  Taker taker;
  const auto lit = [&](TimeNs now_ns) {
    REQUIRE(source.poll(now_ns, taker));
    const auto& levels = taker.levels[1];
    return static_cast<int>(std::find(levels.begin(), levels.end(), 255) - levels.begin());
  };
  CHECK(lit(0) == 0);
  CHECK(lit(600 * kNsPerMs) == 1);
  tempo->tap(kNsPerS);
  CHECK(lit(1'100 * kNsPerMs) == 2);
  tempo->tap(1'400 * kNsPerMs);  // 150 a minute, and a beat begins here: beat 2.8 becomes 3
  CHECK(lit(1'425 * kNsPerMs) == 3);
  CHECK(lit(1'775 * kNsPerMs) == 3);
  CHECK(lit(1'800 * kNsPerMs) == 0);
  CHECK(lit(2'200 * kNsPerMs) == 1);
}

}  // namespace
}  // namespace footlight
