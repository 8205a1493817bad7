// The preview from picture to picture.
#include "tools/footlight/preview/preview_window.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fixtures/simulate/machines.h"
#include "tools/footlight/command.h"
#include "tools/footlight/pictures/scene_files.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kSettleNs = 200 * kNsPerMs;   // a new size is taken when the window has kept it for this long
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

}  // namespace

Result<int> Preview::run() {
  const Result<int> result = open_and_turn();
  outputs_.reset();  // also after an error: real lamps go dark before anything else is waited for
  end_recording();
  end_edits();
  return result;
}

Result<int> Preview::open_and_turn() {
  StopSignal signal;
  signal.also_hangup();
  FL_ASSIGN(const bool opened, open(signal));
  if (!opened) return kExitOk;
  start_ns_ = last_ns_ = second_ns_ = clock_.now_ns();
  device_->lose_from_environment();
  if (!options_.record.empty()) FL_TRY(start_recording(options_.record));
  while (!signal.came() && !((window_->wants_close() || closing_) && may_close())) {
    Status turned = turn();
    if (!turned && device_->lost()) turned = start_again(turned.error());
    FL_TRY(turned);
  }
  outputs_.reset();
  FL_TRY(window_->wait_gpu());
  if (!options_.screenshot.empty()) FL_TRY(write_shot());
  if (options_.json) print_summary();
  return validation_messages() == 0 ? kExitOk : kExitFailed;
}

// One picture.
Status Preview::turn() {
  window_->poll();
  const TimeNs now_ns = clock_.now_ns();
  const DurationNs dt_ns = now_ns - last_ns_;
  last_ns_ = now_ns;
  if (options_.seconds > 0 && static_cast<double>(now_ns - start_ns_) >= options_.seconds * 1e9) {
    closing_ = times_out_ = true;
    window_->keep_shot();
  }
  draw_ui();
  FL_TRY(window_->wait_gpu());
  if (std::exchange(shot_taken_, false)) write_own_shot();
  keep_edits();
  keep_markers();
  const PixelRect where = place();
  FL_ASSIGN(const bool still, follow_edits(where));
  if (still) {
    drive_outputs();
    return show_still(where);
  }
  FL_TRY(read_figures(dt_ns));

  if (where.width != wanted_width_ || where.height != wanted_height_) {
    wanted_width_ = where.width;
    wanted_height_ = where.height;
    wanted_since_ns_ = now_ns;
  }
  const render::FrameSettings& settings = frame_->settings();
  const bool other_size = settings.width != std::max(where.width / controls_.divisor, 1) ||
                          settings.height != std::max(where.height / controls_.divisor, 1);
  render::Knobs knobs = knobs_;
  knobs.nodes = static_cast<std::uint32_t>(controls_.nodes);
  render::Knobs drawn = render::knobs_of(settings);
  drawn.divisor = knobs.divisor;  // a part of the size
  if (knobs.gobo_method == render::GoboMethod::kSuited) drawn.gobo_method = knobs.gobo_method;
  const bool other_knobs = drawn != knobs;
  if (other_knobs || controls_.haze != settings.haze || other_display(controls_, settings) ||
      (other_size && now_ns - wanted_since_ns_ >= kSettleNs && !window_->minimised())) {
    FL_TRY(rebuild(where));
  }
  FL_TRY(update_error());
  follow_inputs();
  FL_TRY(step_levels(dt_ns));
  keep_recording();
  show_videos();
  drive_outputs();
  frame_->adapt_for(dt_ns);    // also while the log is paused
  if (window_->minimised()) {  // the fixtures continue without pictures
    shown_ = false;
    return frame_->run_steps();
  }

  FL_TRY(draw(where, now_ns));
  if (shown_) shot_taken_ = std::exchange(shot_asked_, false);
  if (shown_ && picture_ns_ < 0) picture_ns_ = clock_.now_ns() - begun_ns_;
  return {};
}

