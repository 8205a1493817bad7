// Handles in the picture that move and aim the selected fixtures: what the mouse does to them. No Dear ImGui;
// draw_handles.h draws them.
//
// The arrows and the square are at the fixture that was selected last. A drag of them is shown as boxes where the
// fixtures would be, and becomes one edit at its end: a frame of an edited rig takes longer than a picture, so the
// picture would stand still until the end anyway (decision 0147). Aiming takes pan and tilt over, at once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <glm/glm.hpp>

#include "tools/footlight/preview/ui/beam_aim.h"
#include "tools/footlight/preview/ui/stage_rays.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {

inline constexpr double kSnapM = 0.5;
inline constexpr double kNudgeM = 0.1;
inline constexpr double kBeamShownM = 5;  // of a beam that meets nothing

enum class HandlePart { kNone, kX, kY, kZ, kFloor, kAim };

// The mouse and the picture at one moment.
struct HandleInput {
  StagePlace place;
  std::span<const std::uint8_t> levels;  // that the fixtures get, in the order of the shown rig
  glm::dvec2 mouse{0};
  bool over_stage = false;  // no panel is under the mouse
  bool pressed = false;     // the left button went down with this moment
  bool down = false;
  bool snaps = false;
  double scale = 1;  // of the user interface
};

class StageHandles {
 public:
  // Moves or aims with the mouse. True: the left button belongs to a handle.
  bool take(UiDesk& desk, const HandleInput& input);
  [[nodiscard]] bool dragging() const { return drag_ != HandlePart::kNone; }
  // Ends a drag and puts everything back. Does nothing without one.
  void cancel(UiDesk& desk);

  // What is to be drawn, after take(). Nothing: no fixture is selected, or it is behind the camera.
  struct Arrow {
    HandlePart part = HandlePart::kNone;
    glm::dvec2 from{0};
    glm::dvec2 to{0};
    bool along = false;  // seen so much from its end that it cannot be dragged; it is not drawn
  };
  struct Shape {
    glm::dvec3 origin_m{0};  // with the drag
    glm::dvec2 origin{0};
    std::array<Arrow, 3> arrows;
    std::optional<std::array<glm::dvec2, 4>> floor;  // nothing: seen from the side
  };
  struct AimShape {
    StageRay beam;
    glm::dvec3 point_m{0};
    glm::dvec2 point{0};
  };
  [[nodiscard]] const std::optional<Shape>& shape() const { return shape_; }
  [[nodiscard]] const std::optional<AimShape>& aim_shape() const { return aim_shape_; }
  [[nodiscard]] HandlePart dragged() const { return drag_; }
  [[nodiscard]] HandlePart hovered() const { return hovered_; }
  // By how much the fixtures would move if the button were released now.
  [[nodiscard]] const glm::dvec3& moved_m() const { return moved_m_; }
  // The value beside the handle that is dragged, or that is under the mouse.
  [[nodiscard]] std::string text() const;

 private:
  void follow(const UiDesk& desk);
  void make_shapes(const UiDesk& desk, const HandleInput& input);
  [[nodiscard]] HandlePart part_at(glm::dvec2 mouse, double scale) const;
  [[nodiscard]] std::optional<glm::dvec3> place_under(const HandleInput& input) const;
  void begin(HandlePart part, const HandleInput& input);
  void drag(UiDesk& desk, const HandleInput& input);
  void end(UiDesk& desk, const HandleInput& input);

  std::unique_ptr<BeamAim> aim_;  // of the shown rig
  std::uint64_t shown_count_ = 0;
  std::optional<Shape> shape_;
  std::optional<AimShape> aim_shape_;
  HandlePart hovered_ = HandlePart::kNone;

  // Of a drag.
  HandlePart drag_ = HandlePart::kNone;
  Selection selection_;      // at its begin
  glm::dvec3 origin_m_{0};   // of the fixture that was selected last, at its begin
  glm::dvec3 grabbed_m_{0};  // the point of the axis or plane under the mouse at its begin
  glm::dvec2 begun_at_{0};   // the mouse
  glm::dvec2 off_{0};        // from there to the handle, when aiming
  bool moves_ = false;       // the mouse has left the place where the button went down
  bool snaps_ = false;
  glm::dvec3 moved_m_{0};
  glm::dvec3 target_m_{0};             // of aiming
  std::optional<glm::dvec3> aimed_m_;  // to which the heads were sent last
  bool turns_fixtures_ = false;        // it aims fixtures that move no head
  bool takes_over_ = false;            // something was taken over by it
  double off_rad_ = 0;                 // of AimCommand
  int left_ = 0;
};

// Moves the selected fixtures along an axis of the stage. A message; empty: nothing is to be said.
[[nodiscard]] std::string nudge_selected(UiDesk& desk, int axis, double by_m);

}  // namespace footlight::tools
