// How a log plays in the window: speed, parts that repeat, seeks, and the light of the rig over the log.
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kFrameNs = 20 * kNsPerMs;

Transport at(TimeNs now_ns) {
  Transport transport;
  transport.now_ns = now_ns;
  transport.duration_ns = 10 * kNsPerS;
  return transport;
}

TEST_CASE("a log plays at its speed, stops at its end, and goes on from its start if it repeats") {
  Transport transport = at(kNsPerS);
  CHECK(transport.next_ns(kFrameNs) == kNsPerS + kFrameNs);
  CHECK(transport.next_ns(0) == kNsPerS);
  transport.change_speed(-1);
  CHECK(transport.speed == 0.5);
  CHECK(transport.next_ns(kFrameNs) == kNsPerS + kFrameNs / 2);
  transport.change_speed(-100);
  CHECK(transport.speed == 0.1);
  transport.change_speed(100);
  CHECK(transport.speed == 4);
  CHECK(transport.next_ns(kFrameNs) == kNsPerS + 4 * kFrameNs);
  transport = at(10 * kNsPerS - 1);
  CHECK(transport.next_ns(kFrameNs) == 10 * kNsPerS);
  transport.repeats = true;
  CHECK(transport.next_ns(kFrameNs) == kFrameNs - 1);
  transport.duration_ns = transport.now_ns = 0;
  CHECK(transport.next_ns(kFrameNs) == 0);
}

TEST_CASE("a part repeats from its end to its start, and a seek behind its end plays on to the end of the log") {
  Transport transport = at(4 * kNsPerS);
  transport.repeat_from(2 * kNsPerS);
  transport.repeat_to(4 * kNsPerS + kFrameNs / 2);
  CHECK(transport.next_ns(kFrameNs) == 2 * kNsPerS + kFrameNs / 2);
  transport.now_ns = 5 * kNsPerS;
  CHECK(transport.next_ns(kFrameNs) == 5 * kNsPerS + kFrameNs);
  transport.now_ns = 10 * kNsPerS;
  CHECK(transport.next_ns(kFrameNs) == 2 * kNsPerS + kFrameNs);
  transport.now_ns = 0;  // before it: plays into it
  CHECK(transport.next_ns(kFrameNs) == kFrameNs);
  transport.repeat_all();
  transport.now_ns = 10 * kNsPerS;
  CHECK(transport.next_ns(kFrameNs) == 10 * kNsPerS);
}

TEST_CASE("an end of the part that repeats removes the other one where it lies on the wrong side") {
  Transport transport = at(0);
  transport.repeat_from(2 * kNsPerS);
  transport.repeat_to(4 * kNsPerS);
  transport.repeat_from(5 * kNsPerS);
  CHECK(transport.from_ns == 5 * kNsPerS);
  CHECK(!transport.to_ns);
  transport.repeat_to(5 * kNsPerS);
  CHECK(!transport.from_ns);
  CHECK(transport.to_ns == 5 * kNsPerS);
}

TEST_CASE("pictures that take longer than the part that repeats show all of it in turn") {
  Transport transport = at(2 * kNsPerS);
  transport.repeat_from(2 * kNsPerS);
  transport.repeat_to(5 * kNsPerS);
  std::vector<TimeNs> shown;
  for (int i = 0; i < 4; ++i) {
    transport.now_ns = transport.next_ns(4 * kNsPerS);
    shown.push_back(transport.now_ns);
  }
  CHECK(shown == std::vector<TimeNs>{3 * kNsPerS, 4 * kNsPerS, 2 * kNsPerS, 3 * kNsPerS});
}

