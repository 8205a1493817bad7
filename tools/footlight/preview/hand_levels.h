// Levels set by faders, written through the channels of each fixture.
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
  const char* unit = "";  // "%": of 0 to 1; "°"; "": a wheel's slot, from 1
  double from = 0;
  double to = 1;
  double value = 0;
};

// Gives every fixture without an address one, in universes after all that are in use, so that faders can set its
// levels. Only for rigs without an input: the addresses have no meaning outside this program.
void give_hand_addresses(fixtures::Rig& rig);

// Scattering of the haze from machines at the start, 1/m: the default of a rig without [haze].
inline constexpr double kHandHazePerM = 0.02;

class HandLevels {
 public:
  // Starts with every fixture at its defaults, lit, with its axes in the middle. Red, green and blue make the fixture's
  // own white: the mix nearest to its beam's colour temperature if the file has the colours of the emitters, else all
  // at full. Haze and fog machines run at the level that finally gives the room kHandHazePerM. `rig` and `compiled`
  // must outlive this.
  HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

  // universes x 512 bytes in the rig's order.
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }
  // The faders of fixture `index`, in a fixed order, without those for which its mode has no channel.
  [[nodiscard]] std::span<const Fader> faders(std::size_t index) const { return faders_[index]; }
  [[nodiscard]] std::size_t fixture_count() const { return faders_.size(); }
  // Does nothing if the fixture does not have the attribute.
  void set(std::size_t index, std::string_view attribute, double value);
  // Sets any attribute, with a fader or without; false if the fixture has no channel for it.
  bool encode(std::size_t index, std::string_view attribute, double value);

 private:
  void balance();
  void fill_room();
  void set_share(std::size_t index, std::string_view attribute, double share);
  [[nodiscard]] std::span<std::uint8_t> slots_of(const fixtures::PatchedFixture& fixture);

  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::vector<Fader>> faders_;  // one row per fixture
};

// Applies an argument of --set: "Prism1=2" for all fixtures, "Spot 3:Pan=30" for one, in the units of the attribute.
// Slots of a wheel count from 1.
Status set_by_hand(const std::string& text, const fixtures::Rig& rig, HandLevels& hand);

}  // namespace footlight::tools