Status Preview::draw(const PixelRect& where, TimeNs now_ns) {
  const VkImage screen = frame_->resources().picture.screen.handle;
  const render::FrameSettings& settings = frame_->settings();
  WindowPicture picture;
  picture.image = screen;
  picture.width = settings.width;
  picture.height = settings.height;
  picture.place = where;
  drawn_ns_ = now_ns;
  const auto compute = [&](VkCommandBuffer commands) {
    frame_->set_work_light_lx(controls_.work_light ? static_cast<double>(controls_.work_light_lx) : 0);
    frame_->record(commands, render::view_of(desk_->state().camera.camera()), controls_.exposure_ev);
    error_drawn_ = error_ != nullptr;
    if (error_) error_->record(commands);
    render::vk::full_barrier(commands);
    const VkBufferCopy region{0, 0, sizeof(render::CountsRow)};
    vkCmdCopyBuffer(commands, frame_->resources().rig.counts.handle, counts_.handle, 1, &region);
    render::vk::host_barrier(commands);
    if (flashes_) flashes_->record_read(commands, screen, settings.width, settings.height);
  };
  if (!flashes_ || !flashes_->limits()) {
    FL_ASSIGN(shown_, window_->show(picture, compute));
    return {};
  }
  // Whether the picture may be shown is known when it is done.
  FL_TRY(flashes_->resize(settings.width, settings.height));
  FL_TRY(device_->run_once(compute));
  const std::size_t stretches = flashes_->watch().stretches().size();
  const bool waits = flashes_->must_wait(now_ns - start_ns_);
  tell_flashes(flashes_->watch().stretches().size() > stretches);
  facts_.flashes_held = waits;
  if (waits) picture.image = flashes_->standing();
  FL_ASSIGN(shown_, window_->show(picture, [&](VkCommandBuffer commands) {
    if (!waits) flashes_->record_keep(commands, screen);
  }));
  return {};
}

// Of the picture that is now finished.
Status Preview::read_figures(DurationNs dt_ns) {
  if (shown_) {
    times_.add(static_cast<double>(dt_ns) * 1e-6);
    ++second_frames_;
    FL_ASSIGN(facts_.passes, frame_->read_times());
    double gpu_ms = 0;
    for (const auto& pass : facts_.passes) gpu_ms += pass.gpu_ms;
    if (facts_.passes.empty()) gpu_ms = static_cast<double>(dt_ns) * 1e-6;  // a device without time stamps
    if (keeper_ && keeper_->take(drawn_ns_, gpu_ms)) follow_knobs(keeper_->point());
    if (error_ && error_drawn_) {
      FL_TRY(error_->take(drawn_ns_));
      facts_.error = error_->estimate();
      facts_.passes.push_back({"error", error_->gpu_ms()});
    }
    render::CountsRow counts{};
    std::memcpy(&counts, counts_.mapped, sizeof(counts));
    facts_.live_beams = counts.live_count;
    facts_.dark_beams = counts.dark_count;
    facts_.shadows = counts.shadows;
    facts_.shadows_lost = counts.shadows_lost;
    if (flashes_ && !flashes_->limits()) tell_flashes(flashes_->take(drawn_ns_ - start_ns_));
  }
  facts_.now_ns = clock_.now_ns();
  facts_.room_haze_per_m = framed_->rig.haze.scattering_per_m;
  if (const fixtures::MachineAir* air = frame_->machine_air(); air != nullptr) {
    facts_.machines = air->count();
    facts_.machine_haze_per_m = air->haze_per_m();
    facts_.machine_fog_per_m = air->fog_per_m();
  }
  facts_.width = frame_->settings().width;
  facts_.height = frame_->settings().height;
  facts_.gpu_mib = static_cast<double>(frame_->bytes()) / (1024.0 * 1024.0);
  const DurationNs since_ns = facts_.now_ns - second_ns_;
  if (since_ns >= kNsPerS) {
    facts_.fps = static_cast<double>(second_frames_) * 1e9 / static_cast<double>(since_ns);
    second_ns_ = facts_.now_ns;
    second_frames_ = 0;
    if (const LiveLevels* shown = shown_levels()) facts_.status = shown->status();
    if (live_) {
      for (std::string& notice : live_->notices()) {
        if (!options_.json) fmt::print(stderr, "footlight: {}\n", notice);
        tell(notice);
        facts_.notice = std::move(notice);
      }
    }
    facts_.frame_p50_ms = times_.quantile_ms(0.5);
    facts_.frame_p90_ms = times_.quantile_ms(0.9);
    facts_.ui_ms = ui_times_.quantile_ms(0.5);
    if (options_.json) print_second();
  }
  return {};
}

