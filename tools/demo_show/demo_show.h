// The show of --demo: one minute for the embedded rig, composed from the rig's own tables, so that it follows any
// change of patch or mode. A pure function of time. It begins and ends dark, so it repeats without a jump.
#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "sim/core/dmx.h"

namespace footlight::demo {

inline constexpr double kShowLengthS = 60.0;
inline constexpr int kShowRateHz = 44;

// Values for one fixture at one moment. Parameters that its type lacks are ignored.
struct Cue {
  double dimmer = 0;       // 0 to 1, before the dimmer law
  glm::dvec3 color{1};     // linear RGB of the emitters, 0 to 1
  glm::dvec3 target_m{0};  // the point that the beam hits
  double zoom_deg = 12;    // full angle
  int gobo = 0;
  double gobo_spin_hz = 0;
  double strobe_hz = 0;  // 0: open
};

// The role of a fixture. Groups are ordered from the left of the stage to the right.
enum class Group { kProfile, kTrussWash, kFloorWash, kFrontPar, kSidePar };

struct Player {
  Group group = Group::kProfile;
  int index = 0;    // within the group, from the left
  int pair = 0;     // 0: the innermost pair of the group
  double side = 0;  // -1 at the left end of the group, 1 at the right
  int fixture = 0;  // index into Rig::fixtures
  glm::dvec3 position_m{0};
};

class DemoShow {
 public:
  // `rig` must outlive the show.
  explicit DemoShow(const fixtures::Rig& rig);

  // In use, ascending.
  [[nodiscard]] const std::vector<Universe>& universes() const { return universes_; }
  // The levels of all universes at t_s, any finite number; the show repeats outside 0 to kShowLengthS. One Slots for
  // each of universes().
  void levels_at(double t_s, std::span<Slots> levels) const;
  // The cue that levels_at() encodes, for one fixture.
  [[nodiscard]] Cue cue(const Player& player, double t_s) const;
  [[nodiscard]] const std::vector<Player>& players() const { return players_; }

 private:
  const fixtures::Rig& rig_;
  std::vector<Universe> universes_;
  std::vector<Player> players_;
};

// Pan and tilt, rad, that point the beam of a head with this hanging rotation along `direction` (stage space, not
// zero). Of the two solutions, the one with pan within a quarter turn.
struct PanTilt {
  double pan;
  double tilt;
};
[[nodiscard]] PanTilt aim(const fixtures::PatchedFixture& fixture, const glm::dvec3& direction);

}  // namespace footlight::demo
