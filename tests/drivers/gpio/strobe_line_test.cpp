// One line: the slot value after edges at certain times. Times are in milliseconds from an origin.
#include "drivers/gpio/strobe_line.h"

#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace footlight::drivers {
namespace {

constexpr TimeNs kOriginNs = 1'000'000 * kNsPerMs;

TimeNs at(double ms) { return kOriginNs + static_cast<TimeNs>(ms * static_cast<double>(kNsPerMs)); }

StrobeConfig uncapped(StrobeMode mode) {
  StrobeConfig config;
  config.mode = mode;
  config.hold_ns = 0;
  config.flashes_hz_max = 0.0;
  return config;
}

StrobeLine started(StrobeConfig config, bool level = false) {
  StrobeLine line(std::move(config));
  line.start(level, kOriginNs);
  return line;
}

// The value at that time, after everything due was handled.
int value_at(StrobeLine& line, double ms) {
  line.advance(at(ms));
  return line.value();
}

TEST_SUITE_BEGIN("strobe line");

TEST_CASE("follow shows the level at the start, and every edge at its own time") {
  CHECK(started(uncapped(StrobeMode::kFollow), true).value() == 255);
  StrobeLine line = started(uncapped(StrobeMode::kFollow));
  CHECK(line.value() == 0);
  line.edge(true, at(3));
  CHECK(line.value() == 255);
  CHECK(line.changed_ns() == at(3));
  line.edge(false, at(4));
  CHECK(line.value() == 0);
  CHECK(line.changed_ns() == at(4));
  CHECK(line.next_deadline_ns() == kTimeNever);
}

TEST_CASE("the level at the start affects only follow") {
  for (const StrobeMode mode : {StrobeMode::kOneShot, StrobeMode::kToggle, StrobeMode::kRate}) {
    StrobeLine line = started(uncapped(mode), true);
    CHECK(line.value() == 0);
    line.edge(false, at(5));
    CHECK(line.value() == 0);
  }
}

TEST_CASE("on and off may be any two values, on below off too") {
  StrobeConfig config = uncapped(StrobeMode::kFollow);
  config.on = 10;
  config.off = 200;
  StrobeLine line = started(config);
  CHECK(line.value() == 200);
  line.edge(true, at(1));
  CHECK(line.value() == 10);
  line.stop(at(2));
  CHECK(line.value() == 200);
}

TEST_CASE("a pulse shorter than the hold is stretched to it, a longer one is not") {
  StrobeConfig config = uncapped(StrobeMode::kFollow);
  config.hold_ns = 25 * kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(1));
  CHECK(value_at(line, 24.9) == 255);
  CHECK(line.next_deadline_ns() == at(25));
  CHECK(value_at(line, 25) == 0);
  CHECK(line.changed_ns() == at(25));
  line.edge(true, at(100));
  line.edge(false, at(140));
  CHECK(line.value() == 0);
}

TEST_CASE("a second press within the stretched pulse keeps it on") {
  StrobeConfig config = uncapped(StrobeMode::kFollow);
  config.hold_ns = 25 * kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(1));
  line.edge(true, at(10));
  CHECK(value_at(line, 60) == 255);
  line.edge(false, at(60));
  CHECK(line.value() == 0);
  CHECK(line.counters().flashes == 1);
}

TEST_CASE("one-shot holds from the rising edge, whatever the line does after it") {
  StrobeConfig config = uncapped(StrobeMode::kOneShot);
  config.hold_ns = 80 * kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  CHECK(line.value() == 255);
  CHECK(line.next_deadline_ns() == at(80));
  line.edge(false, at(5));
  CHECK(value_at(line, 79.9) == 255);
  CHECK(value_at(line, 80) == 0);
  CHECK(value_at(line, 500) == 0);
}

TEST_CASE("a trigger during the hold extends it, or does nothing, as configured") {
  for (const Retrigger retrigger : {Retrigger::kExtend, Retrigger::kIgnore}) {
    StrobeConfig config = uncapped(StrobeMode::kOneShot);
    config.hold_ns = 80 * kNsPerMs;
    config.retrigger = retrigger;
    StrobeLine line = started(config);
    line.edge(true, at(0));
    line.edge(false, at(20));
    line.edge(true, at(50));
    CHECK(value_at(line, 100) == (retrigger == Retrigger::kExtend ? 255 : 0));
    CHECK(value_at(line, 130) == 0);
    line.edge(false, at(140));
    line.edge(true, at(150));
    CHECK(line.value() == 255);
  }
}

