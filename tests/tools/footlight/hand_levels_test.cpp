#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "fixtures/files/import/import.h"
#include "fixtures/model/color.h"
#include "fixtures/simulate/machines.h"
#include "fixtures/simulate/walker.h"
#include "tools/footlight/preview/hand_levels.h"

namespace footlight::tools {
namespace {

struct Demo {
  const fixtures::Rig& rig = fixtures::demo_rig();
  fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  HandLevels hand{rig, compiled};

  // The states that the levels give, with motors at their targets.
  [[nodiscard]] fixtures::f64::Walker walk() const {
    fixtures::f64::Walker walker(compiled);
    walker.step(hand.levels(), 0);
    return walker;
  }
};

const Fader* find(const HandLevels& hand, std::size_t index, std::string_view attribute) {
  for (const Fader& fader : hand.faders(index)) {
    if (fader.attribute == attribute) return &fader;
  }
  return nullptr;
}

TEST_CASE("every fixture of a rig without input starts lit white") {
  const Demo demo;
  const auto walker = demo.walk();
  for (std::size_t i = 0; i < demo.rig.fixtures.size(); ++i) {
    CAPTURE(demo.rig.fixtures[i].name);
    CHECK(walker.states[i].red > 0.9);
    CHECK(walker.states[i].green > 0.9);
    CHECK(walker.states[i].blue > 0.9);
  }
}

TEST_CASE("emitters that add up to violet at full start at a white, with the one that is needed most at full") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (fixtures::FixtureType& type : rig.types) {
    const int first = static_cast<int>(type.emitters.size());
    type.emitters.push_back({.name = "Red", .color = {0.69, 0.30, 16}});
    type.emitters.push_back({.name = "Green", .color = {0.17, 0.70, 33}});
    type.emitters.push_back({.name = "Blue", .color = {0.15, 0.04, 12}});
    for (fixtures::Mode& mode : type.modes) {
      for (fixtures::Channel& channel : mode.channels) {
        for (fixtures::ChannelFunction& function : channel.functions) {
          if (function.attribute == "ColorAdd_R") function.emitter = first;
          if (function.attribute == "ColorAdd_G") function.emitter = first + 1;
          if (function.attribute == "ColorAdd_B") function.emitter = first + 2;
        }
      }
    }
  }
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  HandLevels hand(rig, compiled);
  fixtures::f64::Walker walker(compiled);
  walker.step(hand.levels(), 0);
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    if (find(hand, i, "ColorAdd_B") == nullptr) continue;
    CAPTURE(rig.fixtures[i].name);
    CHECK(walker.states[i].red == doctest::Approx(walker.states[i].green).epsilon(0.02));
    CHECK(walker.states[i].blue == doctest::Approx(walker.states[i].green).epsilon(0.02));
    CHECK(find(hand, i, "ColorAdd_G")->value == doctest::Approx(1));
    CHECK(find(hand, i, "ColorAdd_B")->value < 0.4);
  }
}

// The demo rig with emitters of these colours, in beams of this colour temperature (0: the white of the screen).
fixtures::Rig demo_with(const std::array<fixtures::ColorXyY, 3>& colors, double temperature_k) {
  fixtures::Rig rig = fixtures::demo_rig();
  constexpr std::array<const char*, 3> kNames = {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"};
  for (fixtures::FixtureType& type : rig.types) {
    const int first = static_cast<int>(type.emitters.size());
    for (std::size_t e = 0; e < 3; ++e) type.emitters.push_back({.name = kNames[e], .color = colors[e]});
    for (fixtures::Beam& beam : type.beams) beam.color_temperature_k = temperature_k;
    for (fixtures::Mode& mode : type.modes) {
      for (fixtures::Channel& channel : mode.channels) {
        for (fixtures::ChannelFunction& function : channel.functions) {
          for (std::size_t e = 0; e < 3; ++e) {
            if (function.attribute == kNames[e]) function.emitter = first + static_cast<int>(e);
          }
        }
      }
    }
  }
  return rig;
}

// The largest distance of a mixing fixture from a chromaticity.
double worst_from(const fixtures::Rig& rig, const fixtures::ColorXyY& target) {
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  fixtures::f64::Walker walker(compiled);
  walker.step(hand.levels(), 0);
  double worst = 0;
  int seen = 0;
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    if (find(hand, i, "ColorAdd_B") == nullptr) continue;
    ++seen;
    const auto& state = walker.states[compiled.head_first[i]];
    const auto color = fixtures::to_xyy(fixtures::rgb_to_xyz({state.red, state.green, state.blue}));
    CHECK(state.red + state.green + state.blue > 0.05);
    worst = std::max(worst, std::hypot(color.x - target.x, color.y - target.y));
  }
  CHECK(seen > 0);
  return worst;
}

