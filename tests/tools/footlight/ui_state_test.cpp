#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/edit/patch_slots.h"
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
  Exposure exposure;
  PictureLook look;
  bool operator==(const Snapshot&) const = default;
};
Snapshot snapshot(const UiState& state) {
  return {state.selection, state.taken, state.camera.camera().position_m, state.exposure, state.look};
}

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
    switch (random() % 9) {
      case 0: desk.select(fixture, random() % 2 == 0); break;
      case 1: desk.select_all(); break;
      case 2: desk.take({fixture, static_cast<int>(random() % 3)}, random() % 256, dark(desk)); break;
      case 3: desk.release({fixture, static_cast<int>(random() % 3)}, dark(desk)); break;
      case 4: desk.release_all(); break;
      case 5: desk.set_exposure({static_cast<float>(random() % 4), random() % 2 == 0}); break;
      case 6:
        desk.set_look({random() % 2 == 0 ? render::ToneCurve::kAgx : render::ToneCurve::kLinear, random() % 2 == 0,
                       static_cast<float>(3000 + random() % 3), static_cast<float>(random() % 3)});
        break;
      default: {
        OrbitCamera camera = desk.state().camera;
        camera.orbit(0.1, 0.01);
        if (random() % 2 == 0) {
          desk.move_camera(camera);
        } else {
          desk.jump_camera(camera, static_cast<float>(random() % 4));
        }
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
  for (std::uint32_t raw = 1000; raw < 1010; ++raw) desk.take(pan, raw, dark(desk));
  desk.begin_gesture();
  for (std::uint32_t raw = 2000; raw < 2010; ++raw) desk.take(pan, raw, dark(desk));
  CHECK(desk.history().size() == 2);
  CHECK(desk.undo() == "set Pan of Spot 1");
  CHECK(desk.state().taken.at(pan) == 1009);
  desk.undo();
  CHECK(desk.state().taken.empty());
  desk.redo();
  CHECK(desk.state().taken.at(pan) == 1009);
}

TEST_CASE("commands that were carried out are listed with undo and redo, a drag once and one that is cancelled not") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  const ChannelKey pan{0, channel_named(desk, 0, "Pan")};
  desk.begin_gesture();
  desk.select(0, false);
  desk.begin_gesture();
  for (std::uint32_t raw = 1000; raw < 1010; ++raw) desk.take(pan, raw, dark(desk));
  desk.begin_gesture();
  for (int i = 1; i <= 5; ++i) desk.set_exposure({static_cast<float>(i), false});
  desk.begin_gesture();
  desk.set_exposure({5, false});  // as it is
  desk.undo();
  desk.redo();
  desk.begin_gesture();
  desk.take(pan, 7, dark(desk));
  desk.drop_gesture();
  desk.begin_gesture();
  PictureLook look = desk.state().look;
  look.tone = render::ToneCurve::kLinear;
  desk.set_look(look);
  std::string all;
  for (const DoneCommand& done : desk.take_done())
    all += std::to_string(static_cast<int>(done.how)) + " " + done.text + "\n";
  CHECK(all ==
        "0 select Spot 1\n"
        "0 set Pan of Spot 1\n"
        "0 set the exposure to 5.00 EV\n"
        "1 set the exposure to 5.00 EV\n"
        "2 set the exposure to 5.00 EV\n"
        "0 tone curve linear\n");
  CHECK(desk.take_done().empty());
  for (int i = 0; i < 1000; ++i) {
    desk.begin_gesture();
    desk.select(i % 2, false);
  }
  CHECK(desk.take_done().size() == 256);
}

TEST_CASE("two sliders in one gesture are two edits") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.take({0, 0}, 1, dark(desk));
  desk.take({0, 1}, 1, dark(desk));
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

TEST_CASE("twenty thousand steps can be undone and redone") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  constexpr int kSteps = 20'000;
  for (int i = 0; i < kSteps; ++i) {
    desk.begin_gesture();
    desk.select(i % 2, false);
  }
  int undone = 0;
  while (!desk.undo().empty()) ++undone;
  CHECK(undone == kSteps);
  CHECK(desk.state().selection.fixtures.empty());
  int redone = 0;
  while (!desk.redo().empty()) ++redone;
  CHECK(redone == kSteps);
  CHECK(desk.history().bytes() < UiHistory::kBytesMax / 100);
  CHECK(desk.take_news().empty());
}

