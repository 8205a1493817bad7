// What shines in a scene besides beams and lasers.
#pragma once

#include <string>

#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

struct OtherLight {
  bool displays = false;  // any pixel of any display, at the levels of the scene
  bool sun = false;       // through panes
  [[nodiscard]] bool any() const { return displays || sun; }
};
[[nodiscard]] OtherLight other_light(const Scene& scene);

// "2 fixtures, 3 displays": what is in the scene, lit or not. Empty: nothing that could shine.
[[nodiscard]] std::string lights_of(const fixtures::Rig& rig);

}  // namespace footlight::tools
