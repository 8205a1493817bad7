// The loop of `footlight preview`: levels from a log, an input or faders -> Frame -> window.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>

#include <GLFW/glfw3.h>

#include <imgui/imgui.h>

#include <nlohmann/json.hpp>

#include "fixtures/simulate/machines.h"
#include "render/frame.h"
#include "render/live_error.h"
#include "render/quality.h"
#include "sim/core/no_signals.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/knob_curves.h"
#include "tools/footlight/pictures/numbered_file.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/live_levels.h"
#include "tools/footlight/preview/orbit_camera.h"
#include "tools/footlight/preview/preview.h"
#include "tools/footlight/preview/preview_flashes.h"
#include "tools/footlight/preview/preview_panel.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/stage_marks.h"
#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/ui_desk.h"
#include "tools/footlight/preview/window.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kExposureMaxNs = 20 * kNsPerMs;  // as `footlight render --at`; less if the frame is shorter
constexpr std::size_t kStepsHeldMax = 512;            // steps that wait for the GPU
constexpr DurationNs kWireDelayNs = 2 * kNsPerMs;     // live pictures are that late: looks may be on their way
constexpr DurationNs kSettleNs = 200 * kNsPerMs;      // a new size is taken when the window has kept it for this long
constexpr int kStripWidth = 800;                      // in a window narrower than this the panel begins as a strip
constexpr int kSoftwarePixels = 640 * 360;            // about as many as a software renderer begins with
constexpr std::chrono::milliseconds kQuickRead(200);  // a rig that is read sooner is read before the window opens
constexpr double kProgressS = 0.1;                    // from text to text while it loads
constexpr DurationNs kLossPauseNs = 60 * kNsPerS;     // devices that are lost sooner one after the other are counted
constexpr int kLossesMax = 3;
constexpr double kSeekStepS = 5;
constexpr double kExposureStepEv = 0.25;
constexpr double kOrbitRad = 3;  // per drag over the height of the window
constexpr float kClickUnits = 4;  // a press that moves less is a click
constexpr DurationNs kNewsNs = 4 * kNsPerS;
constexpr int kShotsMax = 9999;

// The last times from picture to picture.
class FrameTimes {
 public:
  void add(double ms) { ring_[count_++ % ring_.size()] = ms; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double quantile_ms(double share) const {
    const std::size_t held = std::min<std::size_t>(static_cast<std::size_t>(count_), ring_.size());
    if (held == 0) return 0;
    std::vector<double> sorted(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(held));
    const auto at = static_cast<std::ptrdiff_t>(std::llround(share * static_cast<double>(held - 1)));
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
    return sorted[static_cast<std::size_t>(at)];
  }

 private:
  std::array<double, 256> ring_{};
  std::uint64_t count_ = 0;
};

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

class Preview {
 public:
  explicit Preview(const PreviewOptions& options) : options_(options), opener_(clock_) {}

  Result<int> run() {
    const StopSignal signal;
    FL_ASSIGN(const bool opened, open(signal));
    if (!opened) return kExitOk;
    start_ns_ = last_ns_ = second_ns_ = clock_.now_ns();
    device_->lose_from_environment();
    while (!window_->wants_close() && !signal.came() && !closing_) {
      Status turned = turn();
      if (!turned && device_->lost()) turned = start_again(turned.error());
      FL_TRY(turned);
    }
    FL_TRY(window_->wait_gpu());
    if (!options_.screenshot.empty()) FL_TRY(write_shot());
    if (options_.json) print_summary();
    return validation_messages() == 0 ? kExitOk : kExitFailed;
  }

 private:
  // False: closed while loading.
  Result<bool> open(const StopSignal& signal);
  Status load_rig(double aspect);
  Status open_levels();
  Status open_device();
  Status start_again(const Error& loss);
  [[nodiscard]] std::size_t validation_messages() const {
    return messages_before_ + device_->validation_messages().size();
  }
  Status set_controls(const fixtures::Camera& camera);
  void give(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure);
  [[nodiscard]] std::span<const std::uint8_t> panel_levels();
  void draw_ui();
  Result<bool> wait_for(std::future<Status>& work, const StopSignal& signal, const char* what);
  Status show_progress(const char* what);
  Status turn();
  Status rebuild(const PixelRect& where);
  Status make_ladder();
  void follow_knobs(const render::KnobPoint& point);
  Status update_error();
  Status replay_to(DurationNs until_ns, DurationNs exposure_ns);
  Status advance(Timeline& timeline, TimeNs until_ns, DurationNs exposure_ns);
  Status step_levels(DurationNs dt_ns);
  Status read_figures(DurationNs dt_ns);
  Status draw(const PixelRect& where, TimeNs now_ns);
  void tell_flashes(bool begins);
  void take_input();
  void take_mouse();
  void call(const UiCall& call);
  void escape();
  void take_camera(std::size_t index);
  void frame_box(const glm::dvec3& low_m, const glm::dvec3& high_m);
  void tell(std::string news);
  void write_own_shot();
  void expose(double steps_ev);
  void seek(double by_s);
  Status write_shot();
  [[nodiscard]] nlohmann::json figures() const;
  void print_second();
  void print_summary();
  [[nodiscard]] std::optional<fixtures::VrslReplay> vrsl_replay() const;
  [[nodiscard]] PixelRect place() const;
  [[nodiscard]] StagePlace stage() const;
  [[nodiscard]] const StagePick& pick();
  // True if neither a log nor an input drives the rig.
  [[nodiscard]] bool by_hand() const {
    return options_.ins.empty() && options_.files.log.empty() && !options_.files.demo;
  }

