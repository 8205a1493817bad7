#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/simulate/encode.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/rig_index.h"
#include "tools/footlight/preview/ui/ui_desk.h"
#include "tools/footlight/trace/head_trace.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;

// All that commands edit.
struct Snapshot {
  Selection selection;
  std::map<ChannelKey, std::uint32_t> taken;
  glm::dvec3 camera_m{0};
  bool operator==(const Snapshot&) const = default;
};
Snapshot snapshot(const UiState& state) { return {state.selection, state.taken, state.camera.camera().position_m}; }

int channel_named(const UiDesk& desk, int fixture, std::string_view name) {
  const auto& channels = fixtures::mode_of(desk.rig(), desk.rig().fixtures[static_cast<std::size_t>(fixture)]).channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].name == name) return static_cast<int>(c);
  }
  FAIL("no channel " << name);
  return -1;
}

std::vector<std::uint8_t> dark(const UiDesk& desk) {
  return std::vector<std::uint8_t>(desk.compiled().universes.size() * kSlotCountMax);
}

TEST_CASE("undo gives every state from before, and redo every state after it") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  std::mt19937 random(7);
  std::vector<Snapshot> states{snapshot(desk.state())};
  while (states.size() < 200) {
    desk.begin_gesture();
    const int fixture = static_cast<int>(random() % 4);
    switch (random() % 6) {
      case 0: desk.select(fixture, random() % 2 == 0); break;
      case 1: desk.select_all(); break;
      case 2: desk.take({fixture, static_cast<int>(random() % 3)}, random() % 256); break;
      case 3: desk.release({fixture, static_cast<int>(random() % 3)}); break;
      case 4: desk.release_all(); break;
      default: {
        OrbitCamera camera = desk.state().camera;
        camera.orbit(0.1, 0.01);
        desk.run(MoveCamera{camera, {}});
      }
    }
    if (snapshot(desk.state()) != states.back()) states.push_back(snapshot(desk.state()));
  }
  CHECK(desk.history().size() == states.size() - 1);
  for (std::size_t i = states.size() - 1; i > 0; --i) {
    REQUIRE(snapshot(desk.state()) == states[i]);
    CHECK(!desk.undo().empty());
  }
  CHECK(snapshot(desk.state()) == states.front());
  CHECK(desk.undo().empty());
  for (std::size_t i = 1; i < states.size(); ++i) {
    CHECK(!desk.redo().empty());
    REQUIRE(snapshot(desk.state()) == states[i]);
  }
  CHECK(desk.redo().empty());
}

TEST_CASE("a drag is undone as a whole, and the next drag alone") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  const ChannelKey pan{0, channel_named(desk, 0, "Pan")};
  desk.begin_gesture();
  for (std::uint32_t raw = 1000; raw < 1010; ++raw) desk.take(pan, raw);
  desk.begin_gesture();
  for (std::uint32_t raw = 2000; raw < 2010; ++raw) desk.take(pan, raw);
  CHECK(desk.history().size() == 2);
  CHECK(desk.undo() == "set Pan of Spot 1");
  CHECK(desk.state().taken.at(pan) == 1009);
  desk.undo();
  CHECK(desk.state().taken.empty());
  desk.redo();
  CHECK(desk.state().taken.at(pan) == 1009);
}

TEST_CASE("two sliders in one gesture are two edits") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.take({0, 0}, 1);
  desk.take({0, 1}, 1);
  CHECK(desk.history().size() == 2);
}

TEST_CASE("a command that changes nothing is not remembered, and a new one forgets what was undone") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.select(2, false);
  desk.begin_gesture();
  desk.select(2, false);
  desk.release_all();
  CHECK(desk.history().size() == 1);
  CHECK(desk.undo() == "select Spot 3");
  desk.begin_gesture();
  desk.select(1, false);
  CHECK(desk.history().next_redo() == nullptr);
  CHECK(desk.history().size() == 1);
}

TEST_CASE("the history keeps its last commands only") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  for (std::size_t i = 0; i < UiHistory::kCommandsMax + 5; ++i) {
    desk.begin_gesture();
    desk.select(static_cast<int>(i % 2), false);
  }
  CHECK(desk.history().size() == UiHistory::kCommandsMax);
}