TEST_CASE("the history needs at most so much memory, and keeps the last command whatever it needs") {
  constexpr std::size_t kBytes = std::size_t{32} << 20;
  UiState state;
  UiHistory history(kBytes);
  const auto select = [&](int count, int first) {
    SelectFixtures command;
    command.after.fixtures.resize(static_cast<std::size_t>(count));
    std::iota(command.after.fixtures.begin(), command.after.fixtures.end(), first);
    history.run(state, std::move(command));
  };
  for (int i = 0; i < 40; ++i) {
    const std::size_t before = history.size();
    select(500'000, i);
    CHECK(history.bytes() >= 500'000 * sizeof(int));
    CHECK(history.bytes() <= kBytes);
    CHECK(history.take_forgot() == (history.size() <= before));
  }
  const std::size_t kept = history.size();
  CHECK(kept > 3);
  CHECK(kept < 20);
  // What is left can be undone.
  while (history.undo(state) != nullptr) {
  }
  CHECK(state.selection.fixtures.front() == 39 - static_cast<int>(kept));
  while (history.redo(state) != nullptr) {
  }
  CHECK(history.size() == kept);
  CHECK(history.bytes() <= 2 * kBytes);
  select(10'000'000, 7);
  CHECK(history.size() == 1);
  CHECK(history.bytes() > kBytes);
  select(0, 0);
  CHECK(history.size() == 1);
  // Of what holds the last one's past.
  CHECK(history.next_undo() != nullptr);
}

TEST_CASE("a drag of all fixtures needs as much memory as its last step") {
  const auto rig = many_fixtures(1000);
  UiDesk desk(rig.rig, rig.compiled);
  desk.select_all();
  const std::size_t before = desk.history().bytes();
  desk.begin_gesture();
  for (std::uint32_t raw = 0; raw < 5; ++raw) desk.take({0, 2}, raw, dark(desk));
  CHECK(desk.history().size() == 2);
  const std::size_t drag = desk.history().bytes() - before;
  CHECK(drag >= 1000 * sizeof(TakeChannels::Edit));
  CHECK(drag < 1000 * sizeof(TakeChannels::Edit) + 1000);
  desk.undo();
  desk.begin_gesture();
  desk.select(1, false);  // forgets the drag
  CHECK(desk.history().bytes() < before + 5000);
}

TEST_CASE("a turn of the wheel after a jump of the camera is another edit") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  OrbitCamera start{fixtures::Camera{}};
  desk.start_view(start, {4, false});
  desk.jump_camera(OrbitCamera({.name = "far", .position_m = {0, -50, 2}}), 9.0f);
  CHECK(desk.state().exposure.ev == 9);
  OrbitCamera nearer = desk.state().camera;
  for (int i = 0; i < 3; ++i) {
    nearer.approach(1);
    desk.move_camera(nearer);
  }
  CHECK(desk.history().size() == 2);
  desk.undo();
  CHECK(desk.state().camera.distance_m() == doctest::Approx(50));
  CHECK(desk.state().exposure.ev == 9);
  desk.undo();
  CHECK(desk.state().camera.distance_m() == doctest::Approx(start.distance_m()));
  CHECK(desk.state().exposure.ev == 4);
  desk.redo();
  CHECK(desk.state().exposure.ev == 9);
}

TEST_CASE("the exposure is undone with the drag that set it, and stays within its limits") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.begin_gesture();
  for (const float ev : {5.0f, 6.0f, 7.0f}) desk.set_exposure({ev, false});
  desk.set_exposure({7, false});
  CHECK(desk.history().size() == 1);
  desk.begin_gesture();
  desk.set_exposure({7, true});
  CHECK(desk.undo() == "automatic exposure");
  CHECK(desk.undo() == "set the exposure to 7.00 EV");
  CHECK(desk.state().exposure == Exposure{});
  desk.set_exposure({1000, false});
  CHECK(desk.state().exposure.ev == kDarkestEv);
  desk.set_exposure({std::nanf(""), false});
  CHECK(desk.state().exposure.ev == kDarkestEv);
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
  CHECK(fixtures::patch_conflicts(rig.rig).empty());
}

TEST_CASE("fixtures that share slots are in conflict with each other, and no others") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures[3].address = rig.fixtures[1].address + 2;
  rig.fixtures[3].shares_address = true;
  const auto shared = compiled_rig(std::move(rig));
  const auto conflicts = fixtures::patch_conflicts(shared.rig);
  REQUIRE(conflicts.size() == 2);  // none of fixture 0
  CHECK(conflicts[0].fixture == 1);
  CHECK(conflicts[0].other == 3);
  CHECK(conflicts[1].fixture == 3);
  CHECK(conflicts[1].other == 1);
}