  const PreviewOptions& options_;
  SystemClock clock_;
  PortOpener opener_;
  fixtures::Rig rig_;
  fixtures::CompiledRig compiled_;
  std::optional<fixtures::Rig> vrsl_rig_;  // as written, where rig_ is what VRSL shows of it

  // What drives the rig: one of the three.
  std::unique_ptr<Timeline> timeline_;
  std::unique_ptr<LiveLevels> live_;
  std::unique_ptr<Timeline> live_timeline_;
  std::unique_ptr<HandLevels> hand_;

  std::unique_ptr<render::vk::Device> device_;  // outlives the window's swapchain
  std::unique_ptr<Window> window_;
  std::unique_ptr<render::Frame> frame_;
  std::unique_ptr<PreviewFlashes> flashes_;   // null: --flashes off
  TimeNs drawn_ns_ = 0;                       // when the current picture was started
  render::vk::Buffer counts_;                 // of the current picture, for the panel
  std::unique_ptr<render::LiveError> error_;  // while the panel shows it; null in a rig without light
  render::Knobs knobs_;                       // but for nodes and divisor, which are those of controls_
  bool error_tried_ = false;                  // error_ was made, or cannot be
  bool error_drawn_ = false;                  // the current picture has its samples
  std::vector<render::KnobPoint> ladder_;     // for --error and --ms; else empty
  std::optional<render::TimeKeeper> keeper_;  // for --ms
  std::atomic<bool> closed_ = false;          // while other threads worked: they may end early
  bool shown_ = false;                        // a picture is in flight; its figures can be read when it is done

  std::unique_ptr<UiDesk> desk_;  // once the rig is read
  UiPanels panels_;
  std::unique_ptr<StagePick> pick_;       // made by the first selection
  std::vector<std::uint8_t> log_levels_;  // that the log gave last
  std::vector<std::uint8_t> overlaid_;    // levels with what was taken over
  std::vector<std::uint8_t> panel_levels_;
  bool moves_in_pause_ = false;   // something was taken over since the log was paused
  bool pressed_on_stage_ = false;
  bool shot_asked_ = false;  // the next picture is kept
  bool shot_taken_ = false;
  std::string news_;
  TimeNs news_until_ns_ = 0;
  FrameTimes ui_times_;
  PreviewControls controls_;
  PreviewFacts facts_;
  FrameTimes times_;
  int wanted_width_ = 0;  // of the window's place for the picture when last looked at, and since when
  int wanted_height_ = 0;
  TimeNs wanted_since_ns_ = 0;

  TimeNs begun_ns_ = 0;
  DurationNs progress_ns_ = -1;  // from there to the first text in the window; -1: not yet
  DurationNs picture_ns_ = -1;   // to the first picture
  TimeNs start_ns_ = 0;
  TimeNs last_ns_ = 0;
  TimeNs second_ns_ = 0;  // when the figures were last computed
  std::uint64_t second_frames_ = 0;
  bool closing_ = false;
  int losses_ = 0;  // of devices, shortly one after the other
  TimeNs lost_ns_ = 0;
  std::size_t messages_before_ = 0;  // of the validation layer, of devices that were lost
};

// Runs `work` on its own thread.
template <class Work>
std::future<Status> begin(Work work) {
  const NoSignals no_signals;
  return std::async(std::launch::async, std::move(work));
}

Status Preview::load_rig(double aspect) {
  FL_ASSIGN(rig_, load_scene_rig(options_.files));
  add_start_view(rig_, aspect, true);
  if (by_hand()) give_hand_addresses(rig_);
  if (rig_.vrsl && !by_hand()) vrsl_rig_ = std::exchange(rig_, fixtures::vrsl_shown(rig_));
  FL_ASSIGN(compiled_, fixtures::compile(rig_));
  return {};
}

// The device and what is made from it but for the frame.
Status Preview::open_device() {
  render::vk::DeviceOptions device;
  device.instance_extensions = window_->instance_extensions();
  device.swapchain = true;
  device.name_contains = options_.device;
  device.cache_folder = cache_folder();
  FL_ASSIGN(device_, render::vk::Device::create(device));
  for (const std::string& note : device_->notes()) fmt::print(stderr, "footlight: {}\n", note);
  FL_TRY(window_->attach(*device_));
  FL_ASSIGN(counts_, render::vk::Buffer::host_visible(*device_, sizeof(render::CountsRow), 0));
  if (options_.flashes != FlashMode::kOff) {
    FL_ASSIGN(flashes_, PreviewFlashes::make(*device_, options_.flashes == FlashMode::kLimit));
  }
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
  error_.reset();
  frame_.reset();
  flashes_.reset();
  counts_ = {};
  window_->detach();
  device_.reset();
  FL_TRY(open_device());
  FL_TRY(rebuild(place()));
  if (!timeline_) return {};
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options_.files));
  if (!log) return fail(ErrorCode::kIo, "{}: the log is gone", options_.files.log);
  const TimeNs until_ns = timeline_->now_ns();
  timeline_ = std::make_unique<Timeline>(std::move(*log), compiled_, vrsl_replay());
  return advance(*timeline_, until_ns, 0);
}