TEST_CASE("toggle changes with each rising edge and with nothing else") {
  StrobeLine line = started(uncapped(StrobeMode::kToggle));
  const int expected[] = {255, 0, 255, 0};
  double ms = 0;
  for (const int value : expected) {
    line.edge(true, at(ms += 300));
    CHECK(line.value() == value);
    line.edge(false, at(ms += 100));
    CHECK(line.value() == value);
  }
  CHECK(line.next_deadline_ns() == kTimeNever);
}

TEST_CASE("rate maps the time between rising edges through the table") {
  struct Row {
    double hz;
    int value;
  };
  // Between 2 Hz = 10 and 12 Hz = 110: ten per hertz.
  const Row rows[] = {{1.5, 10}, {2.0, 10}, {4.0, 30}, {8.0, 70}, {12.0, 110}, {20.0, 210}, {50.0, 210}};
  for (const Row& row : rows) {
    CAPTURE(row.hz);
    StrobeConfig config = uncapped(StrobeMode::kRate);
    config.rate_points = {{2.0, 10}, {12.0, 110}, {20.0, 210}};
    StrobeLine line = started(config);
    line.edge(true, at(0));
    CHECK(line.value() == 0);  // one edge has no rate
    line.edge(false, at(10));
    line.edge(true, at(1000.0 / row.hz));
    CHECK(line.value() >= row.value - 1);
    CHECK(line.value() <= row.value);
  }
}

TEST_CASE("rate ends two periods after the last edge, and starts again with the second edge after that") {
  StrobeConfig config = uncapped(StrobeMode::kRate);
  config.rate_points = {{1.0, 1}, {25.0, 255}};
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(50));
  line.edge(true, at(100));
  CHECK(line.value() == 96);  // 10 Hz
  CHECK(value_at(line, 299) == 96);
  CHECK(value_at(line, 300) == 0);
  CHECK(line.changed_ns() == at(300));
  line.edge(false, at(350));
  line.edge(true, at(5000));
  CHECK(line.value() == 0);  // 0.2 Hz is slower than half of the slowest
  line.edge(false, at(5050));
  line.edge(true, at(5100));
  CHECK(line.value() == 96);
}

TEST_CASE("debounce accepts the leading edge at once and ignores the edges in its window") {
  StrobeConfig config = uncapped(StrobeMode::kFollow);
  config.debounce_ns = 5 * kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  CHECK(line.value() == 255);
  CHECK(line.changed_ns() == at(0));
  for (const double ms : {0.5, 1.5, 2.5}) {
    line.edge(false, at(ms));
    CHECK(line.value() == 255);
    line.edge(true, at(ms + 0.5));
  }
  CHECK(line.needs_level(at(4.9)) == false);
  CHECK(line.needs_level(at(5)));
  CHECK(value_at(line, 5) == 255);
  CHECK(line.next_deadline_ns() == kTimeNever);
  CHECK(line.counters().bounces == 6);
  CHECK(line.counters().flashes == 1);
  line.edge(false, at(50));  // the release bounces, too
  CHECK(line.value() == 0);
  line.edge(true, at(50.3));
  line.edge(false, at(50.6));
  CHECK(value_at(line, 60) == 0);
  CHECK(line.counters().flashes == 1);
}

TEST_CASE("a release within the window of its press counts when the window ends, and opens its own window") {
  StrobeConfig config = uncapped(StrobeMode::kFollow);
  config.debounce_ns = 5 * kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(3));
  CHECK(value_at(line, 4.9) == 255);
  CHECK(value_at(line, 5) == 0);
  CHECK(line.changed_ns() == at(5));
  line.edge(true, at(7));
  CHECK(line.value() == 0);
  CHECK(value_at(line, 10) == 255);
}

