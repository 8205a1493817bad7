// Levels set by hand: faders for what a fixture can do, written through its own channels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fixtures/rig.h"

namespace footlight::tools {

// One parameter of one fixture, in SI (fixtures/shared/tables.h).
struct Fader {
  fixtures::uint param = 0;
  const char* name = "";
  double from = 0;
  double to = 1;
  double value = 0;
};

class HandLevels {
 public:
  // Every fixture at its defaults, lit white, its axes in the middle of their ways. Both outlive this.
  HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

  // universes x 512 bytes in the rig's order.
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }
  // The faders of fixture `index`, in a fixed order; those that its mode has no channel for are left out.
  [[nodiscard]] std::span<const Fader> faders(std::size_t index) const { return faders_[index]; }
  [[nodiscard]] std::size_t fixture_count() const { return faders_.size(); }
  // Fixtures without the parameter are left alone.
  void set(std::size_t index, fixtures::uint param, double value);

 private:
  [[nodiscard]] std::span<std::uint8_t> slots_of(const fixtures::PatchedFixture& fixture);

  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::vector<Fader>> faders_;  // a row a fixture
};

}  // namespace footlight::tools
