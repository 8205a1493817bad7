// The demo show, checked for what a lighting designer would check.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "fixtures/simulate/walker.h"
#include "sim/dmx_log/dmx_log.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/demo_show/demo_show.h"

namespace footlight::demo {
namespace {

constexpr int kFrames = static_cast<int>(kShowLengthS * kShowRateHz);

double light_at(const DemoShow& show, double t_s) {
  double sum = 0;
  for (const Player& player : show.players()) sum += show.cue(player, t_s).dimmer;
  return sum;
}

TEST_CASE("aim points the beam at its target, for any hanging") {
  const fixtures::Rig& demo = fixtures::demo_rig();
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 500; ++i) {
    fixtures::Rig rig = demo;
    rig.fixtures.resize(1);
    if (i > 0) rig.fixtures[0].rotation_deg = glm::dvec3(unit(random), unit(random), unit(random)) * 180.0;
    const glm::dvec3 direction = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)) + 1e-3);
    const PanTilt angles = aim(rig.fixtures[0], direction);
    const auto compiled = fixtures::compile(rig);
    REQUIRE(compiled);
    fixtures::f64::Walker walker(*compiled);
    walker.states[0].pan = angles.pan;
    walker.states[0].tilt = angles.tilt;
    const auto pose = walker.pose(0);
    REQUIRE(glm::length(pose.axis - direction) < 1e-6);
    REQUIRE(std::abs(angles.pan) <= 1.5708);
  }
}

TEST_CASE("every fixture of the rig plays, and only universes 1 and 2 are used") {
  const DemoShow show(fixtures::demo_rig());
  CHECK(show.universes() == std::vector<Universe>{1, 2});
  CHECK(show.players().size() == 24);
  std::set<int> playing;
  for (int frame = 0; frame < kFrames; frame += 11) {
    for (const Player& player : show.players()) {
      if (show.cue(player, frame / 44.0).dimmer > 0.4) playing.insert(player.fixture);
    }
  }
  CHECK(playing.size() == 24);
}

TEST_CASE("the show begins and ends dark, has a blackout, and repeats") {
  const DemoShow show(fixtures::demo_rig());
  CHECK(light_at(show, 0) < 0.01);
  CHECK(light_at(show, 59.9) < 0.01);
  CHECK(light_at(show, 36.0) == 0);
  CHECK(light_at(show, 36.99) == 0);
  CHECK(light_at(show, 35.9) > 10);
  CHECK(light_at(show, 37.0) > 10);
  std::vector<Slots> once(2), again(2);
  show.levels_at(12.25, once);
  show.levels_at(12.25 + 3 * kShowLengthS, again);
  CHECK(once == again);
  show.levels_at(12.25 - kShowLengthS, again);
  CHECK(once == again);
}

TEST_CASE("it strobes for at most a tenth of the time and never faster than 15 Hz") {
  const DemoShow show(fixtures::demo_rig());
  int strobing = 0;
  double fastest = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    double hz = 0;
    for (const Player& player : show.players()) hz = std::max(hz, show.cue(player, frame / 44.0).strobe_hz);
    strobing += hz > 0;
    fastest = std::max(fastest, hz);
  }
  MESSAGE("strobing ", 100.0 * strobing / kFrames, " % of the time, at most ", fastest, " Hz");
  CHECK(strobing > 0);
  CHECK(strobing <= kFrames / 10);
  CHECK(fastest < 15);
}

TEST_CASE("the light varies: parts differ in colour, gobo and zoom") {
  const DemoShow show(fixtures::demo_rig());
  std::set<int> gobos;
  double narrow = 100;
  double wide = 0;
  for (int frame = 0; frame < kFrames; frame += 11) {
    for (const Player& player : show.players()) {
      const Cue cue = show.cue(player, frame / 44.0);
      gobos.insert(cue.gobo);
      narrow = std::min(narrow, cue.zoom_deg);
      wide = std::max(wide, cue.zoom_deg);
      REQUIRE(cue.dimmer >= 0);
      REQUIRE(cue.dimmer <= 1.0 + 1e-12);
      for (int i = 0; i < 3; ++i) REQUIRE((cue.color[i] >= 0 && cue.color[i] <= 1.0 + 1e-12));
    }
  }
  CHECK(gobos.size() >= 4);
  CHECK(narrow < 7);
  CHECK(wide > 40);
}

// Uses the positions that the motors reach. From the front-of-house camera at most a few narrow beams may point
// straight at the camera at a time.
TEST_CASE("few beams at a time point into the main camera") {
  const fixtures::Rig& rig = fixtures::demo_rig();
  const auto compiled = fixtures::compile(rig);
  REQUIRE(compiled);
  const DemoShow show(rig);
  fixtures::f32::Walker walker(*compiled);
  std::vector<Slots> levels(2);
  std::vector<std::uint8_t> flat(1024);
  const glm::vec3 eye(rig.cameras.front().position_m);
  int blinded = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    show.levels_at(frame / 44.0, levels);
    std::copy(levels[0].begin(), levels[0].end(), flat.begin());
    std::copy(levels[1].begin(), levels[1].end(), flat.begin() + 512);
    walker.step(flat, kNsPerS / 44);
    int at_eye = 0;
    for (std::size_t i = 0; i < walker.states.size(); ++i) {
      const auto& state = walker.states[i];
      const auto pose = walker.pose(i);
      const bool inside = glm::dot(glm::normalize(eye - pose.lens_m), pose.axis) > std::cos(state.zoom);
      at_eye += inside && state.red + state.green + state.blue > 0.05f;
    }
    blinded += at_eye > 2;
  }
  CHECK(blinded <= 22);  // half a second
}

TEST_CASE("the embedded log equals the show, frame by frame, for a minute") {
  const auto bytes = demo_log_bytes();
  auto reader = LogReader::open_bytes({bytes.begin(), bytes.end()}, "demo");
  REQUIRE_MESSAGE(reader, reader.error().message);
  CHECK(reader->info().duration_ns == 60 * kNsPerS);
  CHECK(reader->info().frames == 2 * kFrames);
  const DemoShow show(fixtures::demo_rig());
  std::vector<Slots> levels(2);
  LogFrame frame;
  int count = 0;
  int wrong = 0;
  for (;;) {
    const auto more = reader->next(frame);
    REQUIRE_MESSAGE(more, more.error().message);
    if (!*more) break;
    const int index = count / 2;
    if (count % 2 == 0) show.levels_at(static_cast<double>(index) / kShowRateHz, levels);
    wrong += frame.time_ns != index * kNsPerS / kShowRateHz;
    wrong += frame.universe != count % 2 + 1;
    wrong += !std::equal(frame.levels.begin(), frame.levels.end(), levels[static_cast<std::size_t>(count % 2)].begin());
    ++count;
  }
  CHECK(count == 2 * kFrames);
  CHECK(wrong == 0);
}

}  // namespace
}  // namespace footlight::demo
