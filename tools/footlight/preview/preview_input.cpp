// What lies over the picture of the preview, and what mouse, keys and menus do.
#include <algorithm>
#include <ctime>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/actions.h"
#include "tools/footlight/preview/ui/draw_busy.h"
#include "tools/footlight/preview/ui/draw_handles.h"
#include "tools/footlight/preview/ui/draw_measure.h"
#include "tools/footlight/preview/ui/escape.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/live_band.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/run_action.h"
#include "tools/footlight/preview/ui/stage_marks.h"
#include "tools/footlight/preview/ui/toasts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kSeekStepNs = 5 * kNsPerS;
constexpr double kExposureStepEv = 0.25;
constexpr double kOrbitRad = 3;   // per drag over the height of the window
constexpr float kClickUnits = 4;  // a press that moves less is a click

}  // namespace

// The part of the window beside the panel.
PixelRect Preview::place() const {
  const float panel_px =
      controls_.panel == PanelState::kFull ? kPanelWidth * window_->ui_scale() * window_->pixels_per_unit() : 0;
  return {0, 0, std::max(window_->width() - static_cast<int>(std::lround(panel_px)), 1),
          std::max(window_->height(), 1)};
}

// Of the picture that is shown, which may be one behind the camera.
StagePlace Preview::stage() const {
  const int active = active_view();
  const PixelRect where = place_of(active);
  const double scale = static_cast<double>(window_->pixels_per_unit());
  const auto& shown = views_[static_cast<std::size_t>(active)].shown;
  const OrbitCamera& camera = shown ? *shown : desk_->state().camera;
  return {render::view_of(camera.camera()),
          {where.width / scale, where.height / scale},
          {where.x / scale, where.y / scale}};
}

const StagePick& Preview::pick() {
  if (!pick_) pick_ = std::make_unique<StagePick>(edited_->scene()->rig);
  return *pick_;
}