Status Preview::set_controls(const fixtures::Camera& camera) {
  desk_ = std::make_unique<UiDesk>(rig_, compiled_);
  desk_->start_camera(OrbitCamera(camera));
  FL_TRY(panels_.open_words(options_.panels, *desk_));
  if (!options_.select.empty()) {
    desk_->select_named(options_.select);
    if (desk_->state().selection.fixtures.empty()) {
      return fail(ErrorCode::kNotFound, "--select {}: no fixture of this rig has such a name", options_.select);
    }
  }
  controls_.exposure_ev = static_cast<float>(camera.exposure_ev);
  knobs_.nodes = static_cast<std::uint32_t>(options_.nodes);
  knobs_.tile_error = options_.tile_error;
  knobs_.body_error_px = options_.body_error_px;
  controls_.nodes = options_.nodes;
  controls_.glare_percent = static_cast<float>(100 * options_.display.glare);
  controls_.auto_exposure = options_.display.auto_exposure;
  controls_.tone = options_.display.tone;
  controls_.balances_white = options_.display.white_k > 0;
  if (options_.display.white_k > 0) controls_.white_k = static_cast<float>(options_.display.white_k);
  facts_.quality = options_.quality;
  const double usual_lx = work_light_lx(camera.exposure_ev);
  controls_.work_light = options_.work_light_lx.value_or(by_hand() ? usual_lx : 0) > 0;
  const double asked_lx = options_.work_light_lx.value_or(0);
  controls_.work_light_lx = static_cast<float>(asked_lx > 0 ? asked_lx : usual_lx);
  controls_.loop = options_.files.demo && options_.files.log.empty();
  controls_.panel = window_->width() < kStripWidth ? PanelState::kStrip : PanelState::kFull;
  if (device_->is_software()) {
    // One picture every few seconds is too slow: start with fewer pixels; the user can select all of them.
    const int pixels = place().width * place().height;
    while (controls_.divisor < 4 && pixels / (controls_.divisor * controls_.divisor) > kSoftwarePixels) {
      controls_.divisor *= 2;
    }
  }
  facts_.rig = rig_.name;
  facts_.device = device_->name();
  for (const auto& one : rig_.cameras) facts_.cameras.push_back(one.name);
  for (const auto& fixture : rig_.fixtures) facts_.fixtures.push_back(fixture.name);
  facts_.can_haze = compiled_.needs.haze;
  return {};
}

// The window opens first and shows the progress, while another thread reads the rig and then makes the frame. A rig
// that loads quickly is read first, so that its errors are printed before the window opens.
Result<bool> Preview::open(const StopSignal& signal) {
  FL_ASSIGN(const PictureSize size, parse_size(options_.size));
  if (!options_.ins.empty() && !options_.files.log.empty()) {
    return fail(ErrorCode::kBadInput, "--log and --in: expected one of them");
  }
  FL_TRY(check_panel_words(options_.panels));
  begun_ns_ = clock_.now_ns();
  const double aspect = static_cast<double>(size.width) / size.height;
  std::future<Status> reading = begin([this, aspect] { return load_rig(aspect); });
  fixtures::Camera camera;
  const auto take_rig = [&]() -> Status {
    FL_ASSIGN(camera, find_camera(rig_, options_.camera));
    return open_levels();
  };
  const bool quick = reading.wait_for(kQuickRead) == std::future_status::ready;
  if (quick) {
    FL_TRY(reading.get());
    FL_TRY(take_rig());
  }
  FL_ASSIGN(window_, Window::open("Footlight", size.width, size.height));
  FL_TRY(open_device());
  if (!quick) {
    FL_TRY(show_progress("Reading the rig"));
    FL_ASSIGN(const bool goes_on, wait_for(reading, signal, "Reading the rig"));
    if (!goes_on) return false;
    FL_TRY(take_rig());
  }
  window_->set_title(fmt::format("{} - Footlight", rig_.name));
  FL_TRY(show_progress("Preparing the picture"));
  FL_TRY(set_controls(camera));
  const PixelRect where = place();
  std::future<Status> making = begin([this, where]() -> Status {
    FL_TRY(make_ladder());
    FL_TRY(rebuild(where));
    return timeline_ ? replay_to(options_.at_ns, 0) : Status{};
  });
  return wait_for(making, signal, "Preparing the picture");
}

