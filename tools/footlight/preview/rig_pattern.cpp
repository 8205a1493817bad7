#include "tools/footlight/preview/rig_pattern.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/ui/rig_index.h"

namespace footlight::tools {
namespace {

void darken(HandLevels& hand, std::size_t fixture) {
  const std::span<const Fader> faders = hand.faders(fixture);
  const auto has = [&](std::string_view attribute) {
    return std::any_of(faders.begin(), faders.end(), [&](const Fader& one) { return one.attribute == attribute; });
  };
  for (const std::string_view dimmer : {"Dimmer", "HSB_Brightness"}) {
    if (has(dimmer)) return hand.set(fixture, dimmer, 0);
  }
  std::vector<std::string_view> colours;
  for (const Fader& one : faders) {
    if (one.attribute.starts_with("ColorAdd_") || one.attribute.starts_with("ColorRGB_")) {
      colours.push_back(one.attribute);
    }
  }
  for (const std::string_view colour : colours) hand.set(fixture, colour, 0);
}

}  // namespace

PatternPlan rig_pattern(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                        std::span<const Universe> universes) {
  PatternPlan plan;
  plan.universes.assign(universes.begin(), universes.end());
  plan.levels.resize(universes.size() * kSlotCountMax);
  const HandLevels lit(rig, compiled);
  HandLevels dark(rig, compiled);
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) darken(dark, i);

  // The place of a level of the rig in the plan.
  const auto planned = [&](std::uint32_t slot) -> std::optional<std::uint32_t> {
    const Universe universe = compiled.universes[slot / kSlotCountMax];
    const auto at = std::lower_bound(universes.begin(), universes.end(), universe);
    if (at == universes.end() || *at != universe) return std::nullopt;
    return static_cast<std::uint32_t>(at - universes.begin()) * kSlotCountMax + slot % kSlotCountMax;
  };
  for (std::uint32_t slot = 0; slot < lit.levels().size(); ++slot) {
    if (const auto index = planned(slot)) plan.levels[*index] = lit.levels()[slot];
  }
  const RigIndex index(rig, compiled);
  for (std::size_t f = 0; f < rig.fixtures.size(); ++f) {
    std::vector<PatternSlot> voice;
    for (std::size_t c = 0; c < index.channel_count(static_cast<int>(f)); ++c) {
      const auto place = index.place({static_cast<int>(f), static_cast<int>(c)});
      for (int byte = 0; place && byte < place->byte_count; ++byte) {
        const std::uint32_t slot = place->slots[static_cast<std::size_t>(byte)];
        const auto at = planned(slot);
        if (at && lit.levels()[slot] != dark.levels()[slot]) {
          voice.push_back({*at, dark.levels()[slot], lit.levels()[slot]});
        }
      }
    }
    if (!voice.empty()) plan.voices.push_back(std::move(voice));
  }
  return plan;
}

}  // namespace footlight::tools
