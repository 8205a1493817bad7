// Pan and tilt that send a beam to a point: checked by the beam that the walker has at the levels that come of it.
#include "tools/footlight/preview/ui/beam_aim.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/edit/rig_edits.h"
#include "fixtures/model/params.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/hand_levels.h"

namespace footlight::tools {
namespace {

using testing::compiled_rig;
using testing::kUiRig;
using testing::parsed_rig;
using testing::UiRig;

// A rig with levels of faders, in which fixtures are aimed.
struct Aimed {
  explicit Aimed(fixtures::Rig rig)
      : one(compiled_rig(std::move(rig))), index(one.rig, one.compiled), aim(one.rig, one.compiled) {
    const HandLevels hand(one.rig, one.compiled);
    levels.assign(hand.levels().begin(), hand.levels().end());
  }
  AimCommand to(std::vector<int> which, const glm::dvec3& point_m) {
    AimCommand made = aim_command(aim, one.rig, index, which, point_m, levels);
    for (const auto& edit : made.command.edits) index.write(edit.key, *edit.after, levels);
    return made;
  }
  // How far the beam passes the point.
  double miss_m(int fixture, const glm::dvec3& point_m) {
    const StageRay beam = aim.beam_of(fixture, levels).value();
    if (glm::dot(point_m - beam.from_m, beam.way) < 0) return 1e9;
    return glm::length(glm::cross(point_m - beam.from_m, beam.way));
  }
  UiRig one;
  RigIndex index;
  BeamAim aim;
  std::vector<std::uint8_t> levels;
};

TEST_CASE("a beam that is aimed passes its point within the steps of the channels") {
  // Hung, lying, on its side, and mirrored by a pose.
  for (const glm::dvec3 rotation_deg : {glm::dvec3(0), glm::dvec3(180, 0, 30), glm::dvec3(90, 20, -70)}) {
    for (const bool mirrors : {false, true}) {
      CAPTURE(rotation_deg.x);
      CAPTURE(mirrors);
      fixtures::Rig rig = parsed_rig(kUiRig);
      rig.fixtures[0].rotation_deg = rotation_deg;
      if (mirrors) {
        glm::dmat4 pose = fixtures::pose_of(rig.fixtures[0]);
        pose[0] = -pose[0];
        rig.fixtures[0].pose = pose;
      }
      Aimed aimed(std::move(rig));
      double worst_m = 0;
      for (const glm::dvec3 point_m : {glm::dvec3(0, 4, 0), glm::dvec3(-6, -3, 1), glm::dvec3(-3, 6, 9),
                                       glm::dvec3(-2.5, 0.3, 0), glm::dvec3(10, 1, 4)}) {
        const AimCommand made = aimed.to({0}, point_m);
        CHECK(made.aimed == 1);
        if (made.off_rad > 1e-4) continue;  // out of reach of its tilt
        worst_m = std::max(worst_m, aimed.miss_m(0, point_m));
      }
      // Half a step of 16 bits over 540 degrees is 0.004 degrees: 1 mm at 14 m.
      CHECK(worst_m < 2e-3);
    }
  }
}

TEST_CASE("of two ways to a point a head takes the one with less turning") {
  Aimed aimed(parsed_rig(kUiRig));
  const auto pan = [&] { return aimed.aim.angles_to(1, {0, 3, 0}, aimed.levels)->pan_deg.value(); };
  (void)aimed.to({1}, {0.2, 3, 0});
  CHECK(std::abs(pan()) < 10);
  // The other way round it is 180 degrees from there, with the tilt to the other side.
  const auto there = aimed.aim.angles_to(1, {0, -3, 0}, aimed.levels);
  REQUIRE(there);
  CHECK(std::abs(*there->pan_deg) < 10);
  CHECK(*there->tilt_deg * *aimed.aim.angles_to(1, {0, 3, 0}, aimed.levels)->tilt_deg < 0);
}

TEST_CASE("a point along the pan axis is aimed at, and one at the lens is not") {
  Aimed aimed(parsed_rig(kUiRig));
  const glm::dvec3 below_m(0, 0, 0);  // under Spot 2
  (void)aimed.to({1}, below_m);
  CHECK(aimed.miss_m(1, below_m) < 2e-3);
  const auto again = aimed.aim.angles_to(1, below_m, aimed.levels);
  REQUIRE(again);
  CHECK(std::isfinite(*again->pan_deg));
  const StageRay beam = aimed.aim.beam_of(1, aimed.levels).value();
  const auto at_lens = aimed.aim.angles_to(1, beam.from_m, aimed.levels);
  if (at_lens) CHECK(std::isfinite(*at_lens->tilt_deg));
  CHECK(!aimed.aim.angles_to(1, beam.from_m, {}));
  // Straight up is beyond the tilt of a hanging head.
  const auto up = aimed.aim.angles_to(1, {0, 0, 60}, aimed.levels);
  REQUIRE(up);
  CHECK(up->off_rad > 0.2);
}

// Every profile of the rig turns an attribute by no more than this.
fixtures::Rig limited_rig(const char* attribute, double from_deg, double to_deg) {
  fixtures::Rig rig = parsed_rig(kUiRig);
  for (fixtures::FixtureType& type : rig.types) {
    for (fixtures::Mode& mode : type.modes) {
      for (fixtures::Channel& channel : mode.channels) {
        for (fixtures::ChannelFunction& function : channel.functions) {
          if (!fixtures::same_attribute(function.attribute, attribute)) continue;
          function.physical_from = from_deg;
          function.physical_to = to_deg;
        }
      }
    }
  }
  return rig;
}

TEST_CASE("a head whose pan does not turn its beam keeps its pan") {
  Aimed aimed(limited_rig("Tilt", 0, 0));  // the beam is along the pan axis
  aimed.levels[0] = 200;
  const StageRay before = aimed.aim.beam_of(0, aimed.levels).value();
  CHECK(before.way.z < -0.999);
  const auto angles = aimed.aim.angles_to(0, {2, 3, 0}, aimed.levels);
  REQUIRE(angles);
  CHECK(!angles->tilt_deg);
  CHECK(std::abs(*angles->pan_deg) > 100);
  (void)aimed.to({0}, {2, 3, 0});
  CHECK(aimed.levels[0] == 200);
}

TEST_CASE("out of reach of its pan a head comes as near as it can at an end of the pan") {
  Aimed aimed(limited_rig("Pan", -30, 30));
  int beyond = 0;
  for (const glm::dvec3 point_m : {glm::dvec3(-6, -3, 1), glm::dvec3(3, 0.5, 2), glm::dvec3(-8, 1, 0)}) {
    const double off_rad = aimed.aim.angles_to(0, point_m, aimed.levels).value().off_rad;
    if (off_rad > 0.05) ++beyond;
    // Both ends of the pan with steps of the tilt.
    double least_rad = 10;
    std::vector<std::uint8_t> levels = aimed.levels;
    for (const int pan : {0, 255}) {
      levels[0] = levels[1] = static_cast<std::uint8_t>(pan);
      for (int tilt = 0; tilt < 65536; tilt += 128) {
        levels[2] = static_cast<std::uint8_t>(tilt / 256);
        levels[3] = static_cast<std::uint8_t>(tilt % 256);
        const StageRay beam = aimed.aim.beam_of(0, levels).value();
        least_rad = std::min(least_rad, std::acos(glm::dot(beam.way, glm::normalize(point_m - beam.from_m))));
      }
    }
    CHECK(off_rad < least_rad + 1e-3);
  }
  CHECK(beyond >= 2);
}

TEST_CASE("an aim computes at most 120 beams") {
  Aimed aimed(parsed_rig(kUiRig));
  for (const glm::dvec3 point_m : {glm::dvec3(0, 4, 0), glm::dvec3(-6, -3, 1), glm::dvec3(-2.5, 0.3, 0)}) {
    const std::size_t before = aimed.aim.computed();
    CHECK(aimed.aim.angles_to(0, point_m, aimed.levels));
    CHECK(aimed.aim.computed() - before <= 120);
  }
}

TEST_CASE("fixtures without pan and tilt, and without an address, are left") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures[1].patched = false;
  Aimed aimed(std::move(rig));
  CHECK(aimed.aim.moves(0));
  CHECK(!aimed.aim.moves(3));  // a par
  const AimCommand made = aimed.to({0, 1, 2, 3}, {0, 2, 0});
  CHECK(made.aimed == 2);
  CHECK(made.left == 2);
  CHECK(made.command.edits.size() == 4);
  CHECK(aimed.miss_m(0, {0, 2, 0}) < 2e-3);
  CHECK(aimed.miss_m(2, {0, 2, 0}) < 2e-3);
}

TEST_CASE("a par is turned to a point, also to one straight behind it") {
  for (const glm::dvec3 point_m : {glm::dvec3(3, 5, 0), glm::dvec3(0, 2, 8), glm::dvec3(-7, 2, 4)}) {
    Aimed aimed(parsed_rig(kUiRig));
    const std::vector<int> which{0, 3};
    const auto edit = turn_to_point(aimed.aim, aimed.one.rig, which, point_m, aimed.levels);
    REQUIRE(edit);
    CHECK(edit->changes.size() == 1);  // the head aims by its channels
    CHECK(edit->text == "aim Par");
    fixtures::Rig turned = aimed.one.rig;
    edit->apply(turned);
    Aimed after(std::move(turned));
    CHECK(after.miss_m(3, point_m) < 1e-6);
    CHECK(fixtures::position_of(after.one.rig.fixtures[3]) == fixtures::position_of(aimed.one.rig.fixtures[3]));
  }
  Aimed aimed(parsed_rig(kUiRig));
  const std::vector<int> heads{0, 1};
  CHECK(!turn_to_point(aimed.aim, aimed.one.rig, heads, {0, 0, 0}, aimed.levels));
}

}  // namespace
}  // namespace footlight::tools