// Narrow-band LEDs. Y has the blue of a mode that makes CMY; at full they are x 0.21 y 0.11, violet.
constexpr std::array<fixtures::ColorXyY, 3> kNarrow = {
    {{0.702, 0.297, 10.8}, {0.168, 0.689, 20.6}, {0.152, 0.0257, 7.69}}};

TEST_CASE("emitters whose file has their colours start at the white of the beam's colour temperature") {
  for (const double temperature_k : {3200.0, 5600.0, 8000.0}) {
    CAPTURE(temperature_k);
    CHECK(worst_from(demo_with(kNarrow, temperature_k), fixtures::black_body(temperature_k)) < 0.006);
  }
  // A beam without a colour temperature is as white as the screen.
  CHECK(worst_from(demo_with(kNarrow, 0), {0.3127, 0.3290, 100}) < 0.006);
}

TEST_CASE("a white that the emitters cannot reach gives the nearest one that they can") {
  // Amber, cyan and blue: the white of 5600 K is beyond the edge from amber to cyan.
  const std::array<fixtures::ColorXyY, 3> colors = {{{0.57, 0.42, 40}, {0.17, 0.20, 30}, {0.15, 0.05, 5}}};
  const fixtures::Rig rig = demo_with(colors, 5600);
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  REQUIRE(find(hand, 0, "ColorAdd_B") != nullptr);
  CHECK(find(hand, 0, "ColorAdd_B")->value == 0);
  CHECK(find(hand, 0, "ColorAdd_R")->value > 0);
  CHECK(find(hand, 0, "ColorAdd_G")->value > 0);
  CHECK(worst_from(rig, fixtures::black_body(5600)) < 0.05);
}

TEST_CASE("red, green and blue of a file without their colours start at full") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (fixtures::FixtureType& type : rig.types) {
    for (fixtures::Beam& beam : type.beams) beam.color_temperature_k = 3200;
  }
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  for (const char* emitter : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) {
    REQUIRE(find(hand, 0, emitter) != nullptr);
    CHECK(find(hand, 0, emitter)->value == doctest::Approx(1));
  }
}

TEST_CASE("modes of a real profile that add colours start at the white of its modes that filter them") {
  const char* data = std::getenv("FOOTLIGHT_TEST_DATA");
  const std::string path = fmt::format("{}/fixtures/gdtf/Robe@Robin_T1_Profile.gdtf", data == nullptr ? "" : data);
  const auto imported = fixtures::import_fixture(path);
  if (!imported) {
    MESSAGE("SKIPPED: no Robe@Robin_T1_Profile.gdtf below $FOOTLIGHT_TEST_DATA");
    return;
  }
  std::vector<fixtures::ColorXyY> whites;
  for (std::size_t m = 0; m < imported->type.modes.size(); ++m) {
    fixtures::Rig rig;
    rig.types = {imported->type};
    fixtures::PatchedFixture fixture;
    fixture.mode = static_cast<int>(m);
    rig.fixtures = {fixture};
    give_hand_addresses(rig);
    const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
    const HandLevels hand(rig, compiled);
    fixtures::f64::Walker walker(compiled);
    walker.step(hand.levels(), 0);
    const auto& state = walker.states[0];
    whites.push_back(fixtures::to_xyy(fixtures::rgb_to_xyz({state.red, state.green, state.blue})));
  }
  REQUIRE(whites.size() == 5);  // CMY, reduced CMY, RGBAL, RGB, reduced RGB; its CTC has some 5700 K by default
  for (const fixtures::ColorXyY& white : whites) {
    CHECK(std::hypot(white.x - whites[0].x, white.y - whites[0].y) < 0.006);
  }
}

// A room with a hazer and a fog machine, or one of them.
fixtures::Rig room_with(const std::vector<std::string>& attributes) {
  fixtures::Rig rig;
  for (const std::string& attribute : attributes) {
    fixtures::FixtureType type;
    type.name = type.id = attribute;
    fixtures::Mode mode;
    mode.name = "M";
    mode.slot_count = 1;
    fixtures::ChannelFunction function;
    function.name = function.attribute = attribute;
    fixtures::Channel channel;
    channel.name = attribute;
    channel.slot_offsets = {0};
    channel.functions = {function};
    mode.channels = {channel};
    type.modes = {mode};
    fixtures::PatchedFixture fixture;
    fixture.patched = false;
    fixture.type = static_cast<int>(rig.types.size());
    rig.types.push_back(type);
    rig.fixtures.push_back(fixture);
  }
  give_hand_addresses(rig);
  return rig;
}

