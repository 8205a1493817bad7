#include "tools/footlight/hand_levels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fixtures/encode.h"
#include "fixtures/machines.h"
#include "fixtures/params.h"
#include "fixtures/walker.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

enum class Start {
  kTop,
  kMakesWhite,  // at the top
  kTint,        // at the top where the mode has nothing that makes white, else at 0
  kRest,        // in the middle, or at 0 where that is in reach, or at the slot of a wheel that leaves most light
};

struct Kind {
  const char* attribute;
  const char* name;
  const char* unit;
  Start start;
};

constexpr Kind kKinds[] = {
    {"Dimmer", "dimmer", "%", Start::kTop},
    {"HSB_Brightness", "brightness", "%", Start::kTop},
    {"HSB_Hue", "hue", "deg", Start::kRest},
    {"HSB_Saturation", "saturation", "%", Start::kRest},
    {"ColorAdd_R", "red", "%", Start::kMakesWhite},
    {"ColorAdd_G", "green", "%", Start::kMakesWhite},
    {"ColorAdd_B", "blue", "%", Start::kMakesWhite},
    {"ColorRGB_Red", "red", "%", Start::kMakesWhite},
    {"ColorRGB_Green", "green", "%", Start::kMakesWhite},
    {"ColorRGB_Blue", "blue", "%", Start::kMakesWhite},
    {"ColorAdd_W", "white", "%", Start::kMakesWhite},
    {"ColorAdd_WW", "warm white", "%", Start::kMakesWhite},
    {"ColorAdd_CW", "cold white", "%", Start::kMakesWhite},
    {"ColorAdd_RY", "amber", "%", Start::kTint},
    {"ColorAdd_Y", "yellow", "%", Start::kTint},
    {"ColorAdd_GY", "lime", "%", Start::kTint},
    {"ColorAdd_GC", "blue green", "%", Start::kTint},
    {"ColorAdd_C", "cyan", "%", Start::kTint},
    {"ColorAdd_BC", "light blue", "%", Start::kTint},
    {"ColorAdd_BM", "purple", "%", Start::kTint},
    {"ColorAdd_M", "magenta", "%", Start::kTint},
    {"ColorAdd_RM", "pink", "%", Start::kTint},
    {"ColorAdd_UV", "ultraviolet", "%", Start::kTint},
    {"ColorSub_C", "cyan", "%", Start::kRest},
    {"ColorSub_M", "magenta", "%", Start::kRest},
    {"ColorSub_Y", "yellow", "%", Start::kRest},
    {"Color1", "colour", "", Start::kRest},
    {"Color2", "colour 2", "", Start::kRest},
    {"Pan", "pan", "deg", Start::kRest},
    {"Tilt", "tilt", "deg", Start::kRest},
    {"Zoom", "zoom", "deg", Start::kRest},
    {"Focus1", "focus", "%", Start::kRest},
    {"Iris", "iris", "%", Start::kTop},
    {"Gobo1", "gobo", "", Start::kRest},
    {"Gobo1Pos", "gobo turn", "deg", Start::kRest},
    {"Gobo2", "gobo 2", "", Start::kRest},
    {"AnimationWheel1", "animation", "", Start::kRest},
    {"Prism1", "prism", "", Start::kRest},
    {"Frost1", "frost", "%", Start::kRest},
    {"Blade1A", "blade below", "%", Start::kRest},
    {"Blade2A", "blade left", "%", Start::kRest},
    {"Blade3A", "blade above", "%", Start::kRest},
    {"Blade4A", "blade right", "%", Start::kRest},
    {"Haze1", "haze", "%", Start::kRest},
    {"Fog1", "fog", "%", Start::kRest},
    {"Fan1", "fan", "%", Start::kTop},
    {"Blower1", "blower", "%", Start::kTop},
};

// How much of the light a slot leaves, more or less: for choosing one.
double clearness(const fixtures::FixtureType& type, const fixtures::WheelSlot& slot) {
  if (slot.open) return 200;
  const bool filters = slot.filter != fixtures::kNoIndex;
  const double luminance = filters ? type.filters[static_cast<std::size_t>(slot.filter)].color.Y : slot.color.Y;
  return slot.image.empty() && slot.facets.empty() ? luminance : -1;
}

