// Controls of the inspector that set several channels at once: a pad for pan and tilt, and a colour picker. Dear ImGui.
#pragma once

#include <array>
#include <optional>

#include <glm/glm.hpp>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

class InspectorControls {
 public:
  // Of the fixture that was selected last; they set all selected ones. simulated_deg: pan and tilt of its head now.
  void draw(UiDesk& desk, const UiInput& input, int lead, const std::optional<glm::dvec2>& simulated_deg);

 private:
  void draw_pad(UiDesk& desk, const UiInput& input, int lead, const std::optional<glm::dvec2>& simulated_deg);
  void draw_colour(UiDesk& desk, const UiInput& input, int lead);

  std::array<float, 3> screen_rgb_{};  // of the picker while it is used: hues of black stay
  bool picks_ = false;
};

}  // namespace footlight::tools
