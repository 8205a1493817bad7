#include "tools/footlight/hand_levels.h"

#include <algorithm>

#include "fixtures/encode.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

struct Kind {
  fixtures::uint param;
  const char* name;
  bool starts_at_top;  // otherwise in the middle, or at 0 where that is in reach
};

constexpr Kind kKinds[] = {
    {fixtures::kParamDimmer, "dimmer", true}, {fixtures::kParamRed, "red", true},
    {fixtures::kParamGreen, "green", true},   {fixtures::kParamBlue, "blue", true},
    {fixtures::kParamPan, "pan", false},      {fixtures::kParamTilt, "tilt", false},
    {fixtures::kParamZoom, "zoom", false},    {fixtures::kParamGobo, "gobo", false},
};

// Where the functions of the mode that set the parameter begin and end together; from > to where there is none.
Fader reach(const fixtures::Mode& mode, const Kind& kind) {
  Fader fader{kind.param, kind.name, 1e30, -1e30, 0};
  for (const fixtures::Channel& channel : mode.channels) {
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (function.param != kind.param) continue;
      fader.from = std::min({fader.from, function.physical_from, function.physical_to});
      fader.to = std::max({fader.to, function.physical_from, function.physical_to});
    }
  }
  return fader;
}

}  // namespace

HandLevels::HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig), compiled_(compiled), levels_(compiled.universes.size() * kSlotCountMax), faders_(rig.fixtures.size()) {
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const fixtures::PatchedFixture& fixture = rig.fixtures[i];
    const fixtures::Mode& mode =
        rig.types[static_cast<std::size_t>(fixture.type)].modes[static_cast<std::size_t>(fixture.mode)];
    const auto slots = slots_of(fixture);
    fixtures::encode_defaults(rig, fixture, slots);
    fixtures::encode_param(rig, fixture, fixtures::kParamShutter, 1, slots);
    for (const Kind& kind : kKinds) {
      const Fader fader = reach(mode, kind);
      if (!(fader.from < fader.to)) continue;
      faders_[i].push_back(fader);
      const bool has_zero = fader.from <= 0 && fader.to >= 0;
      set(i, kind.param, kind.starts_at_top ? fader.to : has_zero ? 0 : (fader.from + fader.to) / 2);
    }
  }
}

std::span<std::uint8_t> HandLevels::slots_of(const fixtures::PatchedFixture& fixture) {
  const auto at = std::lower_bound(compiled_.universes.begin(), compiled_.universes.end(), fixture.universe);
  FL_CHECK(at != compiled_.universes.end() && *at == fixture.universe);
  const auto index = static_cast<std::size_t>(at - compiled_.universes.begin());
  return std::span(levels_).subspan(index * kSlotCountMax, kSlotCountMax);
}

void HandLevels::set(std::size_t index, fixtures::uint param, double value) {
  for (Fader& fader : faders_[index]) {
    if (fader.param != param) continue;
    fader.value = std::clamp(value, fader.from, fader.to);
    fixtures::encode_param(rig_, rig_.fixtures[index], param, fader.value, slots_of(rig_.fixtures[index]));
  }
}

}  // namespace footlight::tools
