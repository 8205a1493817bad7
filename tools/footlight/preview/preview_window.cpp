// The preview from picture to picture.
#include "tools/footlight/preview/preview_window.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fixtures/simulate/machines.h"
#include "tools/footlight/command.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/preview/display_loss.h"
#include "tools/footlight/preview/start_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kSettleNs = 200 * kNsPerMs;   // a new size is taken when the window has kept it for this long
constexpr std::uint32_t kProbeTexels = 1024;       // of each reflection probe a picture: all of them in four
constexpr DurationNs kFactsNs = 100 * kNsPerMs;    // from one moment that the side panel shows to the next
constexpr DurationNs kLossPauseNs = 60 * kNsPerS;  // devices that are lost sooner one after the other are counted
constexpr int kLossesMax = 3;

// What the camera makes of the light.
void take_display(const PreviewControls& controls, render::FrameSettings& settings) {
  settings.glare = static_cast<double>(controls.glare_percent) / 100;
  settings.white_k = controls.balances_white ? static_cast<double>(controls.white_k) : 0;
  settings.tone = controls.tone;
  settings.auto_exposure = controls.auto_exposure;
}
bool other_display(const PreviewControls& controls, const render::FrameSettings& settings) {
  render::FrameSettings own;
  take_display(controls, own);
  return own.glare != settings.glare || own.white_k != settings.white_k || own.tone != settings.tone ||
         own.auto_exposure != settings.auto_exposure;
}

bool lost(const std::unique_ptr<render::vk::Device>& device) { return device && device->lost(); }

}  // namespace

Result<int> Preview::run() {
  const Result<int> result = open_and_turn();
  closed_ = true;
  outputs_.reset();  // also after an error: real lamps go dark before anything else is waited for
  end_recording();
  report_recording(true);
  end_edits();
  if (result && recording_failed_) return kExitFailed;
  return result;
}

Result<int> Preview::open_and_turn() {
  StopSignal signal;
  signal.also_hangup();
  FL_ASSIGN(const bool opened, open(signal));
  if (!opened) return kExitOk;
  start_ns_ = last_ns_ = second_ns_ = stepped_ns_ = clock_.now_ns();
  device_->lose_from_environment();
  if (const char* submits = std::getenv("FOOTLIGHT_LOSE_WINDOW"); submits != nullptr) {
    window_device_->lose_after(std::strtoull(submits, nullptr, 10));
  }
  if (!options_.record.empty()) FL_TRY(start_recording(options_.record));
  if (!options_.compare.empty()) {
    FL_TRY(compare_with(options_.compare));
    FL_TRY(take_compared_log());
  }
  FL_ASSIGN(const StageCompare compares, stage_compare_of(options_.compare_stage));
  if (compares != StageCompare::kOff) set_stage_compare(compares);
  while (!signal.came() && !((window_->wants_close() || closing_) && may_close())) {
    Status turned = turn();
    if (!turned) window_->poll();  // Vulkan may see it first
    FL_TRY(check_display());
    while (!turned && (lost(device_) || lost(window_device_))) turned = start_again(turned.error());
    FL_TRY(turned);
  }
  if (signal.came() || times_out_) next_.reset();  // nothing else is opened
  outputs_.reset();
  if (picture_->in_flight()) FL_TRY(picture_->done(StagePicture::kForeverNs));
  FL_TRY(window_->wait_gpu());
  if (!options_.screenshot.empty()) FL_TRY(write_shot());
  if (options_.json) print_summary();
  return validation_messages() == 0 ? kExitOk : kExitFailed;
}

// Until the screen shows its next picture; sooner if a picture of the stage is done that takes longer than that.
Status Preview::pace() {
  if (window_->minimised()) return {};  // poll() waits
  const auto tick_ns = static_cast<DurationNs>(1e9 / refresh_hz_);
  // Where presenting waits for the screen, this only bounds the rate.
  const bool waits_itself = presented_ && !device_->is_software();
  const DurationNs left_ns = last_ns_ + (waits_itself ? tick_ns / 2 : tick_ns) - clock_.now_ns();
  if (left_ns <= 0) return {};
  if (thumbnails_.in_flight()) {
    FL_TRY(thumbnails_.done(static_cast<std::uint64_t>(left_ns)));
  } else if (picture_->in_flight() && clock_.now_ns() - drawn_ns_ > tick_ns) {
    FL_TRY(picture_->done(static_cast<std::uint64_t>(left_ns)));
  } else {
    window_->pause(static_cast<double>(left_ns) * 1e-9);
  }
  return {};
}