TEST_CASE("haze and fog machines start at the level that finally gives the room 0.02 per metre") {
  for (const std::vector<std::string>& machines :
       {std::vector<std::string>{"Haze1"}, {"Fog1"}, {"Haze1", "Fog1"}, {"Haze1", "Haze1", "Haze1"}}) {
    CAPTURE(machines.size());
    CAPTURE(machines.front());
    const fixtures::Rig rig = room_with(machines);
    const auto made = fixtures::compile(rig);
    REQUIRE_MESSAGE(made, (made ? "" : made.error().message));
    const fixtures::CompiledRig& compiled = *made;
    const HandLevels hand(rig, compiled);
    const auto air = fixtures::MachineAir::make(rig, compiled);
    REQUIRE(air != nullptr);
    air->settle(hand.levels());
    CHECK(air->scattering_per_m() > 0.9 * kHandHazePerM);  // to 8 bits
    CHECK(air->scattering_per_m() < 1.1 * kHandHazePerM);
  }
}

TEST_CASE("a fog machine that is only off or at full starts off") {
  fixtures::Rig rig = room_with({"Fog1"});
  auto& functions = rig.types[0].modes[0].channels[0].functions;
  functions.push_back(functions[0]);
  functions[0].dmx_to = 127;
  functions[0].physical_from = functions[0].physical_to = 0;
  functions[1].dmx_from = 128;
  functions[1].physical_from = functions[1].physical_to = 1;
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  CHECK(hand.levels()[0] < 128);
}

TEST_CASE("fixtures with any single emitter start lit, and tints are not part of a white") {
  for (const char* emitter : {"ColorAdd_W", "ColorAdd_WW", "ColorAdd_CW", "ColorAdd_RY", "ColorAdd_UV"}) {
    for (const bool alone : {true, false}) {
      CAPTURE(emitter);
      CAPTURE(alone);
      fixtures::Rig rig = fixtures::demo_rig();
      for (fixtures::FixtureType& type : rig.types) {
        for (fixtures::Mode& mode : type.modes) {
          for (fixtures::Channel& channel : mode.channels) {
            for (fixtures::ChannelFunction& function : channel.functions) {
              if (function.attribute == "ColorAdd_R") function.attribute = emitter;
              if (alone && function.attribute.starts_with("ColorAdd_") && function.attribute != emitter)
                function.attribute = "NoFeature";
            }
          }
        }
      }
      const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
      const HandLevels hand(rig, compiled);
      fixtures::f64::Walker walker(compiled);
      walker.step(hand.levels(), 0);
      int seen = 0;
      for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
        const Fader* fader = find(hand, i, emitter);
        if (fader == nullptr) continue;
        ++seen;
        CHECK(walker.states[i].red + walker.states[i].green + walker.states[i].blue > 0.05);
        const std::string_view name = emitter;
        const bool tint = name == "ColorAdd_RY" || name == "ColorAdd_UV";
        CHECK(fader->value == (tint && !alone ? 0 : 1));
      }
      CHECK(seen > 0);
    }
  }
}

// The demo rig with a change to every channel of this name, and the start level of the first fixture's.
template <class Change>
int first_level(const char* name, const Change& change) {
  fixtures::Rig rig = fixtures::demo_rig();
  for (fixtures::FixtureType& type : rig.types) {
    for (fixtures::Mode& mode : type.modes) {
      for (fixtures::Channel& channel : mode.channels) {
        if (channel.name == name) change(channel);
      }
    }
  }
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  const fixtures::PatchedFixture& fixture = rig.fixtures[0];
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    if (channel.name != name) continue;
    return hand.levels()[static_cast<std::size_t>(fixture.address - 1 + channel.slot_offsets[0])];
  }
  return -1;
}

TEST_CASE("a fixture that only a strobe can open starts with its slowest strobe") {
  const auto level = [](bool opens) {
    return first_level("Shutter", [&](fixtures::Channel& channel) {
      for (fixtures::ChannelFunction& function : channel.functions) {
        if (!opens && function.attribute == "Shutter1" && function.physical_from == 1) function.attribute = "NoFeature";
      }
    });
  };
  CHECK(level(true) > 31);
  CHECK(level(true) < 64);
  CHECK(level(false) == 64);  // 0.5 Hz of 0.5 to 25
}

TEST_CASE("lamps start struck if a channel can strike them, and are not doused if it can only douse") {
  const auto level = [](bool strikes) {
    return first_level("Red", [&](fixtures::Channel& channel) {
      fixtures::ChannelFunction douse = channel.functions[0];
      douse.attribute = "LampControl";
      douse.physical_from = douse.physical_to = 0;
      douse.dmx_to = 99;
      fixtures::ChannelFunction strike = douse;
      strike.dmx_from = 100;
      strike.dmx_to = 255;
      strike.physical_from = strike.physical_to = 1;
      if (!strikes) strike.attribute = "NoFeature";
      channel.functions = {douse, strike};
      channel.default_value = 200;
    });
  };
  CHECK(level(true) == 177);
  CHECK(level(false) == 200);
}