TEST_CASE("a fixture without an address has no place, and cannot be taken over") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  rig.fixtures[3].patched = false;
  const auto unpatched = compiled_rig(std::move(rig));
  UiDesk desk(unpatched.rig, unpatched.compiled);
  CHECK(!desk.index().place({3, 0}));
  desk.take({3, 0}, 255, dark(desk));
  CHECK(!desk.overlays());
  CHECK(desk.history().size() == 0);
}

TEST_CASE("a value that was taken over replaces the input of all selected fixtures until it is released") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  const int pan = channel_named(desk, 0, "Pan");
  desk.select_named("Spot *");
  CHECK(desk.state().selection.fixtures == std::vector<int>{0, 1, 2});
  desk.take({0, pan}, 0x1234, dark(desk));
  auto levels = dark(desk);
  std::fill(levels.begin(), levels.end(), std::uint8_t{99});
  desk.overlay(levels);
  for (int f = 0; f < 3; ++f) CHECK(desk.index().read({f, pan}, levels) == 0x1234);
  CHECK(std::count(levels.begin(), levels.end(), 99) == static_cast<std::ptrdiff_t>(levels.size()) - 6);
  desk.begin_gesture();
  desk.release({1, pan}, dark(desk));
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
  desk.take({1, 0}, 7, dark(desk));
  CHECK(desk.state().taken.size() == 1);
}

TEST_CASE("fixtures of other types follow by attribute and real value") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.select_all();
  const ChannelKey dimmer{0, channel_named(desk, 0, "Dimmer")};
  desk.take(dimmer, 0x8000, dark(desk));
  const ChannelKey of_par{3, channel_named(desk, 3, "Dimmer")};
  REQUIRE(desk.state().taken.contains(of_par));
  CHECK(desk.state().taken.at(of_par) == 128);
  CHECK(desk.state().taken.size() == 5);
}

// Replaces the channels of a mode by ones of one byte with one function each.
struct OneFunction {
  const char* attribute;
  double from = 0;
  double to = 1;
};
void set_channels(fixtures::Mode& mode, const std::vector<OneFunction>& functions) {
  mode.channels.clear();
  mode.relations.clear();
  for (const OneFunction& one : functions) {
    fixtures::Channel channel;
    channel.name = one.attribute;
    channel.slot_offsets = {static_cast<int>(mode.channels.size())};
    fixtures::ChannelFunction function;
    function.attribute = one.attribute;
    function.physical_from = one.from;
    function.physical_to = one.to;
    channel.functions = {function};
    mode.channels.push_back(channel);
  }
}
fixtures::Mode& mode_of_first(fixtures::Rig& rig, std::size_t fixture) {
  const fixtures::PatchedFixture& one = rig.fixtures[fixture];
  return rig.types[static_cast<std::size_t>(one.type)].modes[static_cast<std::size_t>(one.mode)];
}

TEST_CASE("a release releases all that was taken over with the value, also in other types") {
  // The spots' gobo channel becomes a zoom below and a dimmer above; pars have a dimmer and no zoom.
  fixtures::Rig rig = parsed_rig(kUiRig);
  fixtures::Channel& channel = mode_of_first(rig, 0).channels[8];
  REQUIRE(channel.name == "Gobo");
  fixtures::ChannelFunction zoom = channel.functions[0];
  zoom.attribute = "Zoom";
  zoom.sets.clear();
  zoom.dmx_to = 99;
  zoom.wheel = fixtures::kNoIndex;
  fixtures::ChannelFunction dimmer = zoom;
  dimmer.attribute = "Dimmer";
  dimmer.dmx_from = 100;
  dimmer.dmx_to = 255;
  dimmer.physical_from = 0;
  dimmer.physical_to = 1;
  channel.functions = {zoom, dimmer};
  channel.default_value = 0;
  const auto both = compiled_rig(std::move(rig));
  UiDesk desk(both.rig, both.compiled);
  desk.select_all();
  desk.begin_gesture();
  desk.take({0, 8}, 255, dark(desk));
  const ChannelKey of_par{3, channel_named(desk, 3, "Dimmer")};
  REQUIRE(desk.state().taken.contains(of_par));
  desk.begin_gesture();
  desk.release({0, 8}, dark(desk));
  CHECK(desk.state().taken.empty());
}

