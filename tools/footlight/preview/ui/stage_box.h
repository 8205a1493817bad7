// The rectangle that a drag with Shift or Ctrl draws over the stage, and what it selects. No Dear ImGui.
//
// Shift selects the fixtures in it and nothing else, Ctrl adds them, both together take them away. It begins with a
// press on the stage that belongs to no handle, and selects at the release: one step of undo.
#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {

enum class BoxMode { kOnlyThese, kAdds, kTakesAway };

// The mouse and the picture at one moment.
struct BoxInput {
  StagePlace place;
  glm::dvec2 mouse{0};
  bool over_stage = false;  // no panel and no handle is under the mouse
  bool pressed = false;     // the left button went down with this moment
  bool down = false;
  bool ctrl = false;
  bool shift = false;
};

class StageBox {
 public:
  // True: the left button belongs to the rectangle. A press that moves less than kClickUnits is a click, and is not.
  static constexpr double kClickUnits = 4;
  bool take(UiDesk& desk, const StagePick& pick, const BoxInput& input);
  // The button went down with Shift or Ctrl and is still down.
  [[nodiscard]] bool holds() const { return from_.has_value(); }
  // And the mouse has moved.
  [[nodiscard]] bool dragging() const { return drawn_; }
  // Ends a drag, which then selects nothing.
  void cancel() { from_.reset(), drawn_ = false; }

  // Of the drag, in units of the user interface.
  [[nodiscard]] glm::dvec2 low() const { return glm::min(*from_, to_); }
  [[nodiscard]] glm::dvec2 high() const { return glm::max(*from_, to_); }
  [[nodiscard]] BoxMode mode() const { return mode_; }

 private:
  std::optional<glm::dvec2> from_;  // where the button went down
  glm::dvec2 to_{0};
  bool drawn_ = false;  // the mouse has left that place
  BoxMode mode_ = BoxMode::kOnlyThese;
};

// `selection` with the fixtures of a rectangle. The lead stays if it is still selected, else it is the first fixture.
[[nodiscard]] Selection boxed(const Selection& selection, const std::vector<int>& inside, BoxMode mode);

}  // namespace footlight::tools