TEST_CASE("a part that repeats has a length, also at the ends of the log") {
  Transport transport = at(0);
  transport.repeat_to(0);
  CHECK(!transport.to_ns);
  CHECK(transport.next_ns(kFrameNs) == kFrameNs);
  transport.repeat_from(10 * kNsPerS);
  CHECK(!transport.from_ns);
  transport.repeat_from(kNsPerS);
  transport.repeat_to(0);  // changes nothing
  CHECK(transport.from_ns == kNsPerS);
  transport.repeat_to(kNsPerS + kRepeatMinNs - 1);
  CHECK(!transport.from_ns);
  transport.repeat_from(kNsPerS);
  CHECK(!transport.to_ns);
  transport.repeat_to(kNsPerS + kRepeatMinNs);
  CHECK(transport.from_ns == kNsPerS);
  CHECK(transport.to_ns == kNsPerS + kRepeatMinNs);
}

TEST_CASE("the text of a time has at most 59.9 seconds") {
  CHECK(time_text(0) == "0:00.0");
  CHECK(time_text(59'960 * kNsPerMs) == "0:59.9");
  CHECK(time_text(60 * kNsPerS) == "1:00.0");
  CHECK(time_text(3'723'456 * kNsPerMs) == "1:02:03.4");
}

TEST_CASE("seeks add up until they are carried out, and stay within the log") {
  Transport transport = at(4 * kNsPerS);
  transport.seek_by(5 * kNsPerS);
  CHECK(transport.seek_ns == 9 * kNsPerS);
  transport.seek_by(5 * kNsPerS);
  CHECK(transport.seek_ns == 10 * kNsPerS);
  transport.seek_by(-30 * kNsPerS);
  CHECK(transport.seek_ns == 0);
}

TEST_CASE("the light of a rig is the mean level of its dimmers, whatever else moves") {
  const testing::UiRig rig = testing::compiled_rig(testing::taken(fixtures::parse_rig(testing::kUiRig, "ui.toml")));
  const RigIndex index(rig.rig, rig.compiled);
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax, 0);
  LightCurve curve(rig.rig, index);
  curve.add(0, levels);
  std::vector<std::uint8_t> dimmers = levels;
  std::vector<std::uint8_t> others(levels.size(), 255);
  for (int fixture = 0; fixture < static_cast<int>(rig.rig.fixtures.size()); ++fixture) {
    for (int channel = 0; channel < static_cast<int>(index.channel_count(fixture)); ++channel) {
      for (const auto& function : index.channel({fixture, channel}).functions) {
        if (function.attribute != "Dimmer") continue;
        index.write({fixture, channel}, fixtures::raw_max(index.channel({fixture, channel}).byte_count), dimmers);
        index.write({fixture, channel}, 0, others);
      }
    }
  }
  REQUIRE(dimmers != levels);
  curve.add(kNsPerS, dimmers);
  curve.add(kNsPerS, others);  // not later than the last one
  curve.add(2 * kNsPerS, others);
  REQUIRE(curve.points().size() == 3);
  CHECK(curve.points()[0].light == 0);
  CHECK(curve.points()[1].light == 1);
  CHECK(curve.points()[2].light == 0);
}

TEST_CASE("the light of some fixtures is the mean level of their dimmers alone") {
  const testing::UiRig rig = testing::compiled_rig(testing::taken(fixtures::parse_rig(testing::kUiRig, "ui.toml")));
  const RigIndex index(rig.rig, rig.compiled);
  REQUIRE(rig.rig.fixtures.size() > 1);
  const auto light_of = [&](std::vector<int> which, int lit) {
    std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax, 0);
    for (int channel = 0; channel < static_cast<int>(index.channel_count(lit)); ++channel) {
      index.write({lit, channel}, fixtures::raw_max(index.channel({lit, channel}).byte_count), levels);
    }
    LightCurve curve(rig.rig, index, which);
    curve.add(0, levels);
    return curve.points().front().light;
  };
  CHECK(light_of({0}, 0) == 1);
  CHECK(light_of({1}, 0) == 0);
  CHECK(light_of({0, 1}, 0) == doctest::Approx(0.5));
  CHECK(light_of({0, -1, 1000}, 0) == 1);  // as after an edit that the rig of the curve does not have yet
  CHECK(light_of({}, 0) < 1);
}

}  // namespace
}  // namespace footlight::tools