// Keeps the window responsive until the work is done. False: it was closed, and the work is done.
Result<bool> Preview::wait_for(std::future<Status>& work, const StopSignal& signal, const char* what) {
  while (work.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    window_->poll(kProgressS);
    if (signal.came() || window_->wants_close()) {
      window_->hide();
      closed_ = true;
      (void)work.get();  // what failed since is of no use any more
      return false;
    }
    FL_TRY(show_progress(what));
  }
  FL_TRY(work.get());
  return true;
}

Status Preview::show_progress(const char* what) {
  window_->begin_ui();
  const double seconds = static_cast<double>(clock_.now_ns() - begun_ns_) * 1e-9;
  draw_progress(fmt::format("{} ... {:.0f} s", what, seconds));
  window_->end_ui();
  FL_ASSIGN(const bool shown, window_->show({}, [](VkCommandBuffer) {}));
  if (shown && progress_ns_ < 0) {
    progress_ns_ = clock_.now_ns() - begun_ns_;
    if (options_.json) {
      fmt::print(R"({{"event":"loading","ms":{:.1f}}})"
                 "\n",
                 static_cast<double>(progress_ns_) * 1e-6);
      std::fflush(stdout);
    }
  }
  return {};
}

// VRSL's processing of the levels, from its start; nothing if the rig does not use it.
std::optional<fixtures::VrslReplay> Preview::vrsl_replay() const {
  if (!vrsl_rig_) return std::nullopt;
  return fixtures::VrslReplay(*vrsl_rig_, compiled_);
}

Status Preview::open_levels() {
  if (!options_.ins.empty()) {
    std::vector<std::unique_ptr<Source>> sources;
    for (const std::string& text : options_.ins) {
      FL_ASSIGN(const Endpoint endpoint, parse_port(text));
      InOptions in;
      in.hear_preview = true;  // such frames are meant for visualisers like this one
      in.yields = true;        // a bridge keeps its unicast frames
      FL_ASSIGN(std::unique_ptr<Source> source, opener_.open_source(endpoint, in));
      sources.push_back(std::move(source));
    }
    FL_ASSIGN(live_, LiveLevels::start(compiled_.universes, std::move(sources), clock_));
    live_timeline_ = std::make_unique<Timeline>(live_->changes(), compiled_, vrsl_replay(), clock_.now_ns());
    return {};
  }
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options_.files));
  if (log) {
    timeline_ = std::make_unique<Timeline>(std::move(*log), compiled_, vrsl_replay());
    facts_.has_log = true;
    facts_.duration_s = static_cast<double>(timeline_->duration_ns()) * 1e-9;
  } else {
    hand_ = std::make_unique<HandLevels>(rig_, compiled_);
  }
  return {};
}

// The part of the window beside the panel.
PixelRect Preview::place() const {
  const float panel_px =
      controls_.panel == PanelState::kFull ? kPanelWidth * window_->ui_scale() * window_->pixels_per_unit() : 0;
  return {0, 0, std::max(window_->width() - static_cast<int>(std::lround(panel_px)), 1),
          std::max(window_->height(), 1)};
}

// The curves of this machine, which take seconds to measure the first time, and the knobs that follow from them.
Status Preview::make_ladder() {
  const render::QualityRequest& request = options_.quality;
  if (!(request.error > 0) && !(request.ms > 0)) return {};
  KnobCurveOptions curve_options = suited_curve_options(*device_);
  curve_options.go_on = [this](double, double) { return !closed_; };
  FL_ASSIGN(const render::KnobCurves curves, machine_knob_curves(*device_, cache_folder(), curve_options, [this] {
              if (!options_.json) fmt::print(stderr, "footlight: measuring the knobs of {}\n", device_->name());
            }));
  ladder_ = render::ladder_of(curves, compiled_.needs, request);
  if (ladder_.empty()) return {};
  // For a time, the first picture has the knobs nearest the default ones; how long it takes is then known.
  const auto usual = render::predicted(curves, compiled_.needs, {});
  const std::size_t start = request.error > 0 ? render::choose(ladder_, request)
                            : usual           ? render::nearest(ladder_, usual->ms)
                                              : 0;
  if (request.ms > 0) keeper_.emplace(ladder_, request.ms, start);
  follow_knobs(ladder_[start]);
  return {};
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
    if (compiled_.needs.laser || compiled_.needs.panes || compiled_.needs.displays) return {};  // it computes beams again, and nothing else
    FL_ASSIGN(error_, render::LiveError::create(*device_, *frame_, compiled_.needs));
  }
  return {};
}

