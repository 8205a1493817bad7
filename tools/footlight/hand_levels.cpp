#include "tools/footlight/hand_levels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fixtures/encode.h"
#include "fixtures/params.h"
#include "fixtures/walker.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

struct Kind {
  const char* attribute;
  const char* name;
  const char* unit;
  bool starts_at_top;  // otherwise in the middle, or at 0 where that is in reach, or at the first slot of a wheel
};

constexpr Kind kKinds[] = {
    {"Dimmer", "dimmer", "%", true},
    {"ColorAdd_R", "red", "%", true},
    {"ColorAdd_G", "green", "%", true},
    {"ColorAdd_B", "blue", "%", true},
    {"ColorRGB_Red", "red", "%", true},
    {"ColorRGB_Green", "green", "%", true},
    {"ColorRGB_Blue", "blue", "%", true},
    {"ColorAdd_W", "white", "%", true},
    {"ColorSub_C", "cyan", "%", false},
    {"ColorSub_M", "magenta", "%", false},
    {"ColorSub_Y", "yellow", "%", false},
    {"Color1", "colour", "", false},
    {"Pan", "pan", "deg", false},
    {"Tilt", "tilt", "deg", false},
    {"Zoom", "zoom", "deg", false},
    {"Focus1", "focus", "%", false},
    {"Iris", "iris", "%", true},
    {"Gobo1", "gobo", "", false},
    {"Gobo1Pos", "gobo turn", "deg", false},
    {"Gobo2", "gobo 2", "", false},
    {"AnimationWheel1", "animation", "", false},
    {"Prism1", "prism", "", false},
    {"Frost1", "frost", "%", false},
    {"Blade1A", "blade below", "%", false},
    {"Blade2A", "blade left", "%", false},
    {"Blade3A", "blade above", "%", false},
    {"Blade4A", "blade right", "%", false},
};

// Where the functions of the mode that have the attribute begin and end together; from > to where there is none.
Fader reach(const fixtures::Mode& mode, const Kind& kind) {
  Fader fader{kind.attribute, kind.name, kind.unit, 1e30, -1e30, 0};
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
        if (set.wheel_slot > 0) take(set.wheel_slot);
        selects = selects || set.wheel_slot > 0;
      }
      if (selects) continue;
      take(function.physical_from);
      take(function.physical_to);
    }
  }
  return fader;
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
    fixtures::encode_attribute(rig, fixture, "Shutter1", 1, slots);
    for (const Kind& kind : kKinds) {
      const Fader fader = reach(mode, kind);
      if (!(fader.from < fader.to)) continue;
      faders_[i].push_back(fader);
      const bool has_zero = fader.from <= 0 && fader.to >= 0;
      const bool is_wheel = fader.unit[0] == '\0';
      set(i, kind.attribute,
          kind.starts_at_top ? fader.to
          : is_wheel         ? fader.from
          : has_zero         ? 0
                             : (fader.from + fader.to) / 2);
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