// One turn of the user interface. The stage gets its turn when no picture of it is in flight.
Status Preview::turn() {
  FL_TRY(pace());
  window_->poll();
  FL_TRY(check_display());
  follow_settings();
  const TimeNs now_ns = clock_.now_ns();
  const DurationNs dt_ns = now_ns - last_ns_;
  if (!times_out_) turn_times_.add(static_cast<double>(dt_ns) * 1e-6);  // else the turn before waited for a picture
  last_ns_ = now_ns;
  times_out_ = options_.seconds > 0 && static_cast<double>(now_ns - start_ns_) >= options_.seconds * 1e9;
  const bool drew = picture_->in_flight() || thumbnails_.in_flight();
  FL_TRY(take_thumbnail());
  FL_TRY(take_picture());
  if (times_out_ && (shows_all() || window_->minimised())) {  // a short time still shows a picture
    closing_ = true;
    window_->keep_shot();
  }
  FL_TRY(window_->set_pictures(pictures_));
  draw_ui(dt_ns);
  if (std::exchange(shot_taken_, false)) write_own_shot();
  follow_exchange();
  keep_edits();
  keep_markers();
  const PixelRect where = place_of(0);  // all have its size
  follow_hand();
  report_recording(false);
  if (picture_->in_flight() || thumbnails_.in_flight()) {
    FL_TRY(step_meanwhile());
  } else if (!drew || times_out_ || !device_->is_software()) {
    // In software a turn that shows a new picture does not begin the next one as well: both take long.
    FL_TRY(turn_stage(where));
  }
  drive_outputs();
  read_second();
  presented_ = false;
  if (window_->minimised()) return {};
  const TimeNs shows_ns = clock_.now_ns();
  std::array<PixelRect, kViewsMax> places;
  const auto count = static_cast<std::size_t>(views());
  for (std::size_t i = 0; i < count; ++i) places[i] = place_of(static_cast<int>(i));
  FL_ASSIGN(const Window::Shown shown, window_->show(std::span(places).first(count)));
  presented_ = shown == Window::Shown::kNew;
  if (presented_) show_times_.add(static_cast<double>(clock_.now_ns() - shows_ns) * 1e-6);
  if (presented_) shot_taken_ = std::exchange(shot_asked_, false);
  if (presented_ && times_.count() > 0) {
    if (picture_ns_ < 0) picture_ns_ = clock_.now_ns() - begun_ns_;
    if (whole_ns_ < 0 && !shows_rough_) whole_ns_ = clock_.now_ns() - begun_ns_;
  }
  return {};
}

// All that touches the frame between two pictures, and the beginning of the next one.
Status Preview::turn_stage(const PixelRect& where) {
  follow_first_picture(where);
  FL_ASSIGN(bool still, follow_quality());
  if (!still && !is_rough_) {  // one other thread at a time uses the device
    FL_ASSIGN(still, follow_edits(where));
  }
  if (still) {
    stepped_ns_ = last_ns_;
    picture_since_ns_ = -1;  // the time until the next picture is not its own
    return {};
  }
  FL_TRY(both_.release(*frame_));
  FL_TRY(follow_views());
  FL_TRY(follow_flashes());
  if (fits_controls(where)) {
    coming_.leave();
  } else if (is_compiled(where)) {
    FL_TRY(rebuild(where));
  }
  FL_TRY(update_error());
  follow_report();
  follow_inputs();
  FL_TRY(step_levels());
  keep_recording();
  if (player_ && player_->seeking()) {  // nothing between is shown
    picture_since_ns_ = -1;
    return {};
  }
  show_videos();
  if (window_->minimised()) {  // the fixtures continue without pictures
    picture_since_ns_ = -1;
    return frame_->run_steps();
  }
  if (closing_) return {};
  FL_TRY(begin_thumbnail());
  return thumbnails_.in_flight() ? Status{} : draw();
}

