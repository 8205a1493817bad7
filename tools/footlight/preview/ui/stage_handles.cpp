#include "tools/footlight/preview/ui/stage_handles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/core/counted.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr double kArrowUnits = 70;
constexpr double kArrowLeastUnits = 14;  // a shorter one is seen from its end
constexpr double kGapShare = 0.14;       // between the fixture and the arrow
constexpr double kSquareFrom = 0.26;     // of the arrow's length
constexpr double kSquareTo = 0.50;
constexpr double kSquareLeastSin = 0.10;  // of the angle under which the floor is seen
constexpr double kGrabUnits = 8;
constexpr double kGrabOnSquareUnits = 3;
constexpr double kAimUnits = 12;
constexpr double kClickUnits = 3;
constexpr double kAimReachM = 200;

constexpr std::array<HandlePart, 3> kAxes{HandlePart::kX, HandlePart::kY, HandlePart::kZ};

glm::dvec3 axis_of(HandlePart part) {
  glm::dvec3 axis(0);
  axis[part == HandlePart::kX ? 0 : part == HandlePart::kY ? 1 : 2] = 1;
  return axis;
}

bool moves_fixtures(HandlePart part) { return part != HandlePart::kNone && part != HandlePart::kAim; }

// Inside of a convex polygon.
bool inside(const std::array<glm::dvec2, 4>& corners, glm::dvec2 at) {
  int left = 0;
  int right = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 side = corners[(i + 1) % corners.size()] - corners[i];
    const glm::dvec2 way = at - corners[i];
    const double turn = side.x * way.y - side.y * way.x;
    (turn < 0 ? left : right) += 1;
  }
  return left == 0 || right == 0;
}

// Without -0.
std::string metres(double value_m) { return fmt::format("{:.2f}", value_m + 0.0); }
std::string by_metres(double value_m) { return fmt::format("{:+.2f}", value_m + 0.0); }

}  // namespace

void StageHandles::follow(const UiDesk& desk) {
  if (aim_ && shown_count_ == desk.shown_count()) return;
  aim_ = std::make_unique<BeamAim>(desk.rig(), desk.compiled());
  shown_count_ = desk.shown_count();
}

void StageHandles::make_shapes(const UiDesk& desk, const HandleInput& input) {
  shape_.reset();
  aim_shape_.reset();
  const int lead = desk.state().selection.lead;
  if (lead < 0) return;
  const glm::dvec3 at_m = fixtures::position_of(desk.edited().fixtures[static_cast<std::size_t>(lead)]);
  const glm::dvec3 origin_m = at_m + (moves_fixtures(drag_) ? moved_m_ : glm::dvec3(0));
  const auto origin = projected(input.place, origin_m);
  const auto unit_m = metres_per_unit(input.place, origin_m);
  if (origin && unit_m && desk.can_edit()) {
    Shape shape;
    shape.origin_m = origin_m;
    shape.origin = *origin;
    const double length_m = kArrowUnits * input.scale * *unit_m;
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const glm::dvec3 axis = axis_of(kAxes[i]);
      const auto line =
          projected_line(input.place, origin_m + axis * (length_m * kGapShare), origin_m + axis * length_m);
      Arrow& arrow = shape.arrows[i];
      arrow = {kAxes[i], *origin, *origin, true};
      if (!line) continue;
      arrow.from = line->first;
      arrow.to = line->second;
      arrow.along = glm::length(arrow.to - *origin) < kArrowLeastUnits * input.scale;
    }
    const glm::dvec3 sight = glm::normalize(origin_m - input.place.view.position_m);
    if (std::abs(sight.z) > kSquareLeastSin) {
      std::array<glm::dvec2, 4> corners;
      bool all = true;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const double x = i == 1 || i == 2 ? kSquareTo : kSquareFrom;
        const double y = i >= 2 ? kSquareTo : kSquareFrom;
        const auto corner = projected(input.place, origin_m + glm::dvec3(x, y, 0) * length_m);
        all = all && corner;
        corners[i] = corner.value_or(glm::dvec2(0));
      }
      if (all) shape.floor = corners;
    }
    shape_ = shape;
  }
  const auto beam = aim_->beam_of(lead, input.levels);
  if (!beam || (!aim_->moves(lead) && !desk.can_edit())) return;
  AimShape shape;
  shape.beam = *beam;
  if (moves_fixtures(drag_)) shape.beam.from_m += moved_m_;
  shape.point_m =
      surface_on(desk.rig(), shape.beam, kAimReachM).value_or(shape.beam.from_m + shape.beam.way * kBeamShownM);
  if (drag_ == HandlePart::kAim && moves_) shape.point_m = target_m_;
  const auto point = projected(input.place, shape.point_m);
  if (!point) return;
  shape.point = *point;
  aim_shape_ = shape;
}

