// The levels of a rig over time, split at every moment at which one of them changes. Between two such moments the
// levels are constant, so every step of the fixtures is exact and pictures do not depend on their rate. Changes that
// only pixels of displays read need no step: pass_over().
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/vrsl_compat.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/level_changes.h"
#include "tools/footlight/pictures/log_changes.h"

namespace footlight::tools {

class Timeline {
 public:
  // `compiled` is only read here. vrsl: processes the changes for the rig's VRSL fixtures; usually nullptr. start_ns:
  // the first position; the levels are 0 there. `changes` must outlive this.
  Timeline(LevelChanges& changes, const fixtures::CompiledRig& compiled,
           std::optional<fixtures::VrslReplay> vrsl = std::nullopt, TimeNs start_ns = 0);
  // Of levels that are held from 0 on: universes x 512 bytes in the rig's order.
  Timeline(std::span<const std::uint8_t> held, const fixtures::CompiledRig& compiled);
  // Of a log: from 0 to duration_ns().
  Timeline(LogReader reader, const fixtures::CompiledRig& compiled,
           std::optional<fixtures::VrslReplay> vrsl = std::nullopt);

  // Changes of these universes (one entry for each of the rig's) make no step of their own: they are in the levels of
  // the next one. For those that only pixels of displays read (fixtures/displays/pixel_slots.h): pixels show the newest
  // levels and have no states, and walls have thousands of universes. Ignored if it is all of them.
  void pass_over(std::vector<bool> universes);

  // levels: universes x 512 bytes in the rig's order, held for dt_ns. new_exposure: a picture's exposure begins.
  using Step = std::function<void(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure)>;

  // Steps from the current position to until_ns; the last exposure_ns are the exposure of a picture. until_ns must not
  // be before the last call's. After the last change the levels are held.
  Status advance(TimeNs until_ns, DurationNs exposure_ns, const Step& step);

  // Steps to the first change, of those that make steps, of the levels at or after from_ns, but not beyond until_ns. False: there is none, and it
  // stands at the last change before. advance() to any later time then makes the same steps as without this call.
  Result<bool> advance_to_change(TimeNs from_ns, TimeNs until_ns, const Step& step);

  // A moment of a log that it has come to, for going back to it.
  struct Position {
    TimeNs now_ns = 0;
    std::vector<std::uint8_t> levels;
    bool stepped = false;
  };
  // Whether it reads a log, and each moment follows from the levels at it: not with VRSL's fixtures, whose levels
  // depend on those before.
  [[nodiscard]] bool can_go() const { return log_ != nullptr && !vrsl_; }
  [[nodiscard]] Position position() const { return {now_ns_, levels_, stepped_}; }
  // To a position of a timeline of the same log and rig. Only if can_go().
  Status go_to(const Position& position);

  // To a time of the log with its levels, as if they had come then for the first time: fixtures do not know what was
  // before. Only if can_go().
  Status start_at(TimeNs time_ns);

  // Levels that are held until the next change: universes x 512 bytes in the rig's order.
  void hold(std::span<const std::uint8_t> levels);

  [[nodiscard]] TimeNs now_ns() const { return now_ns_; }
  [[nodiscard]] DurationNs duration_ns() const { return duration_ns_; }  // of the log; 0 without one

 private:
  Timeline(const fixtures::CompiledRig& compiled, std::optional<fixtures::VrslReplay> vrsl, TimeNs start_ns);
  Status advance_to(TimeNs until_ns, bool new_exposure, const Step& step);
  Status read_next();
  void take_next();
  [[nodiscard]] bool makes_step() const;  // the next change
  void give(DurationNs dt_ns, bool new_exposure, const Step& step);

  std::unique_ptr<LogChanges> log_;  // if it reads one
  LevelChanges* changes_ = nullptr;
  std::optional<fixtures::VrslReplay> vrsl_;
  std::vector<std::uint8_t> levels_;
  std::vector<bool> passed_over_;  // empty: none
  LevelChange next_;               // universe -1: none read yet
  TimeNs now_ns_ = 0;
  DurationNs duration_ns_ = 0;
  bool stepped_ = false;
};

// A rig with its tables, and the timeline of the log that drives it; none without a log.
struct DrivenRig {
  fixtures::CompiledRig compiled;
  std::optional<Timeline> timeline;
};

// Compiles the rig. One with VRSL fixtures and a log becomes, in `rig` as well, what VRSL shows of it.
[[nodiscard]] Result<DrivenRig> compile_driven(fixtures::Rig& rig, std::optional<LogReader> log);

}  // namespace footlight::tools