TEST_CASE("what a value means is decided by the levels that other channels have now") {
  // The spots' gobo channel is a dimmer while their shutter channel is below 128, else a zoom.
  fixtures::Rig rig = parsed_rig(kUiRig);
  auto& channels = mode_of_first(rig, 0).channels;
  REQUIRE(channels[3].name == "Shutter");
  channels[3].default_value = 255;
  fixtures::Channel& channel = channels[8];
  fixtures::ChannelFunction dimmer = channel.functions[0];
  dimmer.attribute = "Dimmer";
  dimmer.sets.clear();
  dimmer.wheel = fixtures::kNoIndex;
  dimmer.dmx_to = 255;
  dimmer.physical_from = 0;
  dimmer.physical_to = 1;
  dimmer.masters = {{3, 0, 127}};
  fixtures::ChannelFunction zoom = dimmer;
  zoom.attribute = "Zoom";
  zoom.masters = {{3, 128, 255}};
  channel.functions = {dimmer, zoom};
  const auto both = compiled_rig(std::move(rig));
  UiDesk desk(both.rig, both.compiled);
  desk.select_all();
  const ChannelKey of_par{3, channel_named(desk, 3, "Dimmer")};
  auto levels = dark(desk);
  desk.index().write({0, 3}, 255, levels);
  desk.take({0, 8}, 200, levels);
  CHECK(!desk.state().taken.contains(of_par));
  desk.index().write({0, 3}, 10, levels);
  desk.take({0, 8}, 201, levels);
  REQUIRE(desk.state().taken.contains(of_par));
  CHECK(desk.state().taken.at(of_par) == 201);
  desk.begin_gesture();
  desk.release({0, 8}, levels);
  CHECK(!desk.state().taken.contains(of_par));
}

TEST_CASE("a drag through several functions of a channel is undone as a whole") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  fixtures::Channel& channel = mode_of_first(rig, 0).channels[8];
  fixtures::ChannelFunction red = channel.functions[0];
  red.attribute = "ColorAdd_R";
  red.sets.clear();
  red.wheel = fixtures::kNoIndex;
  red.dmx_to = 99;
  red.physical_from = 0;
  red.physical_to = 1;
  fixtures::ChannelFunction dimmer = red;
  dimmer.attribute = "Dimmer";
  dimmer.dmx_from = 100;
  dimmer.dmx_to = 255;
  channel.functions = {red, dimmer};
  const auto both = compiled_rig(std::move(rig));
  UiDesk desk(both.rig, both.compiled);
  desk.select_all();
  const std::size_t before = desk.history().size();
  desk.begin_gesture();
  for (std::uint32_t raw = 0; raw < 256; raw += 15) desk.take({0, 8}, raw, dark(desk));
  for (std::uint32_t raw = 250; raw > 50; raw -= 20) desk.take({0, 8}, raw, dark(desk));
  CHECK(desk.history().size() == before + 1);
  CHECK(desk.state().taken.contains({3, channel_named(desk, 3, "Dimmer")}));
  CHECK(desk.state().taken.contains({3, channel_named(desk, 3, "Red")}));
  const auto reached = desk.state().taken;
  desk.undo();
  CHECK(desk.state().taken.empty());
  desk.redo();
  CHECK(desk.state().taken == reached);
}

TEST_CASE("highlight leaves a head's continuous rotation, its speed, and the channels that choose between them") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  fixtures::Mode& mode = mode_of_first(rig, 0);
  set_channels(mode, {{"Dimmer"},
                      {"Pan", -270, 270},
                      {"PanRotate", -360, 360},
                      {"TiltRotate", -360, 360},
                      {"PositionMSpeed"},
                      {"NoFeature"}});
  mode.channels[2].functions[0].masters = {{5, 128, 255}};
  for (fixtures::Channel& channel : mode.channels) channel.has_highlight = true;
  for (fixtures::Channel& channel : mode.channels) channel.highlight_value = 17;
  const auto spinning = compiled_rig(std::move(rig));
  UiDesk desk(spinning.rig, spinning.compiled);
  desk.select(0, false);
  desk.set_highlight(true);
  auto levels = dark(desk);
  std::fill(levels.begin(), levels.end(), std::uint8_t{200});
  desk.overlay(levels);
  CHECK(desk.index().read({0, 0}, levels) == 17);
  for (int channel = 1; channel < 6; ++channel) {
    INFO(channel);
    CHECK(desk.index().read({0, channel}, levels) == 200);
  }
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
  desk.take({0, channel_named(desk, 0, "Dimmer")}, 0xFFFF, dark(desk));
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
