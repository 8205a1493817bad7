// The levels of a rig over time, read from a log and cut at every moment at which one of them changes. Between two such
// moments the levels are constant, so every step of the fixtures is exact and pictures do not depend on how often they
// are taken.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/rig.h"
#include "fixtures/vrsl_compat.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight::tools {

class Timeline {
 public:
  // Takes over the reader. Universes that the rig does not use are skipped; `compiled` is only read here.
  // vrsl: what comes between the log and the rig's VRSL fixtures; usually nothing.
  Timeline(LogReader reader, const fixtures::CompiledRig& compiled,
           std::optional<fixtures::VrslReplay> vrsl = std::nullopt);

  // levels: universes x 512 bytes in the rig's order, held for dt_ns. new_exposure: a picture's exposure begins.
  using Step = std::function<void(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure)>;

  // Steps from where the timeline stands (0 at first) to until_ns, of which the last exposure_ns are the exposure of a
  // picture. until_ns must not lie before the last call's. Past the end of the log the last look is held.
  Status advance(DurationNs until_ns, DurationNs exposure_ns, const Step& step);

  [[nodiscard]] DurationNs now_ns() const { return now_ns_; }
  [[nodiscard]] DurationNs duration_ns() const { return reader_.info().duration_ns; }
  [[nodiscard]] const LogInfo& info() const { return reader_.info(); }

 private:
  Status fetch();
  void apply();
  Status advance_to(DurationNs until_ns, bool new_exposure, const Step& step);
  void give(DurationNs dt_ns, bool new_exposure, const Step& step);

  LogReader reader_;
  std::optional<fixtures::VrslReplay> vrsl_;
  std::vector<Universe> universes_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint8_t> next_levels_;  // of the frame that comes next
  int next_universe_ = -1;                 // index into universes_; -1: the log has ended
  DurationNs next_ns_ = 0;
  DurationNs now_ns_ = 0;
  bool fetched_ = false;
  bool stepped_ = false;
};

}  // namespace footlight::tools
