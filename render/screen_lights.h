// The light of displays that are screens of fixtures, as the fixtures' channels dim it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fixtures/displays/screen_dimmers.h"
#include "render/resources.h"

namespace footlight::render {

class ScreenLights {
 public:
  ScreenLights() = default;  // dims nothing
  ScreenLights(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);
  // Writes what has changed to the rows of the displays. levels: universes x 512 bytes; empty: all are 0. The commands
  // of the record() before must be finished.
  void record(VkCommandBuffer commands, RigTables& rig, std::span<const std::uint8_t> levels);

 private:
  struct Screen {
    std::size_t display = 0;
    glm::dvec3 full_cd_m2{0};  // of white, undimmed
    double share = -1;        // in the row now; -1: not yet written
  };
  fixtures::ScreenDimmers dimmers_;
  std::vector<Screen> screens_;  // one each of dimmers_.displays()
  std::vector<std::uint8_t> none_;
};

}  // namespace footlight::render
