// Several views of the stage in the preview: which there are, which is active, and the frame around it.
#include <algorithm>
#include <array>

#include <imgui/imgui.h>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {

int Preview::views() const {
  return both_.mode() == StageCompare::kOff ? desk_->views() : both_.mode() == StageCompare::kBeside ? 2 : 1;
}

int Preview::active_view() const {
  return both_.mode() == StageCompare::kOff ? desk_->state().view
         : both_.mode() == StageCompare::kBeside ? compared_view_
                                                 : 0;
}

// The other views begin with the other cameras of the rig; without them, from sides.
void Preview::start_views() {
  constexpr std::array kOtherSides{ViewSide::kPlan, ViewSide::kLeft, ViewSide::kRight};
  std::size_t side = 0;
  desk_->set_views(settings_.views);
  const PixelRect where = place_of(0);
  const double aspect = static_cast<double>(where.width) / where.height;
  for (int view = 1; view < kViewsMax; ++view) {
    const auto index = static_cast<std::size_t>(view);
    const OrbitCamera& first = desk_->state().camera;
    desk_->place_camera(view, index < desk_->cameras().size()
                                  ? OrbitCamera(desk_->cameras()[index])
                                  : view_from(kOtherSides[side++], bounds_of(edited_->scene()->rig), aspect, first));
  }
}

// From now on, and in the next session.
void Preview::set_views(int views) {
  settings_.views = views;
  desk_->set_views(views);
  cancel_drags();
}

// next: makes the next one active; else changes their number. A drag of the camera and a flight stay in their view,
// also where a menu or the palette calls.
void Preview::call_views(bool next) {
  if (pressed_on_stage() || desk_->fly().on()) return;
  if (both_.on()) return tell(tr("views: A and B are on the stage; Ctrl+K ends that"));
  if (next) return desk_->activate_view((desk_->state().view + 1) % desk_->views());
  set_views(next_view_count(desk_->views()));
}

// Between two pictures: those of views that were closed are freed.
Status Preview::follow_views() {
  const int count = views();
  if (count == shown_views_) return {};
  shown_views_ = count;
  for (auto i = static_cast<std::size_t>(count); i < views_.size(); ++i) {
    views_[i].shown.reset();
    views_[i].pictures = 0;
  }
  return window_->drop_pictures(count);
}

// The view under the mouse is the active one once the mouse moves there, or does something. A drag stays in its view.
void Preview::take_active_view() {
  const ImGuiIO& io = ImGui::GetIO();
  if (views() == 1 || io.WantCaptureMouse || handles_.dragging() || box_.holds() || desk_->fly().on()) return;
  bool acts = io.MouseDelta.x != 0 || io.MouseDelta.y != 0 || io.MouseWheel != 0;
  if (pressed_on_stage()) return;
  for (int button = 0; button < static_cast<int>(pressed_on_stage_.size()); ++button) {
    acts = acts || ImGui::IsMouseClicked(button);
  }
  if (!acts) return;
  if (both_.on()) {
    compared_view_ = std::max(view_under_mouse(), 0);
  } else {
    desk_->activate_view(view_under_mouse());
  }
}

// -1: none.
int Preview::view_under_mouse() const {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const float scale = window_->pixels_per_unit();
  return view_at(place(), views(), static_cast<int>(mouse.x * scale), static_cast<int>(mouse.y * scale));
}

// Whether presses and what follows the mouse are in the picture of stage(): while the camera flies, the mouse may be
// over another view.
bool Preview::over_active_view() const {
  return !ImGui::GetIO().WantCaptureMouse && (views() == 1 || view_under_mouse() == active_view());
}

bool Preview::pressed_on_stage() const {
  return std::any_of(pressed_on_stage_.begin(), pressed_on_stage_.end(), [](bool pressed) { return pressed; });
}

// Whether each view has had a picture that is not rough.
bool Preview::shows_all() const {
  const auto end = views_.begin() + views();
  return !is_rough_ && std::all_of(views_.begin(), end, [](const View& view) { return view.pictures > 0; });
}

// Around the active view.
void Preview::draw_views() {
  if (views() == 1) return;
  const StagePlace where = stage();
  const auto at = [](glm::dvec2 point, float inset) {
    return ImVec2(static_cast<float>(point.x) + inset, static_cast<float>(point.y) + inset);
  };
  const float width = 2 * window_->ui_scale();
  ImGui::GetBackgroundDrawList()->AddRect(at(where.origin, width / 2), at(where.end(), -width / 2),
                                          ImGui::GetColorU32(kStageColours.accent), 0, 0, width);
}

}  // namespace footlight::tools