// Everything that is drawn over the picture, and what it and the keys ask for.
void Preview::draw_ui(DurationNs dt_ns) {
  const TimeNs begun_ns = clock_.now_ns();
  window_->begin_ui();
  const auto any_button = [](bool (*is)(ImGuiMouseButton)) { return is(0) || is(1) || is(2); };
  // A drag of a handle is one gesture, whatever else is pressed meanwhile.
  const auto begin_gesture = [&](bool (*is)(ImGuiMouseButton)) {
    if (any_button(is) && !handles_.dragging()) desk_->begin_gesture();
  };
  begin_gesture([](ImGuiMouseButton button) { return ImGui::IsMouseClicked(button); });
  std::optional<UiCall> chosen;
  draw_panel(facts_, controls_, shown_levels(), hand_.get(), window_->ui_scale(), [&] {
    chosen = draw_menu(*desk_, panels_, player_ != nullptr, outputs_ ? &outputs_view_ : nullptr, &exchange_view_);
  });
  take_look();
  const PixelRect whole = place();
  const double scale = static_cast<double>(window_->pixels_per_unit());
  const glm::dvec2 size(whole.width / scale, whole.height / scale);
  follow_compared_log();
  if (panels_.any_open()) {
    UiInput input;
    input.levels = panel_levels();
    if (live_ && desk_->compiled().universes == framed_->compiled.universes) input.stamps = live_->stamps();
    if (shown_levels() != nullptr) input.status = &facts_.status;
    if (live_ && panels_.is_open(universes_panel_)) {
      live_->take_unpatched(unpatched_);
      input.unpatched = &unpatched_;
    }
    if (player_) input.transport = &controls_.transport;
    if (curve_) input.curve = &*curve_;
    if (curve_ && selected_curve_) input.selected_curve = &*selected_curve_;
    if (curve_ && strips_) input.strips = &strips_->strips;
    if (player_) input.thumbnails = &thumbnails_.pictures();
    input.outputs = &outputs_view_;
    input.inputs = &inputs_view_;
    input.messages = &messages_;
    input.report = &report_;
    input.pictures = &pictures_;
    input.now_ns = clock_.now_ns();
    input.scale = window_->ui_scale();
    panels_.draw(*desk_, input, static_cast<float>(size.x), static_cast<float>(size.y));
  }
  if (desk_->locked()) {
    const bool of_inputs = inputs_view_.drop_requests();
    if (outputs_view_.drop_requests() || of_inputs) (void)desk_->refuses();
  }
  const OutputsView* outputs = outputs_ ? &outputs_view_ : nullptr;
  const bool palette_open = palette_.is_open();
  if (const auto found = palette_.draw(*desk_, player_ != nullptr, outputs, window_->ui_scale())) {
    desk_->begin_gesture();
    chosen = found;
  }
  const bool dialog_open = dialog_.is_open();
  draw_dialog();
  if (chosen) call(*chosen);
  take_input(palette_open || dialog_open, dt_ns);
  // The last movement of a drag comes with the release.
  begin_gesture([](ImGuiMouseButton button) { return ImGui::IsMouseReleased(button); });
  draw_views();
  follow_stage_compare();
  draw_compared();
  draw_measures();
  if (const Selection& selection = desk_->state().selection; !selection.fixtures.empty()) {
    draw_marks(edited_->scene()->rig, pick(), stage(), selection, window_->ui_scale());
    if (desk_->handles()) draw_handles(handles_, *desk_, pick(), stage(), window_->ui_scale());
  }
  draw_box(box_, window_->ui_scale());
  draw_fly(desk_->fly(), stage(), window_->ui_scale());
  show_exposure();
  draw_questions();
  if (std::string news = desk_->take_news(); !news.empty()) tell(std::move(news));
  if (desk_->take_forgot()) tell(tr("undo needed more than a gibibyte: its oldest steps are forgotten"));
  draw_toasts(messages_, begun_ns, {static_cast<float>(size.x), static_cast<float>(size.y)}, window_->ui_scale());
  const auto width = static_cast<float>(size.x);
  StageTags tags(width);
  if (outputs_) draw_live_band(outputs_view_, tags, window_->ui_scale());
  draw_first_wait(times_.count(), last_ns_ - start_ns_, width);
  draw_input_tags(inputs_view_, tags);
  if (desk_->locked()) draw_lock(tags, window_->ui_scale());
  if (busy_mark_.draw(busy(), clock_.now_ns(), width, tags.bottom(), window_->ui_scale())) cancel_busy();
  print_commands();
  if (recording_) draw_recording_mark(recording_->elapsed_ns(), window_->ui_scale());
  if (closing_ || window_->wants_close() || shot_asked_) window_->keep_shot();
  window_->end_ui();
  pictures_.step();
  ui_times_.add(static_cast<double>(clock_.now_ns() - begun_ns) * 1e-6);
}

void Preview::cancel_drags() {
  handles_.cancel(*desk_);
  box_.cancel();
}

// True: the left button of the mouse belongs to a handle.
bool Preview::take_handles() {
  if (!desk_->handles()) {
    handles_.cancel(*desk_);
    return false;
  }
  const ImGuiIO& io = ImGui::GetIO();
  HandleInput input;
  input.place = stage();
  input.levels = panel_levels();
  input.mouse = {io.MousePos.x, io.MousePos.y};
  input.over_stage = over_active_view();
  input.pressed = ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  input.down = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  input.snaps = io.KeyCtrl;
  input.scale = static_cast<double>(window_->ui_scale());
  return handles_.take(*desk_, input);
}

// True: a drag of a rectangle has the left button of the mouse.
bool Preview::take_box(bool handle) {
  const ImGuiIO& io = ImGui::GetIO();
  BoxInput input;
  input.place = stage();
  input.mouse = {io.MousePos.x, io.MousePos.y};
  input.over_stage = over_active_view() && !handle;
  input.pressed = ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  input.down = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  input.ctrl = io.KeyCtrl;
  input.shift = io.KeyShift;
  if (!input.pressed && !box_.holds()) return false;
  return box_.take(*desk_, pick(), input);
}