HandlePart StageHandles::part_at(glm::dvec2 mouse, double scale) const {
  if (aim_shape_ && glm::length(mouse - aim_shape_->point) <= kAimUnits * scale) return HandlePart::kAim;
  if (!shape_) return HandlePart::kNone;
  HandlePart nearest = HandlePart::kNone;
  // The square is near the arrows where the floor is seen from a low place.
  const bool on_floor = shape_->floor && inside(*shape_->floor, mouse);
  double least = (on_floor ? kGrabOnSquareUnits : kGrabUnits) * scale;
  for (const Arrow& arrow : shape_->arrows) {
    if (arrow.along) continue;
    const double off = distance_to_line(mouse, arrow.from, arrow.to);
    if (off >= least) continue;
    least = off;
    nearest = arrow.part;
  }
  return nearest == HandlePart::kNone && on_floor ? HandlePart::kFloor : nearest;
}

// The point of the axis or plane of a drag that is under the mouse.
std::optional<glm::dvec3> StageHandles::place_under(const HandleInput& input) const {
  const StageRay ray = ray_through(input.place, input.mouse);
  if (drag_ == HandlePart::kFloor) return on_plane(ray, origin_m_, {0, 0, 1});
  const glm::dvec3 axis = axis_of(drag_);
  const auto along = nearest_on_axis(ray, origin_m_, axis);
  if (!along) return std::nullopt;
  return origin_m_ + axis * *along;
}

void StageHandles::begin(HandlePart part, const HandleInput& input) {
  drag_ = part;
  moved_m_ = glm::dvec3(0);
  moves_ = snaps_ = takes_over_ = turns_fixtures_ = false;
  off_rad_ = 0;
  left_ = 0;
  aimed_m_.reset();
  begun_at_ = input.mouse;
  if (part == HandlePart::kAim) {
    target_m_ = aim_shape_->point_m;
    off_ = aim_shape_->point - input.mouse;
    return;
  }
  origin_m_ = shape_->origin_m;
  grabbed_m_ = place_under(input).value_or(origin_m_);
}

void StageHandles::drag(UiDesk& desk, const HandleInput& input) {
  moves_ = moves_ || glm::length(input.mouse - begun_at_) >= kClickUnits * input.scale;
  if (!moves_) return;
  if (input.down) snaps_ = input.snaps;  // a release has the keys of its press
  if (moves_fixtures(drag_)) {
    const auto under = place_under(input);
    if (!under) return;  // it stays where it was last
    glm::dvec3 moved_m = *under - grabbed_m_;
    for (int axis = 0; axis < 3; ++axis) {
      const bool moves = drag_ == HandlePart::kFloor ? axis < 2 : axis_of(drag_)[axis] != 0;
      if (!moves) moved_m[axis] = 0;
      if (moves && snaps_) moved_m[axis] = snapped(origin_m_[axis] + moved_m[axis], kSnapM) - origin_m_[axis];
    }
    moved_m_ = moved_m;
    return;
  }
  const StageRay ray = ray_through(input.place, input.mouse + off_);
  auto target = surface_on(desk.rig(), ray, kAimReachM);
  if (!target) target = on_plane(ray, target_m_, input.place.view.forward);
  if (!target) return;
  if (snaps_) {
    for (int axis = 0; axis < 2; ++axis) (*target)[axis] = snapped((*target)[axis], kSnapM);
  }
  target_m_ = *target;
  const int lead = selection_.lead;
  turns_fixtures_ = !aim_->moves(lead);
  if (turns_fixtures_ || aimed_m_ == target_m_) return;
  aimed_m_ = target_m_;
  AimCommand aimed = aim_command(*aim_, desk.rig(), desk.index(), selection_.fixtures, target_m_, input.levels);
  off_rad_ = aimed.off_rad;
  left_ = aimed.left;
  if (aimed.command.edits.empty()) return;
  takes_over_ = true;
  desk.run(std::move(aimed.command));
}