TEST_CASE("edges that are read late have the same effect as edges read in time") {
  StrobeConfig config = uncapped(StrobeMode::kOneShot);
  config.hold_ns = 30 * kNsPerMs;
  config.debounce_ns = 5 * kNsPerMs;
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    StrobeLine prompt = started(config);
    StrobeLine late = started(config);
    std::vector<double> times;
    double ms = 0;
    for (int i = 0; i < 20; ++i) times.push_back(ms += std::uniform_real_distribution<>(0.1, 40.0)(random));
    bool level = false;
    for (const double time : times) {
      level = !level;
      for (double step = 0; step < 1; step += 0.25) prompt.advance(at(time - 0.01));
      prompt.edge(level, at(time));
    }
    level = false;
    for (const double time : times) late.edge(level = !level, at(time));
    prompt.advance(at(ms + 100));
    late.advance(at(ms + 100));
    CHECK(prompt.counters().flashes == late.counters().flashes);
    CHECK(prompt.changed_ns() == late.changed_ns());
    CHECK(prompt.value() == late.value());
  }
}

TEST_CASE("after any bounces, a debounced line ends at the level of the contact") {
  std::mt19937 random(11);
  for (int round = 0; round < 500; ++round) {
    StrobeConfig config = uncapped(StrobeMode::kFollow);
    config.debounce_ns = 5 * kNsPerMs;
    StrobeLine line = started(config);
    bool level = false;
    double ms = 0;
    const int edge_count = std::uniform_int_distribution<>(1, 60)(random);
    for (int i = 0; i < edge_count; ++i)
      line.edge(level = !level, at(ms += std::exponential_distribution<>(1.0)(random)));
    CHECK((value_at(line, ms + 20) == 255) == level);
  }
}

TEST_CASE("two edges of the same kind are a pulse with a lost edge") {
  StrobeLine toggle = started(uncapped(StrobeMode::kToggle));
  toggle.edge(false, at(1));  // up and down between two interrupts
  CHECK(toggle.value() == 255);
  CHECK(toggle.counters().lost == 1);
  toggle.edge(false, at(2));
  CHECK(toggle.value() == 0);
  StrobeLine follow = started(uncapped(StrobeMode::kFollow));
  follow.edge(true, at(1));
  follow.edge(true, at(2));
  CHECK(follow.value() == 255);
  CHECK(follow.counters().flashes == 2);
}

TEST_CASE("a level that was read corrects lost edges") {
  StrobeLine line = started(uncapped(StrobeMode::kFollow));
  line.edge(true, at(0));
  line.read_level(false, at(10));  // the falling edge found no room in the queue
  CHECK(line.value() == 0);
  CHECK(line.changed_ns() == at(10));
  CHECK(line.counters().repaired == 1);
  line.read_level(false, at(20));
  CHECK(line.counters().repaired == 1);
}

TEST_CASE("a level that was read before its edge arrived is not a lost pulse") {
  StrobeLine line = started(uncapped(StrobeMode::kToggle));
  line.read_level(true, at(10));
  CHECK(line.value() == 255);
  line.edge(true, at(10.01));
  CHECK(line.value() == 255);
  CHECK(line.counters().lost == 0);
  line.edge(false, at(50));
  line.edge(true, at(100));
  CHECK(line.value() == 0);
}

TEST_CASE("by default no more than four flashes begin in any one second") {
  for (const StrobeMode mode : {StrobeMode::kFollow, StrobeMode::kOneShot, StrobeMode::kToggle}) {
    StrobeConfig config;
    config.mode = mode;
    config.hold_ns = 10 * kNsPerMs;
    REQUIRE(config.flashes_hz_max == 4.0);
    std::mt19937 random(3);
    for (int round = 0; round < 20; ++round) {
      StrobeLine line = started(config);
      std::vector<double> flashes;
      std::uint64_t seen = 0;
      bool level = false;
      double next_edge_ms = 0;
      for (double ms = 0; ms < 5000; ms += 0.5) {
        if (ms >= next_edge_ms) {
          line.edge(level = !level, at(ms));
          next_edge_ms = ms + std::uniform_real_distribution<>(0.5, 60.0)(random);
        }
        line.advance(at(ms));
        for (; seen < line.counters().flashes; ++seen) flashes.push_back(ms);
      }
      REQUIRE(flashes.size() >= 4);
      CHECK(line.counters().capped > 0);
      for (std::size_t i = 4; i < flashes.size(); ++i) CHECK(flashes[i] - flashes[i - 4] >= 1000.0);
    }
  }
}

