// From slots to channels of fixtures, and back. Made once for a compiled rig; read-only after that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/model/rig.h"

namespace footlight::tools {

// A channel of a fixture of a rig: index into Rig::fixtures, and into Mode::channels.
struct ChannelKey {
  int fixture = 0;
  int channel = 0;
  auto operator<=>(const ChannelKey&) const = default;
};

// What one byte of a universe does for one fixture.
struct SlotUse {
  ChannelKey key;
  int byte = 0;  // of the channel, 0 is the most significant
};

// Where a channel is in the levels of a rig (universes x 512 bytes, in the order of CompiledRig::universes).
struct ChannelPlace {
  Universe universe = 0;
  Address address = 0;  // of its most significant byte
  std::array<std::uint32_t, 4> slots{};
  int byte_count = 0;
};

class RigIndex {
 public:
  // Both outlive this.
  RigIndex(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

  // All uses of a slot, in patch order; empty: no fixture uses it. `universe` counts in CompiledRig::universes.
  [[nodiscard]] std::span<const SlotUse> uses(std::size_t universe, std::size_t slot) const;
  // Nothing if the channel is virtual, or its fixture or break has no address.
  [[nodiscard]] std::optional<ChannelPlace> place(ChannelKey key) const;

  // The channel's raw value; its default where it has no place.
  [[nodiscard]] std::uint32_t read(ChannelKey key, std::span<const std::uint8_t> levels) const;
  // Does nothing where it has no place.
  void write(ChannelKey key, std::uint32_t raw, std::span<std::uint8_t> levels) const;
  [[nodiscard]] const fixtures::Channel& channel(ChannelKey key) const;
  [[nodiscard]] std::size_t channel_count(int fixture) const;

 private:
  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::vector<std::uint32_t> first_;  // of each slot's uses in uses_; one more at the end
  std::vector<SlotUse> uses_;
};

}  // namespace footlight::tools
