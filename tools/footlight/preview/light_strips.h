// The light of groups of fixtures over a log, as colours: one strip for each type of fixture, the largest groups first.
//
// A colour is the mean light of the heads of the group over the time since the moment before, as the walker computes it
// (tools/footlight/trace): with dimmers, shutters, colour mixing and colour wheels. Of a large group some heads are
// taken, evenly spread over the patch.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "sim/core/clock.h"
#include "tools/footlight/trace/head_trace.h"

namespace footlight::tools {

class LightStrips {
 public:
  static constexpr std::size_t kStripsMax = 6;  // fixtures of other types are left out
  static constexpr std::size_t kHeadsMax = 24;  // of a strip

  struct Strip {
    std::string name;
    std::size_t fixtures = 0;
    std::vector<std::size_t> heads;  // that are taken, ascending
    std::vector<glm::vec3> colours;  // linear RGB, 0 to 1; one for each of times()
  };

  // Both outlive this.
  LightStrips(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);
  // levels: universes x 512 in the order of the compiled rig. Times ascend; others are ignored.
  void add(TimeNs at_ns, std::span<const std::uint8_t> levels);
  [[nodiscard]] const std::vector<Strip>& strips() const { return strips_; }
  [[nodiscard]] const std::vector<TimeNs>& times() const { return times_; }

 private:
  HeadTrace trace_;
  std::vector<Strip> strips_;
  std::vector<TimeNs> times_;
};

}  // namespace footlight::tools