// A frame of the current size, nodes and haze. The states of the fixtures move from the old frame to the new one.
Status Preview::rebuild(const PixelRect& where) {
  render::FrameSettings settings;
  settings.width = std::max(where.width / controls_.divisor, 1);
  settings.height = std::max(where.height / controls_.divisor, 1);
  settings = render::with_knobs(settings, knobs_);
  settings.nodes = static_cast<std::uint32_t>(controls_.nodes);
  settings.edge_samples = options_.edge_samples.value_or(render::suited_edge_samples(*device_));
  settings.shadows = options_.shadows;
  settings.bounce = options_.bounce;
  take_display(controls_, settings);
  settings.haze = controls_.haze;
  error_.reset();
  error_tried_ = error_drawn_ = false;
  if (frame_) {
    FL_TRY(frame_->change(settings));
  } else {
    FL_ASSIGN(frame_, render::Frame::create(*device_, rig_, compiled_, settings));
    print_warnings(frame_->resources().rig.diagnostics);
    if (hand_) frame_->settle_machine_air(hand_->levels());
  }
  shown_ = false;
  wanted_width_ = where.width;
  wanted_height_ = where.height;
  return {};
}

// Seeks to a time of the log, from its start if that is earlier. Then every fixture starts again, so that the picture
// is the one that `footlight render` makes of this moment.
Status Preview::replay_to(DurationNs until_ns, DurationNs exposure_ns) {
  until_ns = std::clamp<DurationNs>(until_ns, 0, timeline_->duration_ns());
  if (until_ns < timeline_->now_ns()) {
    FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options_.files));
    if (!log) return fail(ErrorCode::kIo, "{}: the log can no longer be read", options_.files.log);
    timeline_ = std::make_unique<Timeline>(std::move(*log), compiled_, vrsl_replay());
    FL_TRY(frame_->run_steps());
    FL_TRY(device_->run_once([&](VkCommandBuffer commands) { render::forget_states(commands, frame_->resources()); }));
    frame_->forget_air();
    panels_.restart();
  }
  return advance(*timeline_, until_ns, exposure_ns);
}

Status Preview::advance(Timeline& timeline, TimeNs until_ns, DurationNs exposure_ns) {
  Status flushed;
  FL_TRY(timeline.advance(until_ns, exposure_ns,
                          [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                            if (timeline_) log_levels_.assign(levels.begin(), levels.end());
                            give(levels, dt_ns, new_exposure);
                            if (frame_->pending_steps() >= kStepsHeldMax && flushed) flushed = frame_->run_steps();
                          }));
  return flushed;
}

// One step of the fixtures and of what the panels follow, with what the user has taken over.
void Preview::give(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure) {
  if (desk_->overlays()) {
    overlaid_.assign(levels.begin(), levels.end());
    desk_->overlay(overlaid_);
    levels = overlaid_;
  }
  frame_->step(levels, dt_ns, new_exposure);
  panels_.step(levels, dt_ns, new_exposure);
}

// The newest levels, as the panels show them.
std::span<const std::uint8_t> Preview::panel_levels() {
  const std::span<const std::uint8_t> newest = live_   ? live_->levels()
                                               : hand_ ? hand_->levels()
                                                       : std::span<const std::uint8_t>(log_levels_);
  if (!desk_->overlays()) return newest;
  panel_levels_.assign(newest.begin(), newest.end());
  desk_->overlay(panel_levels_);
  return panel_levels_;
}

