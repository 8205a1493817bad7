// Where the beam of a fixture goes, and the pan and tilt that send it to a point of the stage. No Dear ImGui.
//
// The angles are computed in closed form for a joint that moves another one, then again from where the lens is with
// them, until the lens moves less than 1e-6 m, at most eight times: tests/tools/footlight/beam_aim_test.cpp has the
// error, which is that of the channels' steps, and the cost. A definition whose joints are sheared or scaled unequally
// is aimed beside the point.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "tools/footlight/preview/ui/stage_rays.h"
#include "tools/footlight/preview/ui/ui_state.h"

namespace footlight::tools {

class BeamAim {
 public:
  // Both outlive this.
  BeamAim(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);
  ~BeamAim();
  BeamAim(const BeamAim&) = delete;
  BeamAim& operator=(const BeamAim&) = delete;

  // From the middle of the lens, where the levels send the beam: of the fixture's first head that pans or tilts, else
  // of its first one. Nothing if it has no beam. levels: universes x 512, in the order of the compiled rig.
  [[nodiscard]] std::optional<StageRay> beam_of(int fixture, std::span<const std::uint8_t> levels);
  // Whether the fixture has channels that pan or tilt a head.
  [[nodiscard]] bool moves(int fixture) const;

  struct Angles {
    std::optional<double> pan_deg;  // nothing: this axis does not move
    std::optional<double> tilt_deg;
    double off_rad = 0;  // between the beam and the way to the point: > 0 if the point is out of reach
  };
  // The angles within the ranges of the channels that come nearest to the point; of several, those that the head
  // reaches with the least turning. Nothing if moves() is false or the point is at the lens.
  [[nodiscard]] std::optional<Angles> angles_to(int fixture, const glm::dvec3& point_m,
                                                std::span<const std::uint8_t> levels);
  // How many beams were computed so far: what the calls cost.
  [[nodiscard]] std::size_t computed() const;

 private:
  struct State;
  struct Head;
  [[nodiscard]] std::optional<std::size_t> head_of(int fixture) const;
  [[nodiscard]] Head posed(std::size_t head, std::span<const std::uint8_t> levels);

  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::unique_ptr<State> state_;
};

// Takes pan and tilt of these fixtures over, so that their beams go to a point.
struct AimCommand {
  TakeChannels command;
  int aimed = 0;
  int left = 0;        // fixtures without pan, tilt or address
  double off_rad = 0;  // the largest of BeamAim::Angles
};
[[nodiscard]] AimCommand aim_command(BeamAim& aim, const fixtures::Rig& rig, const RigIndex& index,
                                     std::span<const int> which, const glm::dvec3& point_m,
                                     std::span<const std::uint8_t> levels);

// Turns fixtures themselves, each about its hanging point, so that their beams go to a point: those that do not move a
// head. Fails if none of them is such a fixture.
[[nodiscard]] Result<fixtures::RigEdit> turn_to_point(BeamAim& aim, const fixtures::Rig& edited,
                                                      std::span<const int> which, const glm::dvec3& point_m,
                                                      std::span<const std::uint8_t> levels);

}  // namespace footlight::tools