TEST_CASE("every slot of a fixture names its channel, and what is written to a channel is read back") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  const RigIndex index(rig.rig, rig.compiled);
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);
  std::size_t used = 0;
  for (int f = 0; f < static_cast<int>(rig.rig.fixtures.size()); ++f) {
    for (int c = 0; c < static_cast<int>(index.channel_count(f)); ++c) {
      const ChannelKey key{f, c};
      const auto place = index.place(key);
      REQUIRE(place);
      const std::uint32_t raw = 0x9A7Bu & fixtures::raw_max(place->byte_count);
      index.write(key, raw, levels);
      CHECK(index.read(key, levels) == raw);
      for (int b = 0; b < place->byte_count; ++b) {
        const std::uint32_t slot = place->slots[static_cast<std::size_t>(b)];
        const auto uses = index.uses(slot / kSlotCountMax, slot % kSlotCountMax);
        REQUIRE(uses.size() == 1);
        CHECK(uses[0].key == key);
        CHECK(uses[0].byte == b);
        ++used;
      }
      // As the encoder that faders use.
      std::vector<std::uint8_t> own(kSlotCountMax);
      fixtures::encode_raw(rig.rig.fixtures[static_cast<std::size_t>(f)], index.channel(key), raw, own);
      CHECK(own[place->slots[0] % kSlotCountMax] == levels[place->slots[0]]);
    }
  }
  CHECK(used > 40);
  CHECK(index.uses(0, 500).empty());
  CHECK(index.conflict_count() == 0);
}

TEST_CASE("fixtures that share slots are in conflict with each other, and no others") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures[3].address = rig.fixtures[1].address + 2;
  rig.fixtures[3].shares_address = true;
  const auto shared = compiled_rig(std::move(rig));
  const RigIndex index(shared.rig, shared.compiled);
  CHECK(index.conflict(0) == -1);
  CHECK(index.conflict(1) == 3);
  CHECK(index.conflict(3) == 1);
  CHECK(index.conflict_count() == 2);
}

TEST_CASE("a fixture without an address has no place, and cannot be taken over") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures[3].patched = false;
  const auto unpatched = compiled_rig(std::move(rig));
  UiDesk desk(unpatched.rig, unpatched.compiled);
  CHECK(!desk.index().place({3, 0}));
  desk.take({3, 0}, 255);
  CHECK(!desk.overlays());
  CHECK(desk.history().size() == 0);
}

TEST_CASE("a value that was taken over replaces the input of all selected fixtures until it is released") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  const int pan = channel_named(desk, 0, "Pan");
  desk.select_named("Spot *");
  CHECK(desk.state().selection.fixtures == std::vector<int>{0, 1, 2});
  desk.take({0, pan}, 0x1234);
  auto levels = dark(desk);
  std::fill(levels.begin(), levels.end(), std::uint8_t{99});
  desk.overlay(levels);
  for (int f = 0; f < 3; ++f) CHECK(desk.index().read({f, pan}, levels) == 0x1234);
  CHECK(std::count(levels.begin(), levels.end(), 99) == static_cast<std::ptrdiff_t>(levels.size()) - 6);
  desk.begin_gesture();
  desk.release({1, pan});
  CHECK(!desk.overlays());
  desk.undo();
  CHECK(desk.state().taken.size() == 3);
  desk.begin_gesture();
  desk.release_all();
  CHECK(desk.state().taken.empty());
}

TEST_CASE("a fixture that is not selected is taken over alone") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.select(0, false);
  desk.take({1, 0}, 7);
  CHECK(desk.state().taken.size() == 1);
}

TEST_CASE("fixtures of other types follow by attribute and real value") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.select_all();
  const ChannelKey dimmer{0, channel_named(desk, 0, "Dimmer")};
  desk.take(dimmer, 0x8000);
  const ChannelKey of_par{3, channel_named(desk, 3, "Dimmer")};
  REQUIRE(desk.state().taken.contains(of_par));
  CHECK(desk.state().taken.at(of_par) == 128);
  CHECK(desk.state().taken.size() == 5);
}

