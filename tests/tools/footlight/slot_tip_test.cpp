// What the tip of a slot says, without a window.
#include <span>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/slot_tip.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::parsed_rig;

TEST_CASE("the tip of a slot has its level, fixture, attribute, value, sender, priority and age") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax, 128);
  std::vector<FrameStamp> stamps(rig.compiled.universes.size());
  stamps[0].revision = 1;
  stamps[0].stamp_ns = 9 * kNsPerS;
  PumpStatus status;
  UniverseStatus one;
  one.universe = 1;
  SenderStatus sender;
  sender.name = "FOH desk";
  sender.priority = 120;
  sender.wins = true;
  one.senders.push_back(sender);
  status.universes.push_back(one);
  UiInput input;
  input.levels = levels;
  input.stamps = stamps;
  input.status = &status;
  input.now_ns = 10 * kNsPerS;
  SlotChanges changes;
  changes.take(std::span(levels).first(kSlotCountMax), 8 * kNsPerS, true);
  const auto place = desk.index().place({1, 8});
  REQUIRE(place);
  const auto slot = static_cast<std::size_t>(place->address - 1);
  changes.changed_ns[slot] = 8 * kNsPerS;
  SlotTip tip = tip_of_slot(desk, input, 0, slot, changes, input.now_ns);
  CHECK(tip.level == fmt::format("1.{}  level 128 (50 %)", slot + 1));
  REQUIRE(tip.means.size() == 1);
  INFO(tip.means[0]);
  CHECK(tip.means[0].starts_with("Spot 2: "));
  CHECK(tip.means[0].find("(" + desk.index().channel({1, 8}).functions[0].attribute + "): ") != std::string::npos);
  CHECK(tip.from.find("FOH desk (priority 120)") != std::string::npos);
  CHECK(tip.ages == "last frame 1.0 s ago, changed 2.0 s ago");
  // A level that is not that of now has no value in real units; what was taken over is no sender's.
  changes.levels[slot] = 3;
  desk.take({1, 8}, 7, levels);
  tip = tip_of_slot(desk, input, 0, slot, changes, input.now_ns);
  CHECK(tip.means[0].find("): ") == std::string::npos);
  CHECK(tip.from == "taken over in this window");
  // Nobody's.
  CHECK(tip_of_slot(desk, input, 0, 511, changes, input.now_ns).means.empty());
}

}  // namespace
}  // namespace footlight::tools