void Preview::take_mouse() {
  take_active_view();
  const bool handle = take_handles();
  if (handles_.dragging() || take_box(handle)) {
    pressed_on_stage_.fill(false);  // a drag of the camera that is under way ends: it would be in the same gesture
    return;
  }
  const ImGuiIO& io = ImGui::GetIO();
  const double heights = 1.0 / std::max(static_cast<double>(io.DisplaySize.y), 1.0);
  const double right = static_cast<double>(io.MouseDelta.x) * heights;
  const double down = static_cast<double>(io.MouseDelta.y) * heights;
  OrbitCamera camera = desk_->state().camera;
  bool moves = false;
  for (int button = 0; button < static_cast<int>(pressed_on_stage_.size()); ++button) {
    bool& on_stage = pressed_on_stage_[static_cast<std::size_t>(button)];
    if (ImGui::IsMouseClicked(button)) {
      on_stage = over_active_view() && !handle;
      continue;  // how the mouse moved before does not count
    }
    const bool ends = !ImGui::IsMouseDown(button);
    if (!on_stage) continue;
    on_stage = !ends;
    const ImVec2 from = io.MouseClickedPos[button];
    const float x = io.MousePos.x - from.x;
    const float y = io.MousePos.y - from.y;
    if (std::max(io.MouseDragMaxDistanceSqr[button], x * x + y * y) < kClickUnits * kClickUnits) {
      if (ends && button == ImGuiMouseButton_Left && desk_->measure().on) {
        const auto point_m = measured_point(edited_->scene()->rig, pick(), stage(), {from.x, from.y});
        if (point_m) desk_->measure().click(*point_m);
      } else if (ends && button == ImGuiMouseButton_Left) {
        desk_->select(pick().fixture_at(stage(), {from.x, from.y}), selects_more_);
      }
      continue;
    }
    if (button == ImGuiMouseButton_Left && desk_->fly().on()) {
      camera.look(right * kOrbitRad, -down * kOrbitRad);
    } else if (button == ImGuiMouseButton_Left) {
      camera.orbit(-right * kOrbitRad, down * kOrbitRad);
    } else {
      camera.pan(-right, down);
    }
    moves = moves || right != 0 || down != 0;
  }
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) selects_more_ = io.KeyCtrl || io.KeyShift;
  if (io.MouseWheel != 0 && !io.WantCaptureMouse && desk_->fly().on()) {
    desk_->fly().change_speed(static_cast<double>(io.MouseWheel));
  } else if (io.MouseWheel != 0 && !io.WantCaptureMouse) {
    camera.approach(static_cast<double>(io.MouseWheel));
    moves = true;
  }
  if (moves) desk_->move_camera(camera);
}

// typing: keys belong to the palette, also Esc, which it has seen.
void Preview::take_input(bool typing, DurationNs dt_ns) {
  const ImGuiIO& io = ImGui::GetIO();
  if (controls_.camera) take_camera(static_cast<std::size_t>(*std::exchange(controls_.camera, std::nullopt)));
  if (const auto request = std::exchange(controls_.camera_request, std::nullopt)) edit_cameras(*request);
  show_cameras();
  take_picture_requests();
  take_drops();
  const auto holders = [&] {
    const bool types = io.WantTextInput || typing || palette_.is_open() || dialog_.is_open();
    return KeyHolders{types, asks_close_ || asked_next_.has_value(),
                      handles_.dragging() || box_.dragging(), desk_->fly().on(), pressed_on_stage()};
  };
  // Before the mouse: Escape with the release of a drag in one picture puts it back.
  const KeyPress* const cancels = canceling_key(window_->keys(), holders());
  if (cancels != nullptr) cancel_drags();
  take_mouse();
  fly(holders().text, dt_ns);
  for (const KeyPress& key : window_->keys()) {
    if (&key == cancels) continue;
    const KeyTurn turn = turn_of(key, holders());
    if (turn == KeyTurn::kCancelsDrag) cancel_drags();
    if (turn != KeyTurn::kActs) continue;
    if (!key.repeated && !handles_.dragging()) desk_->begin_gesture();
    call(*call_of(key));
  }
}

// back: undo, else redo.
void Preview::step_history(bool back) {
  const int view = desk_->state().view;
  const std::string edit = back ? desk_->undo() : desk_->redo();
  tell(edit.empty() ? std::string(back ? tr("nothing to undo") : tr("nothing to redo"))
                    : fmt::format("{}: {}", back ? tr("undo") : tr("redo"), edit));
  if (desk_->state().view != view) pressed_on_stage_.fill(false);  // a drag of the camera does not change its view
}