// Where the functions of the mode that have the attribute begin and end together, from > to where there is none; its
// value is where it starts.
Fader reach(const fixtures::FixtureType& type, const fixtures::Mode& mode, const Kind& kind) {
  Fader fader{kind.attribute, kind.name, kind.unit, 1e30, -1e30, 0};
  double clearest = -1e30;
  const auto take = [&](double value) {
    fader.from = std::min(fader.from, value);
    fader.to = std::max(fader.to, value);
  };
  for (const fixtures::Channel& channel : mode.channels) {
    if (channel.slot_offsets.empty()) continue;  // no hand reaches it
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (!fixtures::same_attribute(function.attribute, kind.attribute)) continue;
      bool selects = false;
      for (const fixtures::ChannelSet& set : function.sets) {
        if (set.wheel_slot < 1) continue;
        take(set.wheel_slot);
        selects = true;
        const fixtures::Wheel* wheel =
            function.wheel == fixtures::kNoIndex ? nullptr : &type.wheels[static_cast<std::size_t>(function.wheel)];
        const auto index = static_cast<std::size_t>(set.wheel_slot - 1);
        const double its = wheel != nullptr && index < wheel->slots.size() ? clearness(type, wheel->slots[index]) : 0;
        if (its <= clearest) continue;
        clearest = its;
        fader.value = set.wheel_slot;
      }
      if (selects) continue;
      take(function.physical_from);
      take(function.physical_to);
    }
  }
  const bool has_zero = fader.from <= 0 && fader.to >= 0;
  if (kind.start == Start::kTop || kind.start == Start::kMakesWhite) {
    fader.value = fader.to;
  } else if (fader.unit[0] == '\0') {
    fader.value = std::max(fader.value, fader.from);
  } else {
    fader.value = has_zero ? 0 : (fader.from + fader.to) / 2;
  }
  return fader;
}

// Where a channel says so; some only douse.
void strike(const fixtures::Rig& rig, const fixtures::PatchedFixture& fixture, std::span<std::uint8_t> slots) {
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (!fixtures::same_attribute(function.attribute, "LampControl") || function.physical_from != 1) continue;
      fixtures::encode_raw(fixture, channel, function.dmx_from + (function.dmx_to - function.dmx_from) / 2, slots);
    }
  }
}

// Where nothing but a strobe lets light out, that flashes as slowly as it can.
void open_shutter(const fixtures::Rig& rig, const fixtures::PatchedFixture& fixture, std::span<std::uint8_t> slots) {
  bool opens = false;
  double slowest_hz = 1e30;
  const auto look = [&](const std::string& attribute, double from, double to) {
    if (fixtures::same_attribute(attribute, "Shutter1")) opens = opens || std::max(from, to) >= 1;
    if (fixtures::same_attribute(attribute, "Shutter1Strobe")) slowest_hz = std::min({slowest_hz, from, to});
  };
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    for (const fixtures::ChannelFunction& function : channel.functions)
      look(function.attribute, function.physical_from, function.physical_to);
  }
  if (opens || slowest_hz > 1e3) {
    fixtures::encode_attribute(rig, fixture, "Shutter1", 1, slots);
  } else {
    fixtures::encode_attribute(rig, fixture, "Shutter1Strobe", slowest_hz, slots);
  }
}

}  // namespace

void give_hand_addresses(fixtures::Rig& rig) {
  Universe universe = kUniverseMin;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.patched) continue;
    universe = std::max(universe, fixture.universe + 1);
    for (const auto& further : fixture.further_addresses) universe = std::max(universe, further.universe + 1);
  }
  Address next = 1;
  for (fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (fixture.patched) continue;
    const fixtures::Mode& mode = fixtures::mode_of(rig, fixture);
    const int first = fixtures::slot_count_of(mode, 1);
    int all = first;
    for (const auto& [dmx_break, count] : mode.break_slot_counts) all += dmx_break > 1 ? count : 0;
    const int wanted = std::min(std::max(all <= kSlotCountMax ? all : first, 1), kSlotCountMax);
    if (next + wanted - 1 > kSlotCountMax) {
      ++universe;
      next = 1;
    }
    if (universe > kUniverseMax) return;  // more than 32 million slots: the rest stays as it is
    fixture.patched = true;
    fixture.universe = universe;
    fixture.address = next;
    fixture.further_addresses.clear();
    if (all <= kSlotCountMax) {
      Address at = next + first;
      for (const auto& [dmx_break, count] : mode.break_slot_counts) {
        if (dmx_break < 2 || count < 1) continue;
        fixture.further_addresses.push_back({dmx_break, universe, at});
        at += count;
      }
    }
    next += wanted;
  }
}

HandLevels::HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig), compiled_(compiled), levels_(compiled.universes.size() * kSlotCountMax), faders_(rig.fixtures.size()) {
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const fixtures::PatchedFixture& fixture = rig.fixtures[i];
    if (!fixture.patched) continue;  // it stands at its channels' defaults: no level reaches it
    const fixtures::Mode& mode = fixtures::mode_of(rig, fixture);
    const auto slots = slots_of(fixture);
    fixtures::encode_defaults(rig, fixture, slots);
    strike(rig, fixture, slots);  // first: some share a channel with the shutter
    open_shutter(rig, fixture, slots);
    bool makes_white = false;
    for (const Kind& kind : kKinds) {
      Fader fader = reach(rig.types[static_cast<std::size_t>(fixture.type)], mode, kind);
      if (!(fader.from < fader.to)) continue;
      if (fixtures::concerns_device_only(kind.attribute) && !fixtures::is_of_machine(mode, kind.attribute)) continue;
      makes_white = makes_white || kind.start == Start::kMakesWhite;
      if (kind.start == Start::kTint && !makes_white) fader.value = fader.to;
      faders_[i].push_back(fader);
      set(i, kind.attribute, fader.value);
    }
  }
  balance();
}