// False: the frame has to be another one, for its size or its settings. A new size counts when it has settled.
bool Preview::fits_controls(const PixelRect& where) {
  if (where.width != wanted_width_ || where.height != wanted_height_) {
    wanted_width_ = where.width;
    wanted_height_ = where.height;
    wanted_since_ns_ = last_ns_;
  }
  const render::FrameSettings& settings = frame_->settings();
  const render::FrameSettings wanted = frame_settings(where, is_rough_);
  const bool other_size = settings.width != wanted.width || settings.height != wanted.height;
  const render::Knobs knobs = render::knobs_of(wanted);
  render::Knobs drawn = render::knobs_of(settings);
  drawn.divisor = knobs.divisor;  // a part of the size
  if (knobs.gobo_method == render::GoboMethod::kSuited) drawn.gobo_method = knobs.gobo_method;
  const bool settled =
      (last_ns_ - wanted_since_ns_ >= kSettleNs || sized_views_ != views()) && !window_->minimised();
  return drawn == knobs && wanted.edge_samples == settings.edge_samples && wanted.bounce == settings.bounce &&
         wanted.probes == settings.probes &&
         wanted.shadows == settings.shadows && controls_.haze == settings.haze && !other_display(controls_, settings) &&
         !(other_size && settled);
}

// Begins a picture.
Status Preview::draw() {
  const VkImage screen = frame_->resources().picture.screen.handle;
  const render::FrameSettings& settings = frame_->settings();
  drawn_ns_ = last_ns_;
  drawn_compare_ = both_.mode();
  if (both_.on()) {
    FL_TRY(begin_compared());
    if (!drawn_camera_) return {};
  } else {
    const int active = desk_->state().view;
    drawn_view_ = view_turns_.next(desk_->views(), active);
    drawn_camera_ = desk_->camera_of(drawn_view_);
    drawn_main_ = drawn_view_ == active;
  }
  if (picture_since_ns_ < 0) picture_since_ns_ = drawn_ns_;
  return picture_->begin(screen, settings.width, settings.height, [&](VkCommandBuffer commands) {
    frame_->set_haze_per_m(haze_per_m());
    frame_->set_work_light_lx(controls_.work_light ? static_cast<double>(controls_.work_light_lx) : 0);
    frame_->record(commands, render::view_of(drawn_camera_->camera()), controls_.exposure_ev, drawn_main_);
    error_drawn_ = error_ && drawn_main_;
    if (error_drawn_) error_->record(commands);
    render::vk::full_barrier(commands);
    const VkBufferCopy region{0, 0, sizeof(render::CountsRow)};
    vkCmdCopyBuffer(commands, frame_->resources().rig.counts.handle, counts_.handle, 1, &region);
    render::vk::host_barrier(commands);
    PreviewFlashes* flashes = views_[static_cast<std::size_t>(drawn_view_)].flashes.get();
    if (flashes != nullptr) flashes->record_read(commands, screen, settings.width, settings.height);
  });
}

// The picture in flight goes to the window, if it is done. At the end it is waited for.
Status Preview::take_picture() {
  if (!picture_->in_flight()) return {};
  FL_ASSIGN(const bool done, picture_->done(times_out_ ? StagePicture::kForeverNs : 0));
  if (!done) return {};
  const HostPicture picture = picture_->take();
  FL_TRY(read_picture());
  View& view = views_[static_cast<std::size_t>(drawn_view_)];
  if (AsideStage* const aside = both_.inside()) FL_TRY(aside->leave(*frame_));
  if (drawn_compare_ != both_.mode()) return {};
  if (both_.on()) both_.end();
  if (drawn_compare_ == StageCompare::kDifference) return take_difference(picture);
  ++view.pictures;
  PreviewFlashes* flashes = view.flashes.get();
  // It was begun before they were to be held back, and nothing has looked at it.
  if (desk_->flashes() == FlashMode::kLimit && (flashes == nullptr || !flashes->limits())) return {};
  if (flashes != nullptr) {
    const DurationNs at_ns = last_ns_ - start_ns_;
    const std::size_t stretches = flashes->watch().stretches().size();
    if (flashes->limits()) {
      view.flashes_held = flashes->must_wait(at_ns);
    } else {
      (void)flashes->take(at_ns);
    }
    tell_flashes(flashes->watch().stretches().size() > stretches);
    if (view.flashes_held) return {};
  }
  if (drawn_view_ >= views()) return {};  // it was closed meanwhile
  view.shown = drawn_camera_;
  shows_rough_ = is_rough_;
  return window_->set_picture(drawn_view_, picture);
}