TEST_CASE("highlight lights the selected fixtures and leaves where they point") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.set_highlight(true);
  CHECK(!desk.overlays());
  desk.select(1, false);
  CHECK(desk.overlays());
  auto levels = dark(desk);
  desk.index().write({1, channel_named(desk, 1, "Pan")}, 4711, levels);
  desk.overlay(levels);
  CHECK(desk.index().read({1, channel_named(desk, 1, "Dimmer")}, levels) == 0xFFFF);
  CHECK(desk.index().read({1, channel_named(desk, 1, "Pan")}, levels) == 4711);
  CHECK(desk.index().read({0, channel_named(desk, 0, "Dimmer")}, levels) == 0);
}

TEST_CASE("a level reads as what it does, in real units") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  const auto& type = fixtures::type_of(rig.rig, rig.rig.fixtures[0]);
  const auto text = [&](const char* channel, std::uint32_t raw) {
    const auto none = [](int) { return 0u; };
    return text_of(reading_of(type, desk.index().channel({0, channel_named(desk, 0, channel)}), raw, none));
  };
  CHECK(text("Pan", 0) == "-270.0\u00b0");
  CHECK(text("Pan", 0xFFFF) == "270.0\u00b0");
  CHECK(text("Dimmer", 0xFFFF) == "100.0 %");
  CHECK(text("Shutter", 223) == "25.00 Hz");
  CHECK(text("Gobo", 90) == "4: star");
}

TEST_CASE("a function counts only while its masters let it") {
  fixtures::FixtureType type;
  fixtures::Channel channel;
  channel.functions.resize(2);
  channel.functions[0].attribute = "Shutter1";
  channel.functions[0].masters = {{1, 10, 20}};
  channel.functions[1].attribute = "Dimmer";
  channel.functions[1].masters = {{1, 21, 30}};
  const auto reading = [&](std::uint32_t master) {
    return reading_of(type, channel, 128, [&](int) { return master; }).function;
  };
  CHECK(reading(15) == &channel.functions[0]);
  CHECK(reading(25) == &channel.functions[1]);
  CHECK(reading(0) == nullptr);
}

TEST_CASE("a head that is followed alone moves as it does among all heads") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  HeadTrace all(rig.rig, rig.compiled);
  HeadTrace one(rig.rig, rig.compiled);
  one.follow({1});
  auto levels = dark(desk);
  for (int step = 0; step < 20; ++step) {
    const ChannelKey pan{1, channel_named(desk, 1, "Pan")};
    desk.index().write(pan, step < 10 ? 20'000 : 60'000, levels);
    all.step(levels, 20 * kNsPerMs, true);
    one.step(levels, 20 * kNsPerMs, true);
    REQUIRE(one.row(1, 0) == all.row(1, 0));
  }
  // It is on its way, so the rows were not all alike.
  CHECK(one.row(1, 0) != one.row(0, 0));
}

TEST_CASE("an empty rig has nothing to select, take over or undo") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures.clear();
  const auto empty = compiled_rig(std::move(rig));
  UiDesk desk(empty.rig, empty.compiled);
  desk.select_all();
  desk.select_named("*");
  desk.release_all();
  desk.set_highlight(true);
  std::vector<std::uint8_t> none;
  desk.overlay(none);
  CHECK(desk.history().size() == 0);
  CHECK(desk.undo().empty());
}

TEST_CASE("all of 10,000 fixtures can be taken over and released at once") {
  const auto rig = many_fixtures(10'000);
  UiDesk desk(rig.rig, rig.compiled);
  desk.select_all();
  desk.take({0, channel_named(desk, 0, "Dimmer")}, 0xFFFF);
  CHECK(desk.state().taken.size() == 10'000);
  auto levels = dark(desk);
  desk.overlay(levels);
  CHECK(desk.index().read({9'999, channel_named(desk, 0, "Dimmer")}, levels) == 0xFFFF);
  desk.begin_gesture();
  desk.release_all();
  CHECK(!desk.overlays());
}

}  // namespace
}  // namespace footlight::tools