Status Preview::step_levels(DurationNs dt_ns) {
  if (live_) {
    live_->take();
    const TimeNs until_ns = std::max(last_ns_ - kWireDelayNs, live_timeline_->now_ns());
    FL_TRY(advance(*live_timeline_, until_ns, std::min(dt_ns, kExposureMaxNs)));
  } else if (hand_) {
    give(hand_->levels(), dt_ns, true);
  } else {
    if (controls_.seek_s) {
      moves_in_pause_ = false;
      FL_TRY(replay_to(static_cast<DurationNs>(*controls_.seek_s * 1e9), kExposureMaxNs));
      controls_.seek_s.reset();
    } else if (controls_.playing) {
      DurationNs until_ns = timeline_->now_ns() + dt_ns;
      if (until_ns > timeline_->duration_ns() && controls_.loop) until_ns = 0;
      FL_TRY(replay_to(until_ns, std::min(dt_ns, kExposureMaxNs)));
      moves_in_pause_ = false;
    } else {
      // What is taken over moves in a pause, and goes back when it is released; then all fixtures go on.
      moves_in_pause_ = moves_in_pause_ || desk_->overlays();
      if (moves_in_pause_ && !log_levels_.empty()) give(log_levels_, dt_ns, true);
    }
    facts_.time_s = static_cast<double>(timeline_->now_ns()) * 1e-9;
  }
  return {};
}

void Preview::take_camera(std::size_t index) {
  if (index >= rig_.cameras.size()) return;
  desk_->run(MoveCamera{OrbitCamera(rig_.cameras[index]), {}});
  controls_.exposure_ev = static_cast<float>(rig_.cameras[index].exposure_ev);
}

StagePlace Preview::stage() const {
  const PixelRect where = place();
  const double scale = static_cast<double>(window_->pixels_per_unit());
  return {render::view_of(desk_->state().camera.camera()), {where.width / scale, where.height / scale}};
}

const StagePick& Preview::pick() {
  if (!pick_) pick_ = std::make_unique<StagePick>(rig_);
  return *pick_;
}

void Preview::frame_box(const glm::dvec3& low_m, const glm::dvec3& high_m) {
  const PixelRect where = place();
  OrbitCamera camera = desk_->state().camera;
  camera.frame(low_m, high_m, static_cast<double>(where.width) / where.height);
  desk_->run(MoveCamera{camera, {}});
}

void Preview::tell(std::string news) {
  news_ = std::move(news);
  news_until_ns_ = clock_.now_ns() + kNewsNs;
}

// Everything that is drawn over the picture, and what it and the keys ask for.
void Preview::draw_ui() {
  const TimeNs begun_ns = clock_.now_ns();
  window_->begin_ui();
  for (int button = 0; button < 3; ++button) {
    if (ImGui::IsMouseClicked(button) || ImGui::IsMouseReleased(button)) desk_->begin_gesture();
  }
  std::optional<UiCall> chosen;
  draw_panel(facts_, controls_, live_.get(), hand_.get(), window_->ui_scale(),
             [&] { chosen = draw_menu(*desk_, panels_, timeline_ != nullptr); });
  const StagePlace where = stage();
  if (panels_.any_open()) {
    UiInput input;
    input.levels = panel_levels();
    if (live_) input.stamps = live_->stamps();
    if (live_) input.status = &facts_.status;
    input.now_ns = clock_.now_ns();
    input.scale = window_->ui_scale();
    panels_.draw(*desk_, input, static_cast<float>(where.size.x), static_cast<float>(where.size.y));
  }
  if (chosen) call(*chosen);
  take_input();
  if (const Selection& selection = desk_->state().selection; !selection.fixtures.empty()) {
    draw_marks(rig_, pick(), stage(), selection, window_->ui_scale());
  }
  if (begun_ns < news_until_ns_) draw_news(news_, where, window_->ui_scale());
  if (closing_ || window_->wants_close() || shot_asked_) window_->keep_shot();
  window_->end_ui();
  ui_times_.add(static_cast<double>(clock_.now_ns() - begun_ns) * 1e-6);
}

void Preview::take_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) pressed_on_stage_ = !io.WantCaptureMouse;
  if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && std::exchange(pressed_on_stage_, false) &&
      io.MouseDragMaxDistanceSqr[0] < kClickUnits * kClickUnits) {
    const int fixture = pick().fixture_at(stage(), {io.MouseClickedPos[0].x, io.MouseClickedPos[0].y});
    desk_->select(fixture, io.KeyCtrl || io.KeyShift);
  }
  if (io.WantCaptureMouse) return;
  // Mouse movement before the button went down in the same frame does not count, nor that of a click.
  const auto drags = [&](ImGuiMouseButton button) {
    return ImGui::IsMouseDown(button) && !ImGui::IsMouseClicked(button) &&
           io.MouseDragMaxDistanceSqr[button] >= kClickUnits * kClickUnits;
  };
  const double heights = 1.0 / std::max(static_cast<double>(io.DisplaySize.y), 1.0);
  const double right = static_cast<double>(io.MouseDelta.x) * heights;
  const double down = static_cast<double>(io.MouseDelta.y) * heights;
  OrbitCamera camera = desk_->state().camera;
  bool moves = io.MouseWheel != 0;
  if (drags(ImGuiMouseButton_Left)) {
    camera.orbit(-right * kOrbitRad, down * kOrbitRad);
    moves = moves || right != 0 || down != 0;
  } else if (drags(ImGuiMouseButton_Right) || drags(ImGuiMouseButton_Middle)) {
    camera.pan(-right, down);
    moves = moves || right != 0 || down != 0;
  }
  camera.approach(static_cast<double>(io.MouseWheel));
  if (moves) desk_->run(MoveCamera{camera, {}});
}

