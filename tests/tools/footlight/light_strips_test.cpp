// The colours of groups of fixtures over a log.
#include "tools/footlight/preview/light_strips.h"

#include <doctest/doctest.h>

#include "fixtures/simulate/encode.h"
#include "tests/tools/footlight/ui_rigs.h"

namespace footlight::tools {
namespace {

using testing::UiRig;

void set(const UiRig& rig, std::size_t fixture, const char* attribute, double value,
         std::vector<std::uint8_t>& levels) {
  const auto& one = rig.rig.fixtures[fixture];
  const std::size_t universe = static_cast<std::size_t>(one.universe - 1);  // the rig has 1 and 2
  REQUIRE(fixtures::encode_attribute(rig.rig, one, attribute, value,
                                     std::span(levels).subspan(universe * kSlotCountMax, kSlotCountMax)));
}

TEST_CASE("a strip has the colour of its fixtures, the group with the most is the first, and dark ones are black") {
  const UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  LightStrips strips(rig.rig, rig.compiled);
  REQUIRE(strips.strips().size() == 2);
  CHECK(strips.strips()[0].name == "Profile");
  CHECK(strips.strips()[0].fixtures == 3);
  CHECK(strips.strips()[1].name == "Par");
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);
  strips.add(0, levels);
  for (std::size_t par : {3u, 4u}) {
    set(rig, par, "Dimmer", 1, levels);
    set(rig, par, "ColorAdd_R", 1, levels);
  }
  strips.add(2 * kNsPerS, levels);
  strips.add(4 * kNsPerS, levels);
  REQUIRE(strips.times() == std::vector<TimeNs>{0, 2 * kNsPerS, 4 * kNsPerS});
  const auto& pars = strips.strips()[1].colours;
  REQUIRE(pars.size() == 3);
  CHECK(pars[0] == glm::vec3(0));
  CHECK(pars[2].r > 0.2f);
  CHECK(pars[2].g < 0.1f * pars[2].r);
  CHECK(strips.strips()[0].colours[2] == glm::vec3(0));
  strips.add(3 * kNsPerS, levels);  // is not later
  CHECK(strips.times().size() == 3);
}

TEST_CASE("a moment of 10,000 fixtures steps no more heads than a strip holds") {
  const UiRig rig = testing::many_fixtures(10'000);
  LightStrips strips(rig.rig, rig.compiled);
  REQUIRE(strips.strips().size() == 1);
  CHECK(strips.strips()[0].fixtures == 10'000);
  CHECK(strips.strips()[0].heads.size() == LightStrips::kHeadsMax);
  CHECK(strips.strips()[0].heads.back() > 9'000);
  const std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax, 255);
  strips.add(0, levels);
  CHECK(strips.strips()[0].colours.size() == 1);
}

TEST_CASE("a rig without fixtures has no strips") {
  fixtures::Rig none = testing::parsed_rig(testing::kUiRig);
  none.fixtures.clear();
  const UiRig rig = testing::compiled_rig(std::move(none));
  LightStrips strips(rig.rig, rig.compiled);
  strips.add(0, {});
  CHECK(strips.strips().empty());
}

}  // namespace
}  // namespace footlight::tools