TEST_CASE("a colour wheel without an open slot starts at the slot that passes most light") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (fixtures::FixtureType& type : rig.types) {
    for (fixtures::Wheel& wheel : type.wheels) {  // its gobos become colours
      for (std::size_t s = 0; s < wheel.slots.size(); ++s)
        wheel.slots[s] = {.name = "Colour", .color = {0.3, 0.3, s == 2 ? 40.0 : 5.0}};
    }
    for (fixtures::Mode& mode : type.modes) {
      for (fixtures::Channel& channel : mode.channels) {
        for (fixtures::ChannelFunction& function : channel.functions) {
          if (function.attribute == "Gobo1") function.attribute = "Color1";
        }
      }
    }
  }
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  const HandLevels hand(rig, compiled);
  int seen = 0;
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const Fader* fader = find(hand, i, "Color1");
    if (fader == nullptr) continue;
    ++seen;
    CHECK(fader->value == 3);
  }
  CHECK(seen > 0);
}

TEST_CASE("a fixture decodes the value of a fader, to the resolution of its channel") {
  Demo demo;
  const Fader* pan = find(demo.hand, 0, "Pan");
  REQUIRE(pan != nullptr);
  demo.hand.set(0, "Pan", 30);
  demo.hand.set(0, "ColorAdd_B", 0);
  CHECK(pan->value == 30);
  const auto walker = demo.walk();
  CHECK(walker.states[0].pan == doctest::Approx(30 * 3.14159265 / 180).epsilon(1e-3));
  CHECK(walker.states[0].blue == 0);
  CHECK(walker.states[1].blue > 0.9);
  CHECK(std::abs(walker.states[1].pan) < 1e-3);
}

TEST_CASE("a fader is limited to its range") {
  Demo demo;
  const Fader* tilt = find(demo.hand, 0, "Tilt");
  REQUIRE(tilt != nullptr);
  demo.hand.set(0, "Tilt", 1000);
  CHECK(tilt->value == tilt->to);
  demo.hand.set(0, "Tilt", -1000);
  CHECK(tilt->value == tilt->from);
}

TEST_CASE("a fixture has no fader without a channel in its mode, and setting it changes nothing") {
  Demo demo;
  const std::size_t par = demo.rig.fixtures.size() - 1;
  CHECK(find(demo.hand, par, "Pan") == nullptr);
  const std::vector<std::uint8_t> before(demo.hand.levels().begin(), demo.hand.levels().end());
  demo.hand.set(par, "Pan", 90);
  CHECK(std::equal(before.begin(), before.end(), demo.hand.levels().begin()));
}

TEST_CASE("a fixture without an address has no fader and changes no other fixture's levels") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (fixture.universe != 1) fixture.patched = false;  // so that the rig does not have its universe either
  }
  const fixtures::CompiledRig compiled = fixtures::compile(rig).value();
  HandLevels hand(rig, compiled);
  CHECK(hand.levels().size() == compiled.universes.size() * kSlotCountMax);
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    CHECK(hand.faders(i).empty() != rig.fixtures[i].patched);
    if (!rig.fixtures[i].patched) hand.set(i, "Dimmer", 1);
  }
}

TEST_CASE("with faders every fixture without an address gets slots that no other fixture uses, and is lit") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (std::size_t i = 0; i < rig.fixtures.size(); i += 2) rig.fixtures[i].patched = false;
  const fixtures::Rig before = rig;
  give_hand_addresses(rig);
  const auto compiled = fixtures::compile(rig);  // refuses slots that two fixtures share
  REQUIRE(compiled.has_value());
  const HandLevels hand(rig, *compiled);
  fixtures::f64::Walker walker(*compiled);
  walker.step(hand.levels(), 0);
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    CHECK(rig.fixtures[i].patched);
    CHECK(walker.states[i].red > 0.9);
    if (!before.fixtures[i].patched) continue;
    CHECK(rig.fixtures[i].universe == before.fixtures[i].universe);
    CHECK(rig.fixtures[i].address == before.fixtures[i].address);
  }
}

TEST_CASE("fixtures without an address get no slot of a pixel") {
  fixtures::Rig rig = fixtures::demo_rig();
  for (auto& fixture : rig.fixtures) fixture.patched = false;
  fixtures::Display display;
  display.columns = display.rows = 20;  // 400 pixels: universes 1 to 3
  display.map.emplace();
  rig.displays.push_back(display);
  give_hand_addresses(rig);
  for (const auto& fixture : rig.fixtures) CHECK(fixture.universe >= 4);
}

}  // namespace
}  // namespace footlight::tools
