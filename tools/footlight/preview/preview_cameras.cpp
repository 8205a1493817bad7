// Cameras of the preview: those of the rig, views of all of it, and the one that flies.
#include <algorithm>
#include <utility>

#include <GLFW/glfw3.h>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/edit/rig_cameras.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

void Preview::take_camera(std::size_t index) {
  if (index >= desk_->cameras().size()) return;
  const fixtures::Camera& camera = desk_->cameras()[index];
  desk_->jump_camera(OrbitCamera(camera), static_cast<float>(camera.exposure_ev));
}

// In the side panel.
void Preview::show_cameras() {
  const auto& cameras = desk_->cameras();
  const bool same =
      std::equal(cameras.begin(), cameras.end(), facts_.cameras.begin(), facts_.cameras.end(),
                 [](const fixtures::Camera& camera, const std::string& name) { return camera.name == name; });
  facts_.can_edit = desk_->can_edit() && !desk_->locked();
  facts_.locked = desk_->locked();
  if (same) return;
  facts_.cameras.clear();
  for (const fixtures::Camera& camera : cameras) facts_.cameras.push_back(camera.name);
}

// The view, as a camera of the rig.
fixtures::Camera Preview::view_as_camera() const {
  fixtures::Camera view = desk_->state().camera.camera();
  view.exposure_ev = static_cast<double>(desk_->state().exposure.ev);
  return view;
}

void Preview::edit_cameras(const CameraRequest& request) {
  using What = CameraRequest::What;
  const fixtures::Camera view = view_as_camera();
  const fixtures::Rig& rig = desk_->edited();
  const auto& shown = desk_->cameras();
  desk_->begin_gesture();
  const Status edited =
      desk_->edit(request.what == What::kStore    ? fixtures::store_camera(rig, shown, request.index, view)
                  : request.what == What::kRename ? fixtures::rename_camera(rig, shown, request.index, request.name)
                                                  : fixtures::delete_camera(rig, shown, request.index));
  if (!edited) return tell(edited.error());
  if (const UiCommand* done = desk_->history().next_undo())
    tell(trf("{}; Ctrl+S saves it", text_of(*done, desk_->rig())));
}

void Preview::store_new_camera() {
  const Status edited = desk_->edit(fixtures::add_camera(desk_->edited(), desk_->cameras(), view_as_camera()));
  if (!edited) return tell(edited.error());
  tell(trf("camera {} is {}; Ctrl+S saves it", desk_->cameras().size(), desk_->cameras().back().name));
}

void Preview::view_from_side(ViewSide side) {
  const PixelRect where = place_of(active_view());
  desk_->jump_camera(view_from(side, bounds_of(edited_->scene()->rig), static_cast<double>(where.width) / where.height,
                               desk_->state().camera));
}

void Preview::frame_box(const glm::dvec3& low_m, const glm::dvec3& high_m) {
  const PixelRect where = place_of(active_view());
  OrbitCamera camera = desk_->state().camera;
  camera.frame(low_m, high_m, static_cast<double>(where.width) / where.height);
  desk_->jump_camera(camera);
}

// With the keys that are held, where they are on an American keyboard.
void Preview::fly(bool typing, DurationNs dt_ns) {
  const ImGuiIO& io = ImGui::GetIO();
  FlyKeys keys;
  if (!typing && !asks_close_ && !asked_next_ && !io.KeyCtrl && !io.KeyAlt && !io.KeySuper) {
    const auto held = [&](int key) { return io.KeysDown[key]; };
    keys = {held(GLFW_KEY_W), held(GLFW_KEY_S), held(GLFW_KEY_A), held(GLFW_KEY_D),
            held(GLFW_KEY_E), held(GLFW_KEY_Q), io.KeyShift};
  }
  OrbitCamera camera = desk_->state().camera;
  if (!desk_->fly().step(camera, keys, dt_ns)) return;
  if (desk_->fly().begins()) desk_->begin_gesture();
  desk_->move_camera(camera);
}

}  // namespace footlight::tools