void Preview::call(const UiCall& call) {
  const OutputsView* outputs = outputs_ ? &outputs_view_ : nullptr;
  if (std::string why = why_still_dark(call); !why.empty()) return tell(std::move(why));
  if (std::string why = why_not(call, *desk_, player_ != nullptr, outputs); !why.empty()) return tell(std::move(why));
  if (auto news = run_on_desk(*desk_, call)) {
    if (!news->text.empty()) tell(std::move(news->text), news->wrong);
    return;
  }
  if (call_outputs(call)) return;
  switch (call.action) {
    case UiAction::kUndo: step_history(true); break;
    case UiAction::kRedo: step_history(false); break;
    case UiAction::kOpen: open_dialog(FileDialog::Use::kOpen); break;
    case UiAction::kSave: save(); break;
    case UiAction::kSaveAs: open_dialog(FileDialog::Use::kSave); break;
    case UiAction::kFrame:
      if (const auto& which = desk_->state().selection.fixtures; !which.empty()) {
        const StagePick::Box box = pick().bounds_of(which);
        frame_box(box.low_m, box.high_m);
        break;
      }
      [[fallthrough]];
    case UiAction::kFrameRig: {
      const Bounds bounds = bounds_of(edited_->scene()->rig);
      frame_box(bounds.low_m, bounds.high_m);
      break;
    }
    case UiAction::kCompare: compare_from_here(); break;
    case UiAction::kCompareStage: set_stage_compare(next_of(both_.mode())); break;
    case UiAction::kCamera: take_camera(static_cast<std::size_t>(call.argument)); break;
    case UiAction::kStoreCamera: store_new_camera(); break;
    case UiAction::kViewFrom: view_from_side(static_cast<ViewSide>(call.argument)); break;
    case UiAction::kViews: call_views(call.argument == 1); break;
    case UiAction::kWorkLight: controls_.work_light = !controls_.work_light; break;
    case UiAction::kBrighter: expose(-kExposureStepEv); break;  // a lower EV makes a brighter picture
    case UiAction::kDarker: expose(kExposureStepEv); break;
    case UiAction::kPlay: controls_.transport.playing = !controls_.transport.playing; break;
    case UiAction::kSeekBack: controls_.transport.seek_by(-kSeekStepNs); break;
    case UiAction::kSeekOn: controls_.transport.seek_by(kSeekStepNs); break;
    case UiAction::kSlower: controls_.transport.change_speed(-1); break;
    case UiAction::kFaster: controls_.transport.change_speed(1); break;
    case UiAction::kRepeatFrom: controls_.transport.repeat_from(controls_.transport.now_ns); break;
    case UiAction::kRepeatTo: controls_.transport.repeat_to(controls_.transport.now_ns); break;
    case UiAction::kRepeatAll: controls_.transport.repeat_all(); break;
    case UiAction::kMark: mark_time(); break;
    case UiAction::kMarkerBack: go_to_marker(marker_before(desk_->state().markers, marker_start_ns(true))); break;
    case UiAction::kMarkerOn: go_to_marker(marker_after(desk_->state().markers, marker_start_ns(false))); break;
    case UiAction::kMarker:
      if (const auto index = static_cast<std::size_t>(call.argument); index < desk_->state().markers.size()) {
        go_to_marker(&desk_->state().markers[index]);
      }
      break;
    case UiAction::kTheme:
      settings_.theme = settings_.theme == UiTheme::kDark ? UiTheme::kLight : UiTheme::kDark;
      break;
    case UiAction::kUiSmaller:
    case UiAction::kUiLarger:
      settings_.ui_percent = next_ui_percent(settings_.ui_percent, call.action == UiAction::kUiLarger ? 1 : -1);
      tell(trf("panels and text: {} %", settings_.ui_percent));
      break;
    case UiAction::kOpenRecent:
      if (const auto index = static_cast<std::size_t>(call.argument); index < desk_->recent_rigs().size()) {
        ask_to_open({desk_->recent_rigs()[index], ""});
      }
      break;
    case UiAction::kOpenRecentLog:
      if (const auto index = static_cast<std::size_t>(call.argument); index < desk_->recent_logs().size()) {
        ask_to_open({"", desk_->recent_logs()[index], false, saved_as_});
      }
      break;
    case UiAction::kSidePanel:
      controls_.panel = controls_.panel == PanelState::kFull    ? PanelState::kStrip
                        : controls_.panel == PanelState::kStrip ? PanelState::kHidden
                                                                : PanelState::kFull;
      break;
    case UiAction::kPanel: {
      const auto index = static_cast<std::size_t>(call.argument);
      panels_.set_open(index, !panels_.is_open(index), *desk_);
      break;
    }
    case UiAction::kEditField:
      panels_.set_open(panel_of("fixtures"), true, *desk_);
      desk_->ask_field(static_cast<EditField>(call.argument));
      break;
    case UiAction::kLibrary: panels_.set_open(panel_of("library"), true, *desk_); break;
    case UiAction::kQuality: {
      const QualityChoice& choice = quality_choices()[static_cast<std::size_t>(call.argument)];
      controls_.quality = render::QualityRequest{choice.error, choice.ms};
      break;
    }
    case UiAction::kFullScreen: window_->toggle_full_screen(); break;
    case UiAction::kShot: shot_asked_ = true; break;
    case UiAction::kRecord: toggle_recording(); break;
    case UiAction::kTap: tap(); break;
    case UiAction::kPalette: palette_.open(); break;
    case UiAction::kEscape: escape(); break;
    default: break;  // of run_on_desk() and call_outputs()
  }
}