void Preview::take_input() {
  const ImGuiIO& io = ImGui::GetIO();
  if (controls_.camera) take_camera(static_cast<std::size_t>(*std::exchange(controls_.camera, std::nullopt)));
  take_mouse();
  if (io.WantTextInput) return;
  for (const Window::Key& key : window_->keys()) {
    const auto asked = call_of(key.code, key.mods, key.repeat);
    if (!asked) continue;
    desk_->begin_gesture();
    call(*asked);
  }
  // Where this character is differs from keyboard to keyboard.
  if (io.InputQueueCharacters.contains('?')) call({UiAction::kPanel, 0});
}

void Preview::escape() {
  if (panels_.is_open(0)) {
    panels_.set_open(0, false, *desk_);
  } else if (!desk_->state().selection.fixtures.empty()) {
    desk_->select(-1, false);
  } else {
    closing_ = true;
  }
}

void Preview::call(const UiCall& call) {
  const auto tell_edit = [&](const char* word, const std::string& edit) {
    tell(edit.empty() ? fmt::format("nothing to {}", word) : fmt::format("{}: {}", word, edit));
  };
  switch (call.action) {
    case UiAction::kUndo: tell_edit("undo", desk_->undo()); break;
    case UiAction::kRedo: tell_edit("redo", desk_->redo()); break;
    case UiAction::kSelectAll: desk_->select_all(); break;
    case UiAction::kHighlight: desk_->set_highlight(!desk_->highlights()); break;
    case UiAction::kReleaseAll: desk_->release_all(); break;
    case UiAction::kFrame:
      if (const auto& which = desk_->state().selection.fixtures; !which.empty()) {
        const StagePick::Box box = pick().bounds_of(which);
        frame_box(box.low_m, box.high_m);
        break;
      }
      [[fallthrough]];
    case UiAction::kFrameRig: {
      const Bounds bounds = bounds_of(rig_);
      frame_box(bounds.low_m, bounds.high_m);
      break;
    }
    case UiAction::kCamera: take_camera(static_cast<std::size_t>(call.argument)); break;
    case UiAction::kWorkLight: controls_.work_light = !controls_.work_light; break;
    case UiAction::kBrighter: expose(-kExposureStepEv); break;  // a lower EV makes a brighter picture
    case UiAction::kDarker: expose(kExposureStepEv); break;
    case UiAction::kPlay: controls_.playing = !controls_.playing; break;
    case UiAction::kSeekBack: seek(-kSeekStepS); break;
    case UiAction::kSeekOn: seek(kSeekStepS); break;
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
    case UiAction::kFullScreen: window_->toggle_full_screen(); break;
    case UiAction::kShot: shot_asked_ = true; break;
    case UiAction::kEscape: escape(); break;
  }
}

void Preview::expose(double steps_ev) {
  if (controls_.auto_exposure) return;
  controls_.exposure_ev = std::clamp(controls_.exposure_ev + static_cast<float>(steps_ev), -20.0f, 30.0f);
}