void StageHandles::end(UiDesk& desk, const HandleInput& input) {
  const HandlePart part = std::exchange(drag_, HandlePart::kNone);
  if (!moves_) return;
  if (moves_fixtures(part)) {
    if (moved_m_ == glm::dvec3(0)) return;
    const Status moved = desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), moved_m_));
    if (!moved) desk.tell(tr_known(moved.error().message));
    return;
  }
  if (turns_fixtures_) {
    const Status turned = desk.edit(turn_to_point(*aim_, desk.edited(), desk.selected(), target_m_, input.levels));
    if (!turned) desk.tell(tr_known(turned.error().message));
  } else if (left_ > 0) {
    desk.tell(trf_n("{} fixture without pan, tilt or address: not aimed",
                    "{} fixtures without pan, tilt or address: not aimed", left_, left_));
  }
}

bool StageHandles::take(UiDesk& desk, const HandleInput& input) {
  if (dragging() && (aim_ == nullptr || shown_count_ != desk.shown_count() || selection_ != desk.state().selection)) {
    drag_ = HandlePart::kNone;  // the rig or the selection is another one
  }
  follow(desk);
  if (dragging()) {
    drag(desk, input);
    if (!input.down) {
      end(desk, input);
      follow(desk);
      hovered_ = HandlePart::kNone;
      make_shapes(desk, input);
      return true;
    }
  }
  make_shapes(desk, input);
  if (dragging()) return true;
  hovered_ = input.over_stage ? part_at(input.mouse, input.scale) : HandlePart::kNone;
  if (hovered_ == HandlePart::kNone || !input.pressed) return false;
  if (desk.refuses()) return true;
  selection_ = desk.state().selection;
  begin(hovered_, input);
  return true;
}

void StageHandles::cancel(UiDesk& desk) {
  const HandlePart part = std::exchange(drag_, HandlePart::kNone);
  moved_m_ = glm::dvec3(0);
  if (part == HandlePart::kAim && takes_over_) desk.drop_gesture();
}

std::string StageHandles::text() const {
  const HandlePart part = dragging() ? drag_ : hovered_;
  if (part == HandlePart::kNone) return "";
  const bool shows_drag = dragging() && moves_;
  std::string words;
  if (part == HandlePart::kAim) {
    if (!aim_shape_) return "";
    const glm::dvec3& at_m = aim_shape_->point_m;
    words = trf("aim at {} {} {} m, {} m away", metres(at_m.x), metres(at_m.y), metres(at_m.z),
                metres(glm::length(at_m - aim_shape_->beam.from_m)));
    constexpr double kShownRad = 0.01;
    if (shows_drag && off_rad_ > kShownRad) {
      words += trf(", out of reach by {:.1f}\u00b0", off_rad_ * 180 / std::numbers::pi);
    }
  } else {
    if (!shape_) return "";
    const bool floor = part == HandlePart::kFloor;
    for (int axis = 0; axis < 3; ++axis) {
      if (floor ? axis == 2 : axis_of(part)[axis] == 0) continue;
      words += fmt::format("{}{} {} m", words.empty() ? "" : "  ", "XYZ"[axis], metres(shape_->origin_m[axis]));
      if (shows_drag) words += fmt::format(" ({})", by_metres(moved_m_[axis]));
    }
  }
  if (shows_drag && snaps_) words += trf("  snap {} m", kSnapM);
  return words;
}

std::string nudge_selected(UiDesk& desk, int axis, double by_m) {
  if (!desk.can_edit() || desk.selected().empty()) return "";
  glm::dvec3 by(0);
  by[axis] = by_m;
  const Status moved = desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), by));
  return moved ? "" : tr_known(moved.error().message);
}

}  // namespace footlight::tools