TEST_CASE("the cap counts flashes in a window, so two quick ones pass") {
  StrobeConfig config;
  config.hold_ns = 0;
  StrobeLine line = started(config);
  for (int i = 0; i < 4; ++i) {
    line.edge(true, at(20 * i));
    CHECK(line.value() == 255);
    line.edge(false, at(20 * i + 10));
  }
  CHECK(line.counters().capped == 0);
  line.edge(true, at(100));
  CHECK(line.value() == 0);
  CHECK(line.counters().capped == 1);
}

TEST_CASE("a held key turns on as soon as the cap allows, a released one never") {
  StrobeConfig config;
  config.flashes_hz_max = 1.0;
  config.hold_ns = 0;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(10));
  line.edge(true, at(20));
  CHECK(line.value() == 0);
  CHECK(line.next_deadline_ns() == at(1000));
  CHECK(value_at(line, 1000) == 255);
  line.edge(false, at(1100));
  line.edge(true, at(1200));
  line.edge(false, at(1300));
  CHECK(value_at(line, 4000) == 0);
  CHECK(line.counters().flashes == 2);
  CHECK(line.counters().capped == 2);
}

TEST_CASE("a one-shot above the cap is left out and does not come late") {
  StrobeConfig config;
  config.mode = StrobeMode::kOneShot;
  config.hold_ns = 50 * kNsPerMs;
  config.flashes_hz_max = 0.5;  // one in two seconds
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.edge(false, at(100));
  line.edge(true, at(1990));
  CHECK(line.value() == 0);
  CHECK(value_at(line, 2005) == 0);
  line.edge(false, at(2006));
  line.edge(true, at(2010));
  CHECK(line.value() == 255);
}

TEST_CASE("toggle pressed twice while the cap holds it back stays off") {
  StrobeConfig config;
  config.mode = StrobeMode::kToggle;
  config.flashes_hz_max = 1.0;
  StrobeLine line = started(config);
  const auto press = [&line](double ms) {
    line.edge(true, at(ms));
    line.edge(false, at(ms + 1));
  };
  press(0);
  press(100);
  CHECK(line.value() == 0);
  press(200);  // due to turn on, not before 1000
  CHECK(line.value() == 0);
  press(300);
  CHECK(value_at(line, 5000) == 0);
  press(5000);
  CHECK(line.value() == 255);
}

TEST_CASE("the cap limits a rate to its own value, never a step above") {
  StrobeConfig config;
  config.mode = StrobeMode::kRate;
  StrobeLine line = started(config);
  StrobeLine free_line = started(uncapped(StrobeMode::kRate));
  for (int i = 0; i < 10; ++i)
    for (StrobeLine* each : {&line, &free_line}) {
      each->edge(true, at(50 * i));
      each->edge(false, at(50 * i + 20));
    }
  CHECK(free_line.value() == 202);  // 20 Hz: 1 + 19 / 24 * 254
  CHECK(line.value() == 32);        // 4 Hz: 1 + 3 / 24 * 254 = 32.75
  CHECK(line.counters().capped == 9);
  CHECK(free_line.counters().capped == 0);
}

TEST_CASE("the cap persists when a chip is unplugged and replugged") {
  StrobeConfig config;
  config.flashes_hz_max = 1.0;
  StrobeLine line = started(config);
  line.edge(true, at(0));
  line.stop(at(10));
  CHECK(line.value() == 0);
  line.start(true, at(20));
  CHECK(line.value() == 0);
  CHECK(value_at(line, 1000) == 255);
}

TEST_CASE("a line that is gone is off and has nothing due, in every mode") {
  for (const StrobeMode mode : {StrobeMode::kFollow, StrobeMode::kOneShot, StrobeMode::kToggle, StrobeMode::kRate}) {
    StrobeConfig config = uncapped(mode);
    config.hold_ns = kNsPerS;
    config.debounce_ns = kNsPerMs;
    StrobeLine line = started(config);
    line.edge(true, at(0));
    line.edge(false, at(100));
    line.edge(true, at(200));
    line.stop(at(201));
    CHECK(line.value() == 0);
    CHECK(line.next_deadline_ns() == kTimeNever);
  }
}

TEST_CASE("stamps that run backwards do no harm") {
  StrobeConfig config;
  config.debounce_ns = kNsPerMs;
  StrobeLine line = started(config);
  line.edge(true, at(100));
  line.edge(false, at(50));
  line.edge(true, at(-500));
  line.edge(false, at(10));
  CHECK(value_at(line, 200) == 0);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
