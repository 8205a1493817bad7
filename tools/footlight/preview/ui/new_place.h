// Where new fixtures hang at first.
#pragma once

#include <glm/glm.hpp>

#include "fixtures/edit/rig_edits.h"
#include "fixtures/model/rig.h"

namespace footlight::tools {

// Amid those of the rig, to 10 cm.
[[nodiscard]] inline glm::dvec3 new_place(const fixtures::Rig& rig) {
  if (rig.fixtures.empty()) return {0, 0, 4};
  glm::dvec3 sum(0);
  for (const fixtures::PatchedFixture& each : rig.fixtures) sum += fixtures::position_of(each);
  return glm::round(sum / static_cast<double>(rig.fixtures.size()) * 10.0) / 10.0;
}

}  // namespace footlight::tools
