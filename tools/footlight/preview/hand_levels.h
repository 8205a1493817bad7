// Levels set by hand: faders for what a fixture can do, written through its own channels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/result.h"

namespace footlight::tools {

// One attribute of one fixture, in the units of fixtures/model/fixture_type.h.
struct Fader {
  std::string_view attribute;
  const char* name = "";
  const char* unit = "";  // "%": of 0 to 1; "deg"; "": a wheel's slot, from 1
  double from = 0;
  double to = 1;
  double value = 0;
};

// Gives every fixture without an address one of its own, in universes behind all that are in use, so that hands reach
// it. For what nobody else drives: on a wire these addresses mean nothing.
void give_hand_addresses(fixtures::Rig& rig);

// Scattering that machines bring into the room when they begin, 1/m: what a rig has that states no haze.
inline constexpr double kHandHazePerM = 0.02;

class HandLevels {
 public:
  // Every fixture at its defaults, lit, its axes in the middle of their ways. Red, green and blue make the fixture's
  // own white: the mix nearest to its beam's colour temperature where the file states the colours of the emitters, else
  // what they give at full. Haze and fog machines run at the level that gives the room kHandHazePerM in the end. Both
  // outlive this.
  HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

  // universes x 512 bytes in the rig's order.
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }
  // The faders of fixture `index`, in a fixed order; those that its mode has no channel for are left out.
  [[nodiscard]] std::span<const Fader> faders(std::size_t index) const { return faders_[index]; }
  [[nodiscard]] std::size_t fixture_count() const { return faders_.size(); }
  // Fixtures without the attribute are left alone.
  void set(std::size_t index, std::string_view attribute, double value);
  // Any attribute, with a fader or without; false where the fixture has no channel for it.
  bool encode(std::size_t index, std::string_view attribute, double value);

 private:
  void balance();
  void fill_room();
  void set_share(std::size_t index, std::string_view attribute, double share);
  [[nodiscard]] std::span<std::uint8_t> slots_of(const fixtures::PatchedFixture& fixture);

  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::vector<Fader>> faders_;  // a row a fixture
};

// Carries out a word of --set: "Prism1=2" for all fixtures, "Spot 3:Pan=30" for one, in the units of the attribute; a
// wheel's slots count from 1.
Status set_by_hand(const std::string& text, const fixtures::Rig& rig, HandLevels& hand);

}  // namespace footlight::tools
