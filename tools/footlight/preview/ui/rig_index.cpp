#include "tools/footlight/preview/ui/rig_index.h"

#include <algorithm>

#include "fixtures/simulate/encode.h"

namespace footlight::tools {

using fixtures::Channel;

RigIndex::RigIndex(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig),
      compiled_(compiled),
      first_(compiled.universes.size() * kSlotCountMax + 1) {
  const auto for_each = [&](const auto& act) {
    for (std::size_t f = 0; f < rig_.fixtures.size(); ++f) {
      const int fixture = static_cast<int>(f);
      for (std::size_t c = 0; c < channel_count(fixture); ++c) {
        const ChannelKey key{fixture, static_cast<int>(c)};
        const auto at = place(key);
        for (int b = 0; at && b < at->byte_count; ++b) act(at->slots[static_cast<std::size_t>(b)], SlotUse{key, b});
      }
    }
  };
  for_each([&](std::uint32_t slot, const SlotUse&) { ++first_[slot + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  uses_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for_each([&](std::uint32_t slot, const SlotUse& use) { uses_[next[slot]++] = use; });
}

std::span<const SlotUse> RigIndex::uses(std::size_t universe, std::size_t slot) const {
  const std::size_t at = universe * kSlotCountMax + slot;
  return std::span(uses_).subspan(first_[at], first_[at + 1] - first_[at]);
}

std::optional<ChannelPlace> RigIndex::place(ChannelKey key) const {
  const fixtures::PatchedFixture& fixture = rig_.fixtures[static_cast<std::size_t>(key.fixture)];
  const Channel& one = channel(key);
  if (!fixture.patched || one.slot_offsets.empty()) return std::nullopt;
  const auto start = fixtures::break_start(fixture, one);
  if (!start) return std::nullopt;
  const auto at = std::lower_bound(compiled_.universes.begin(), compiled_.universes.end(), start->universe);
  if (at == compiled_.universes.end() || *at != start->universe) return std::nullopt;
  const auto universe = static_cast<std::size_t>(at - compiled_.universes.begin());
  ChannelPlace place;
  place.universe = start->universe;
  place.byte_count = static_cast<int>(std::min<std::size_t>(one.slot_offsets.size(), place.slots.size()));
  place.address = start->address + one.slot_offsets.front();
  for (int b = 0; b < place.byte_count; ++b) {
    const int slot = slot_of_address(start->address) + one.slot_offsets[static_cast<std::size_t>(b)];
    if (slot < 0 || slot >= kSlotCountMax) return std::nullopt;
    place.slots[static_cast<std::size_t>(b)] =
        static_cast<std::uint32_t>(universe * kSlotCountMax + static_cast<std::size_t>(slot));
  }
  return place;
}

std::uint32_t RigIndex::read(ChannelKey key, std::span<const std::uint8_t> levels) const {
  const auto at = place(key);
  if (!at) return channel(key).default_value;
  std::uint32_t raw = 0;
  for (int b = 0; b < at->byte_count; ++b) {
    const std::uint32_t slot = at->slots[static_cast<std::size_t>(b)];
    raw = raw << 8 | (slot < levels.size() ? levels[slot] : 0u);
  }
  return raw;
}

void RigIndex::write(ChannelKey key, std::uint32_t raw, std::span<std::uint8_t> levels) const {
  const auto at = place(key);
  for (int b = 0; at && b < at->byte_count; ++b) {
    const std::uint32_t slot = at->slots[static_cast<std::size_t>(b)];
    if (slot < levels.size()) levels[slot] = static_cast<std::uint8_t>(raw >> (8 * (at->byte_count - 1 - b)));
  }
}

const Channel& RigIndex::channel(ChannelKey key) const {
  return fixtures::mode_of(rig_, rig_.fixtures[static_cast<std::size_t>(key.fixture)])
      .channels[static_cast<std::size_t>(key.channel)];
}

std::size_t RigIndex::channel_count(int fixture) const {
  return fixtures::mode_of(rig_, rig_.fixtures[static_cast<std::size_t>(fixture)]).channels.size();
}

}  // namespace footlight::tools