// Red, green and blue of makers' files at full add up to what they add up to, often violet. What each of them adds is
// asked of the model itself, at half and at full beside the others: there light is linear in them, while alone each
// lies outside of what a screen shows and is brought inside.
void HandLevels::balance() {
  static constexpr std::array<std::string_view, 3> kEmitters = {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"};
  const auto mixes = [&](const std::vector<Fader>& faders) {
    return std::any_of(faders.begin(), faders.end(),
                       [](const Fader& fader) { return fader.attribute == kEmitters[0]; });
  };
  if (std::none_of(faders_.begin(), faders_.end(), mixes)) return;  // no rig is walked for nothing
  const auto light = [&] {
    fixtures::f64::Walker walker(compiled_);
    walker.step(levels_, 0);
    std::vector<glm::dvec3> of_fixtures(rig_.fixtures.size(), glm::dvec3(0));
    for (std::size_t i = 0; i < walker.states.size(); ++i) {
      const auto fixture = static_cast<std::size_t>(compiled_.heads[i].fixture);
      const auto& state = walker.states[i];
      // All heads of a fixture hear one fader: the first that is lit stands for them.
      if (of_fixtures[fixture] == glm::dvec3(0)) of_fixtures[fixture] = {state.red, state.green, state.blue};
    }
    return of_fixtures;
  };
  const auto set_all = [&](std::string_view attribute, double share) {
    for (std::size_t i = 0; i < faders_.size(); ++i) set_share(i, attribute, share);
  };
  const auto full = light();
  std::array<std::vector<glm::dvec3>, 3> half;
  for (std::size_t e = 0; e < kEmitters.size(); ++e) {
    set_all(kEmitters[e], 0.5);
    half[e] = light();
    set_all(kEmitters[e], 1);
  }
  for (std::size_t i = 0; i < faders_.size(); ++i) {
    const glm::dmat3 emitted(2.0 * (full[i] - half[0][i]), 2.0 * (full[i] - half[1][i]), 2.0 * (full[i] - half[2][i]));
    if (!(std::abs(glm::determinant(emitted)) > 1e-9)) continue;  // not three colours
    const glm::dvec3 others = full[i] - emitted * glm::dvec3(1);
    const glm::dmat3 wanted = glm::inverse(emitted);
    const glm::dvec3 rising = wanted * glm::dvec3(1);
    const glm::dvec3 offset = wanted * others;
    if (!glm::all(glm::greaterThan(rising, glm::dvec3(0)))) continue;  // white is outside their triangle
    const glm::dvec3 reach_t = (glm::dvec3(1) + offset) / rising;
    const glm::dvec3 shares = glm::clamp(std::min({reach_t.x, reach_t.y, reach_t.z}) * rising - offset, 0.0, 1.0);
    for (int e = 0; e < 3; ++e) set_share(i, kEmitters[static_cast<std::size_t>(e)], shares[e]);
  }
}

void HandLevels::set_share(std::size_t index, std::string_view attribute, double share) {
  for (const Fader& fader : faders_[index]) {
    if (fader.attribute == attribute) set(index, attribute, fader.from + share * (fader.to - fader.from));
  }
}

std::span<std::uint8_t> HandLevels::slots_of(const fixtures::PatchedFixture& fixture) {
  const auto at = std::lower_bound(compiled_.universes.begin(), compiled_.universes.end(), fixture.universe);
  FL_CHECK(at != compiled_.universes.end() && *at == fixture.universe);
  const auto index = static_cast<std::size_t>(at - compiled_.universes.begin());
  return std::span(levels_).subspan(index * kSlotCountMax, kSlotCountMax);
}

void HandLevels::set(std::size_t index, std::string_view attribute, double value) {
  for (Fader& fader : faders_[index]) {
    if (fader.attribute != attribute) continue;
    fader.value = std::clamp(value, fader.from, fader.to);
    fixtures::encode_attribute(rig_, rig_.fixtures[index], attribute, fader.value, slots_of(rig_.fixtures[index]));
  }
}

bool HandLevels::encode(std::size_t index, std::string_view attribute, double value) {
  const fixtures::PatchedFixture& fixture = rig_.fixtures[index];
  return fixture.patched && fixtures::encode_attribute(rig_, fixture, attribute, value, slots_of(fixture));
}

}  // namespace footlight::tools