void Preview::tell_flashes(bool begins) {
  facts_.flashes_harmful = flashes_->watch().harmful();
  if (!begins) return;
  if (options_.json) {
    const nlohmann::json line = {{"event", "flashes-begin"}, {"time_ns", drawn_ns_ - start_ns_}};
    fmt::print("{}\n", line.dump());
  } else {
    fmt::print(stderr, "footlight: flashes that can harm people with photosensitive epilepsy{}\n",
               flashes_->limits() ? "; held back" : "; --flashes limit holds them back");
  }
}

void Preview::follow_knobs(const render::KnobPoint& point) {
  facts_.chosen = point;
  knobs_ = point.knobs;
  controls_.nodes = static_cast<int>(point.knobs.nodes);
  if (keeper_) controls_.divisor = point.knobs.divisor;
}

// The measurement of the error exists while the panel shows it, and is made anew for another frame.
Status Preview::update_error() {
  const bool shown = controls_.panel == PanelState::kFull && !window_->minimised();
  if (!shown) {
    error_.reset();
    facts_.error = {};
    error_tried_ = false;
  } else if (!error_ && !error_tried_) {
    error_tried_ = true;
    const fixtures::Needs& needs = framed_->compiled.needs;
    if (needs.laser || needs.panes || needs.displays) return {};  // it computes beams again, and nothing else
    FL_ASSIGN(error_, render::LiveError::create(*device_, *frame_, needs));
  }
  return {};
}

// The current size, nodes and haze.
render::FrameSettings Preview::frame_settings(const PixelRect& where) const {
  render::FrameSettings settings;
  settings.width = std::max(where.width / controls_.divisor, 1);
  settings.height = std::max(where.height / controls_.divisor, 1);
  settings = render::with_knobs(settings, knobs_);
  settings.nodes = static_cast<std::uint32_t>(controls_.nodes);
  settings.edge_samples = options_.edge_samples.value_or(render::suited_edge_samples(*device_));
  settings.shadows = options_.display.shadows;
  settings.shadow_map_px = options_.display.shadow_map_px;
  settings.bounce = options_.bounce;
  take_display(controls_, settings);
  settings.haze = controls_.haze;
  return settings;
}

// A frame of these settings. The states of the fixtures move from the old frame to the new one.
Status Preview::rebuild(const PixelRect& where) {
  const render::FrameSettings settings = frame_settings(where);
  error_.reset();
  error_tried_ = error_drawn_ = false;
  if (frame_) {
    FL_TRY(frame_->change(settings));
  } else {
    FL_ASSIGN(frame_, render::Frame::create(*device_, framed_->rig, framed_->compiled, settings));
    videos_.show_all_again();
    print_warnings(frame_->resources().rig.diagnostics);
    if (hand_) frame_->settle_machine_air(hand_->levels());
  }
  shown_ = false;
  wanted_width_ = where.width;
  wanted_height_ = where.height;
  return {};
}

// After the loss of the device: a new one, and a frame made from it. Heads that follow a log go where the log has them;
// others start from where their channels stand. A device that is lost again and again ends the preview.
Status Preview::start_again(const Error& loss) {
  const TimeNs now_ns = clock_.now_ns();
  losses_ = now_ns - lost_ns_ < kLossPauseNs ? losses_ + 1 : 1;
  lost_ns_ = now_ns;
  if (losses_ > kLossesMax) return tl::unexpected<Error>(loss);
  if (options_.json) {
    const nlohmann::json line = {{"event", "device-lost"}, {"message", loss.message}};
    fmt::print("{}\n", line.dump());
    std::fflush(stdout);
  } else {
    fmt::print(stderr, "footlight: {}; going on with a new device\n", loss.message);
  }
  messages_before_ = validation_messages();
  drop_frame();
  error_.reset();
  frame_.reset();
  flashes_.reset();
  counts_ = {};
  window_->detach();
  device_.reset();
  FL_TRY(open_device());
  facts_.device = device_->name();
  const TimeNs at_ns = player_ ? player_->now_ns() : 0;
  const SharedScene before = std::exchange(framed_, edited_->scene());
  FL_TRY(rebuild(place()));
  if (before != framed_) {
    FL_TRY(take_scene(*before));
    if (player_) player_ = make_player(framed_);
    curve_.reset();
  }
  panels_.restart();
  last_ns_ = clock_.now_ns();  // a log does not play meanwhile
  return player_ ? player_->seek(at_ns, driven()) : Status{};
}

Result<int> run_preview(const PreviewOptions& options) { return Preview(options).run(); }

}  // namespace footlight::tools