// The figures of a picture that is done.
Status Preview::read_picture() {
  const double picture_ms = static_cast<double>(last_ns_ - picture_since_ns_) * 1e-6;
  picture_since_ns_ = last_ns_;
  times_.add(picture_ms);
  ++second_frames_;
  first_of_edit_ = false;
  FL_ASSIGN(auto passes, frame_->read_times());
  double gpu_ms = 0;
  for (const auto& pass : passes) gpu_ms += pass.gpu_ms;
  if (passes.empty()) gpu_ms = picture_ms;  // a device without time stamps
  gpu_ms_ = gpu_ms;
  if (keeper_ && keeper_->take(drawn_ns_, gpu_ms)) follow_knobs(keeper_->point());
  if (error_ && error_drawn_) {
    FL_TRY(error_->take(drawn_ns_));
    facts_.error = error_->estimate();
    passes.push_back({"error", error_->gpu_ms()});
  }
  // Those of the active view, which alone has its error measured.
  if (drawn_main_) facts_.passes = std::move(passes);
  if (reports() && drawn_main_) read_report(gpu_ms);
  render::CountsRow counts{};
  std::memcpy(&counts, counts_.mapped, sizeof(counts));
  if (both_.on() && !drawn_main_) return {};
  facts_.live_beams = counts.live_count;
  facts_.dark_beams = counts.dark_count;
  facts_.shadows = counts.shadows;
  facts_.shadows_lost = counts.shadows_lost;
  facts_.width = frame_->settings().width;
  facts_.height = frame_->settings().height;
  facts_.gpu_mib = static_cast<double>(frame_->bytes()) / (1024.0 * 1024.0);
  return {};
}

// What panels show of this moment, and once a second, or a period of --json, the figures.
void Preview::read_second() {
  if (last_ns_ - facts_.now_ns < kFactsNs) return;  // ages that change more often cannot be read, and cost a redraw
  facts_.now_ns = last_ns_;
  facts_.room_haze_per_m = haze_per_m();
  // During a small picture, and one of A of a comparison, the frame has the air of another time.
  const bool is_own = !thumbnails_.in_flight() && both_.inside() == nullptr;
  if (const fixtures::MachineAir* air = frame_->machine_air(); air != nullptr && is_own) {
    facts_.machines = air->count();
    facts_.machine_haze_per_m = air->haze_per_m();
    facts_.machine_fog_per_m = air->fog_per_m();
  }
  const DurationNs since_ns = facts_.now_ns - second_ns_;
  const DurationNs period_ns = options_.json ? options_.json_period_ns : kNsPerS;
  if (since_ns >= period_ns) refresh_hz_ = Window::refresh_hz();  // which asks the window system
  if (since_ns < period_ns || times_.count() == 0) return;
  facts_.fps = static_cast<double>(second_frames_) * 1e9 / static_cast<double>(since_ns);
  second_ns_ = facts_.now_ns;
  second_frames_ = 0;
  if (const LiveLevels* shown = shown_levels()) facts_.status = shown->status();
  if (live_) {
    for (std::string& notice : live_->notices()) {
      if (!options_.json) fmt::print(stderr, "footlight: {}\n", notice);
      facts_.notice = tr_known(notice);
      tell(facts_.notice);
    }
  }
  facts_.frame_p50_ms = times_.quantile_ms(0.5);
  facts_.frame_p90_ms = times_.quantile_ms(0.9);
  facts_.ui_ms = ui_times_.quantile_ms(0.5);
  if (options_.json) print_second();
}

void Preview::tell_flashes(bool begins) {
  facts_.flashes_harmful = facts_.flashes_held = false;
  bool limits = false;
  for (const View& view : views_) {
    if (!view.flashes) continue;
    facts_.flashes_harmful = facts_.flashes_harmful || view.flashes->watch().harmful();
    facts_.flashes_held = facts_.flashes_held || view.flashes_held;
    limits = view.flashes->limits();
  }
  if (both_.watch() != nullptr) {
    facts_.flashes_harmful = facts_.flashes_harmful || both_.watch()->harmful();
    facts_.flashes_held = facts_.flashes_held || both_.held_back();
    limits = limits || desk_->flashes() == FlashMode::kLimit;
  }
  if (!begins) return;
  if (options_.json) {
    const nlohmann::json line = {{"event", "flashes-begin"}, {"time_ns", drawn_ns_ - start_ns_}};
    fmt::print("{}\n", line.dump());
  } else {
    fmt::print(stderr, "footlight: flashes that can harm people with photosensitive epilepsy{}\n",
               limits ? "; held back" : "; --flashes limit holds them back");
  }
}