void Preview::escape() {
  if (busy_mark_.can_cancel() && !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup)) return cancel_busy();
  if (close_topmost(panels_, *desk_)) return;
  if (outputs_view_.live_count() == 0) {
    closing_ = true;
  } else {
    tell(tr("Esc does not close the window while an output is live: disarm it first (F6), or close the window by its "
            "button"),
         false);
  }
}

// Lines on the floor, and what is measured.
void Preview::draw_measures() {
  const StagePlace where = stage();
  if (desk_->floor_lines()) {
    const Bounds bounds = bounds_of(edited_->scene()->rig);
    draw_floor_lines(floor_lines(bounds.low_m, bounds.high_m), where, window_->ui_scale());
  }
  const StageMeasure& measure = desk_->measure();
  if (!measure.on) return;
  std::optional<glm::dvec3> under_m;
  const ImGuiIO& io = ImGui::GetIO();
  if (over_active_view() && measure.from_m && !measure.to_m) {
    under_m = measured_point(edited_->scene()->rig, pick(), where, {io.MousePos.x, io.MousePos.y});
  }
  draw_measure(measure, under_m, where, window_->ui_scale());
}

void Preview::expose(double steps_ev) {
  Exposure exposure = desk_->state().exposure;
  if (exposure.automatic) return;
  exposure.ev += static_cast<float>(steps_ev);
  desk_->set_exposure(exposure);
}

// What the side panel has made of the exposure and the look.
void Preview::take_look() {
  if (const Exposure shown{controls_.exposure_ev, controls_.auto_exposure}; shown != desk_->state().exposure) {
    desk_->set_exposure(shown);
  }
  const PictureLook look{controls_.tone, controls_.balances_white, controls_.white_k, controls_.glare_percent};
  if (!std::exchange(look_began_, true)) desk_->start_look(look);
  if (look != desk_->state().look) desk_->set_look(look);
}

// In the side panel and the picture.
void Preview::show_exposure() {
  controls_.exposure_ev = desk_->state().exposure.ev;
  controls_.auto_exposure = desk_->state().exposure.automatic;
  if (!look_began_) return;
  const PictureLook& look = desk_->state().look;
  controls_.tone = look.tone;
  controls_.balances_white = look.balances_white;
  controls_.white_k = look.white_k;
  controls_.glare_percent = look.glare_percent;
}

void Preview::tell(const Error& error) { tell(tr_known(error.message), true); }

// wrong: an error, which is shown longer and in red.
void Preview::tell(std::string news, bool wrong) {
  if (options_.json) print_message(news, wrong);
  messages_.add(std::move(news), wrong, fmt::format("{:%H:%M:%S}", fmt::localtime(std::time(nullptr))),
                clock_.now_ns());
}

}  // namespace footlight::tools
