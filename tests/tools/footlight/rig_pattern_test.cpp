// Patterns on the fixtures of a rig, and the endpoints that play them.
#include "tools/footlight/preview/rig_pattern.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "sim/system_clock.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/preview/hand_levels.h"

namespace footlight::tools {
namespace {

TEST_CASE("each fixture is a voice, dark by its dimmer alone, and lit as faders start") {
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  const PatternPlan plan = rig_pattern(rig.rig, rig.compiled, rig.compiled.universes);
  const HandLevels lit(rig.rig, rig.compiled);
  CHECK(std::equal(plan.levels.begin(), plan.levels.end(), lit.levels().begin(), lit.levels().end()));
  REQUIRE(plan.voices.size() == 5);
  std::set<std::uint32_t> seen;
  for (std::size_t voice = 0; voice < plan.voices.size(); ++voice) {
    INFO(voice);
    CHECK(!plan.voices[voice].empty());
    // A dimmer of two bytes at most, or the colours of a par.
    CHECK(plan.voices[voice].size() <= (voice < 3 ? 2 : 5));
    for (const PatternSlot& slot : plan.voices[voice]) {
      CHECK(slot.dark == 0);
      CHECK(slot.lit == lit.levels()[slot.index]);
      CHECK(seen.insert(slot.index).second);
    }
  }
}

TEST_CASE("a pattern for one universe leaves the fixtures of the others alone") {
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  const std::vector<Universe> asked = {2, 8};
  const PatternPlan plan = rig_pattern(rig.rig, rig.compiled, asked);
  CHECK(plan.universes == asked);
  REQUIRE(plan.levels.size() == 2 * kSlotCountMax);
  REQUIRE(plan.voices.size() == 1);
  for (const PatternSlot& slot : plan.voices[0]) CHECK(slot.index < kSlotCountMax);
  CHECK(std::all_of(plan.levels.begin() + kSlotCountMax, plan.levels.end(), [](int level) { return level == 0; }));
}

TEST_CASE("mock:chase opens as an input of its universes, and is refused as an output") {
  SystemClock clock;
  PortOpener opener(clock);
  const Endpoint endpoint = parse_port("mock:chase=4,2").value();
  CHECK(plays_pattern(endpoint));
  const auto source = opener.open_source(endpoint);
  REQUIRE(source);
  CHECK((*source)->name() == "mock:chase=4,2");
  const auto universes = (*source)->universes();
  CHECK(std::vector<Universe>(universes.begin(), universes.end()) == std::vector<Universe>{2, 4});
  const auto sink = opener.open_sink(endpoint, {});
  REQUIRE(!sink);
  CHECK(sink.error().message.find("a pattern is an input") != std::string::npos);
  const auto unknown = opener.open_source(parse_port("mock:rainbow").value());
  REQUIRE(!unknown);
  CHECK(unknown.error().message.find("mock:chase, mock:full, mock:sine") != std::string::npos);
}

TEST_CASE("models and patterns are made up, and what is on a wire or a file is not") {
  for (const char* text :
       {"mock:chase", "mock:enttec-pro=3", "gpio:mock/2=1.25", "midi:mock=1.1", "vrsl:1-9@mock", "audio:mock=1.25"}) {
    INFO(text);
    CHECK(is_made_up(parse_port(text).value()));
  }
  for (const char* text : {"sacn:1", "artnet:1-3", "enttec-pro", "enttec-pro:mock", "log:mock", "osc:8000"}) {
    INFO(text);
    CHECK(!is_made_up(parse_port(text).value()));
  }
}

}  // namespace
}  // namespace footlight::tools