void Preview::follow_knobs(const render::KnobPoint& point) {
  facts_.chosen = point;
  knobs_ = point.knobs;
  controls_.nodes = static_cast<int>(point.knobs.nodes);
  if (keeper_) controls_.divisor = point.knobs.divisor;
}

// The measurement of the error exists while a panel shows it, and is made anew for another frame.
Status Preview::update_error() {
  const bool shown = (controls_.panel == PanelState::kFull && !window_->minimised()) || reports();
  if (!shown) {
    error_.reset();
    facts_.error = {};
    error_tried_ = false;
  } else if (!error_ && !error_tried_ && !is_rough_) {
    const fixtures::Needs& needs = framed_->compiled.needs;
    // It computes beams again, and nothing else.
    const bool measures = !needs.laser && !needs.panes && !needs.displays &&
                          options_.style == render::PictureStyle::kPhysical;
    if (measures && !error_begun_) render::LiveError::compile_ahead(*device_, frame_->settings(), needs);
    error_begun_ = true;
    if (!times_out_ && !device_->pipelines().finished()) return {};  // pictures go on without it
    error_tried_ = true;
    if (!measures) return {};
    FL_ASSIGN(error_, render::LiveError::create(*device_, *frame_, needs));
  }
  return {};
}

// The current size, nodes and haze.
render::FrameSettings Preview::settings_with(const render::Knobs& knobs, const PixelRect& where) const {
  render::FrameSettings settings;
  settings.width = std::max(where.width / controls_.divisor, 1);
  settings.height = std::max(where.height / controls_.divisor, 1);
  settings.edge_samples = options_.edge_samples.value_or(render::suited_edge_samples(*device_));
  settings.shadows = options_.display.shadows;
  settings.shadow_map_px = options_.display.shadow_map_px;
  settings.penumbra = options_.display.penumbra;
  const bool suited = settings.shadow_map_px == render::kShadowsSuited && settings.penumbra == 1;
  if (suited) settings.shadow_map_px = render::window_map_px(*device_);
  settings.bounce = options_.bounce;
  settings.probes = options_.probes && controls_.probes;
  settings = render::with_knobs(settings, knobs);
  settings.nodes = static_cast<std::uint32_t>(controls_.nodes);
  settings.probe_texels = kProbeTexels;
  settings.f_stop = lens_.f_stop;
  settings.focus_m = lens_.focus_m;
  take_display(controls_, settings);
  settings.haze = controls_.haze;
  return render::settings_of(options_.style, settings);
}

render::FrameSettings Preview::frame_settings(const PixelRect& where, bool rough) const {
  const render::FrameSettings settings = settings_with(knobs_, where);
  return rough ? render::rough_settings(settings, framed_->compiled.beams_max) : settings;
}

// A frame of these settings. The states of the fixtures move from the old frame to the new one.
Status Preview::rebuild(const PixelRect& where) {
  const render::FrameSettings settings = frame_settings(where, is_rough_);
  error_.reset();
  error_tried_ = error_begun_ = error_drawn_ = false;
  thumbnails_.drop_frame();
  both_.begin_anew();
  if (frame_) {
    FL_TRY(frame_->change(settings));
  } else {
    FL_ASSIGN(frame_, render::Frame::create(*device_, framed_->rig, framed_->compiled, table_settings(where),
                                            render::passes_of(options_.style), &settings));
    videos_.show_all_again();
    print_warnings(frame_->resources().rig.diagnostics);
    warn_of_hard_edges(frame_->settings());
    if (hand_) frame_->settle_machine_air(hand_->levels());
  }
  picture_since_ns_ = -1;
  wanted_width_ = where.width;
  wanted_height_ = where.height;
  sized_views_ = views();
  return {};
}

// After the loss of a device: a new one. One that is lost again and again ends the preview.
Status Preview::start_again(const Error& loss) {
  const TimeNs now_ns = clock_.now_ns();
  const bool of_stage = lost(device_);
  Losses& losses = of_stage ? stage_losses_ : window_losses_;
  losses.count = now_ns - losses.last_ns < kLossPauseNs ? losses.count + 1 : 1;
  losses.last_ns = now_ns;
  if (losses.count > kLossesMax) return tl::unexpected<Error>(loss);
  if (options_.json) {
    const nlohmann::json line = {
        {"event", "device-lost"}, {"device", of_stage ? "stage" : "window"}, {"message", loss.message}};
    fmt::print("{}\n", line.dump());
    std::fflush(stdout);
  } else {
    fmt::print(stderr, "footlight: {}; going on with a new device\n", loss.message);
  }
  return of_stage ? replace_stage() : replace_window();
}