// Several steps may come in one frame.
void Preview::seek(double by_s) {
  if (timeline_) controls_.seek_s = std::clamp(controls_.seek_s.value_or(facts_.time_s) + by_s, 0.0, facts_.duration_s);
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
  facts_.room_haze_per_m = rig_.haze.scattering_per_m;
  if (const fixtures::MachineAir* air = frame_->machine_air(); air != nullptr) {
    facts_.machines = air->count();
    facts_.machine_haze_per_m = air->haze_per_m();
    facts_.machine_fog_per_m = air->fog_per_m();
  }
  facts_.width = frame_->settings().width;
  facts_.height = frame_->settings().height;
  facts_.gpu_mib = static_cast<double>(frame_->resources().total_bytes) / (1024.0 * 1024.0);
  const DurationNs since_ns = facts_.now_ns - second_ns_;
  if (since_ns >= kNsPerS) {
    facts_.fps = static_cast<double>(second_frames_) * 1e9 / static_cast<double>(since_ns);
    second_ns_ = facts_.now_ns;
    second_frames_ = 0;
    if (live_) {
      facts_.status = live_->status();
      for (std::string& notice : live_->notices()) {
        if (!options_.json) fmt::print(stderr, "footlight: {}\n", notice);
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

// One picture.
Status Preview::turn() {
  window_->poll();
  const TimeNs now_ns = clock_.now_ns();
  const DurationNs dt_ns = now_ns - last_ns_;
  last_ns_ = now_ns;
  if (options_.seconds > 0 && static_cast<double>(now_ns - start_ns_) >= options_.seconds * 1e9) {
    closing_ = true;
    window_->keep_shot();
  }
  draw_ui();
  FL_TRY(window_->wait_gpu());
  if (std::exchange(shot_taken_, false)) write_own_shot();
  FL_TRY(read_figures(dt_ns));

  const PixelRect where = place();
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
  FL_TRY(step_levels(dt_ns));
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

// The window as shown; only the picture if the window system does not allow reading the window.
Status Preview::write_shot() {
  FL_ASSIGN(render::ScreenImage image, window_->read_shot());
  if (image.rgba.empty()) {
    FL_ASSIGN(image, frame_->read_screen());
  }
  return write_png(options_.screenshot, image);
}

// Of key F12: the window as a file of the current folder that did not exist.
void Preview::write_own_shot() {
  const auto write = [&]() -> Result<std::string> {
    FL_ASSIGN(const render::ScreenImage image, window_->read_shot());
    if (image.rgba.empty()) return fail(ErrorCode::kUnsupported, "this window system does not let windows be read");
    for (int number = 1; number <= kShotsMax; ++number) {
      FL_ASSIGN(std::string path, numbered_path("footlight_%04d.png", number));
      std::FILE* file = std::fopen(path.c_str(), "wx");  // fails where the file exists
      if (file == nullptr && errno == EEXIST) continue;
      if (file == nullptr) return fail(ErrorCode::kIo, "{}: {}", path, std::strerror(errno));
      std::fclose(file);
      FL_TRY(write_png(path, image));
      return path;
    }
    return fail(ErrorCode::kIo, "there are {} screenshots in this folder; move some of them", kShotsMax);
  };
  const Result<std::string> path = write();
  tell(path ? fmt::format("saved {}", (std::filesystem::current_path() / *path).string()) : path.error().message);
}

nlohmann::json Preview::figures() const {
  nlohmann::json passes = nlohmann::json::object();
  double gpu_ms = 0;
  for (const auto& pass : facts_.passes) {
    passes[pass.name] = pass.gpu_ms;
    gpu_ms += pass.gpu_ms;
  }
  nlohmann::json line = {{"frames", times_.count()},
                         {"frame_ms_p50", times_.quantile_ms(0.5)},
                         {"frame_ms_p90", times_.quantile_ms(0.9)},
                         {"ui_ms_p50", ui_times_.quantile_ms(0.5)},
                         {"ui_ms_p90", ui_times_.quantile_ms(0.9)},
                         {"gpu_ms", gpu_ms},
                         {"pass_gpu_ms", passes},
                         {"width", frame_->settings().width},
                         {"height", frame_->settings().height},
                         {"nodes", frame_->settings().nodes},
                         {"live", facts_.live_beams},
                         {"dark", facts_.dark_beams},
                         {"shadows", facts_.shadows},
                         {"shadows_lost", facts_.shadows_lost}};
  if (facts_.error.samples > 0) {
    line["error"] = {{"rel_l2", facts_.error.rel_l2},
                     {"low", facts_.error.low},
                     {"high", facts_.error.high},
                     {"samples", facts_.error.samples}};
  }
  if (facts_.chosen) line["knobs"] = render::text_of(facts_.chosen->knobs);
  if (facts_.machines > 0) {
    line["haze_per_m"] = facts_.room_haze_per_m + facts_.machine_haze_per_m + facts_.machine_fog_per_m;
  }
  return line;
}

void Preview::print_second() {
  nlohmann::json line = figures();
  line["event"] = "frames";
  line["fps"] = facts_.fps;
  if (timeline_) line["time_ns"] = timeline_->now_ns();
  fmt::print("{}\n", line.dump());
  std::fflush(stdout);
}

void Preview::print_summary() {
  nlohmann::json line = figures();
  const double elapsed_s = static_cast<double>(clock_.now_ns() - start_ns_) * 1e-9;
  line["event"] = "summary";
  line["device"] = device_->name();
  line["seconds"] = elapsed_s;
  line["first_text_ms"] = static_cast<double>(progress_ns_) * 1e-6;
  line["first_picture_ms"] = static_cast<double>(picture_ns_) * 1e-6;
  line["fps"] = elapsed_s > 0 ? static_cast<double>(times_.count()) / elapsed_s : 0;
  line["validation_messages"] = validation_messages();
  fmt::print("{}\n", line.dump());
}

}  // namespace

Result<int> run_preview(const PreviewOptions& options) { return Preview(options).run(); }

}  // namespace footlight::tools