// The window shows the last picture until the next one of the stage.
Status Preview::replace_window() {
  if (window_device_) messages_before_ += window_device_->validation_messages().size();
  window_->detach();
  window_device_.reset();
  FL_TRY(open_window_device());
  last_ns_ = clock_.now_ns();  // a camera that flies does not jump
  return {};
}

// And a frame made from the new device. Heads that follow a log go where the log has them; others start from where
// their channels stand. The window shows the last picture meanwhile.
Status Preview::replace_stage() {
  if (device_) messages_before_ += device_->validation_messages().size();
  drop_frame();
  thumbnails_.drop_frame();
  both_.lose_frame();
  picture_.reset();
  const bool measures = facts_.measures_knobs;
  drop_curves();
  facts_.measures_knobs = measures;  // on the new device
  error_.reset();
  frame_.reset();
  for (View& view : views_) view.flashes.reset();
  facts_.flashes_held = false;
  compiles_whole_ = false;  // while pictures are rough, those of the new device are compiled
  counts_ = {};
  device_.reset();
  FL_TRY(open_device());
  facts_.device = device_->name();
  const TimeNs at_ns = player_ ? player_->now_ns() : 0;
  const SharedScene before = std::exchange(framed_, edited_->scene());
  FL_TRY(rebuild(place_of(0)));
  if (before != framed_) {
    FL_TRY(take_scene(*before));
    if (player_) player_ = make_player(framed_, *log_);
    both_.change_rig();
    curve_.reset();
    thumbnails_.clear();
  }
  panels_.restart();
  last_ns_ = stepped_ns_ = clock_.now_ns();  // a log does not play meanwhile
  return player_ ? player_->seek(at_ns, driven()) : Status{};
}

namespace {

constexpr double kSecondsLeast = 1e-3;  // of --seconds that are over: 0 is without an end

// What the window of `options` leaves to those after it: without what belongs to the first one alone, and as its user
// has set it since.
void leave_to_next(PreviewOptions& options, const Preview& preview) {
  options.record.clear();
  options.compare.clear();
  options.compare_stage = word_of(StageCompare::kOff);
  options.recover = false;
  options.at_ns = 0;
  options.news.clear();
  if (options.seconds > 0) options.seconds = std::max(options.seconds - preview.seconds(), kSecondsLeast);
  options.ins = preview.inputs();
  options.hold_to_live = preview.holds_to_live();
  options.locked = preview.locked();
  options.outputs = preview.outputs();
  options.outputs_stay = true;
  if (const auto flashes = preview.flashes()) options.flashes = *flashes;
  keep_look(options, preview.settings());
}

}  // namespace

Result<int> run_preview(const PreviewOptions& options) {
  FL_ASSIGN(const std::string note, choose_words(options.language));
  if (!note.empty()) fmt::print(stderr, "footlight: {}\n", printable_utf8(note));
  PreviewOptions now = options;
  if (now.news.empty()) now.news = note;
  std::optional<PreviewOptions> before;  // of the window before, if this one was opened from it
  int worst = kExitOk;
  while (true) {
    if (needs_start(now)) {
      FL_ASSIGN(StartEnd end, run_start_window(now));
      if (!end.options) return worst;
      before = now;  // and back to it, with the log that was chosen, if the rig cannot be opened
      before->files.log = end.options->files.log;
      now = std::move(*end.options);
      if (now.seconds > 0) now.seconds = std::max(now.seconds - end.seconds, kSecondsLeast);
      continue;
    }
    std::optional<NextWindow> next;
    bool opened = false;
    const auto show = [&] {
      const PreviewOptions of_window = now;
      Preview preview(of_window);
      const Result<int> shown = preview.run();
      next = preview.next();
      opened = preview.opened();
      if (opened) leave_to_next(now, preview);
      return shown;
    };
    const Result<int> result = show();
    if (!result && before && !opened) {  // back to the rig from before
      now = *std::exchange(before, std::nullopt);
      now.news = result.error().message;
      continue;
    }
    if (!result) return result;
    worst = std::max(worst, *result);
    if (!next) return worst;
    before = now;
    now = options_for(now, *next);
  }
}

}  // namespace footlight::tools
