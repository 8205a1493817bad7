// The preview up to its first picture.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "fixtures/displays/pixel_slots.h"
#include "fixtures/files/definition_list.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/command.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/preview/display_loss.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/sound/sound_log.h"

namespace footlight::tools {
namespace {

constexpr int kStripWidth = 800;                      // in a window narrower than this the panel begins as a strip
constexpr int kSoftwarePixels = 640 * 360;            // about as many as a software renderer begins with
constexpr std::chrono::milliseconds kQuickRead(200);  // a rig that is read sooner is read before the window opens
constexpr int kStageNice = 5;                         // of the stage's threads, in software: a third of the weight
constexpr double kProgressS = 0.1;                    // from text to text while it loads

// Runs `work` on its own thread.
template <class Work>
std::future<Status> begin(Work work) {
  const NoSignals no_signals;
  return std::async(std::launch::async, std::move(work));
}

// The threads of a software renderer have the niceness of the thread that makes its device. With this one they leave
// the CPU to the window's thread and its renderer whenever these have something to do.
Result<std::unique_ptr<render::vk::Device>> make_nice_device(const render::vk::DeviceOptions& options) {
  const NoSignals no_signals;
  return std::async(std::launch::async,
                    [&]() -> Result<std::unique_ptr<render::vk::Device>> {
                      // Of this thread alone, on Linux. Where it is refused, panels are less smooth.
                      (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kStageNice);
                      return render::vk::Device::create(options);
                    })
      .get();
}

}  // namespace

Status Preview::load_rig(double aspect) {
  FL_ASSIGN(RigFile file, open_file());
  FL_ASSIGN(edited_, EditedScene::make(std::move(file), options_.files, aspect, by_hand()));
  framed_ = edited_->scene();
  FL_ASSIGN(videos_, DisplayVideos::open(framed_->rig, ClipPace::kAhead));
  return {};
}

void Preview::mark_start(const char* ended) {
  start_marks_.emplace_back(ended, static_cast<double>(clock_.now_ns() - begun_ns_) * 1e-6);
}

// That of the window, which shows pictures and draws panels. The GPU is the same as that of the stage.
Status Preview::open_window_device() {
  render::vk::DeviceOptions device;
  device.instance_extensions = window_->instance_extensions();
  device.swapchain = true;
  device.name_contains = options_.device;
  FL_ASSIGN(window_device_, render::vk::Device::create(device));
  return window_->attach(*window_device_);
}

// That of the stage, and what is made from it but for the frame.
Status Preview::open_device() {
  render::vk::DeviceOptions device;
  device.name_contains = options_.device;
  device.cache_folder = cache_folder();
  FL_ASSIGN(device_, window_device_->is_software() ? make_nice_device(device) : render::vk::Device::create(device));
  for (const std::string& note : device_->notes()) fmt::print(stderr, "footlight: {}\n", note);
  FL_ASSIGN(picture_, StagePicture::make(*device_));
  FL_ASSIGN(counts_, render::vk::Buffer::host_visible(*device_, sizeof(render::CountsRow), 0));
  return {};
}

Status Preview::set_controls(const fixtures::Camera& camera) {
  desk_ = std::make_unique<UiDesk>(framed_->rig, framed_->compiled);
  start_edits();
  open_markers();
  desk_->list_definitions_in(fixtures::definition_folders(options_.library, edited_->file().target()));
  desk_->start_view(OrbitCamera(camera), {static_cast<float>(camera.exposure_ev), options_.display.auto_exposure});
  start_views();
  show_exposure();
  FL_TRY(panels_.open_words(options_.panels, *desk_));
  desk_->set_handles(options_.handles);
  desk_->set_locked(options_.locked);
  desk_->set_flashes(options_.flashes);
  note_recent();
  picture_haze_per_m_ = framed_->rig.haze.scattering_per_m;
  haze_is_rig_ = picture_haze_per_m_ == desk_->edited().haze.scattering_per_m;
  if (!options_.select.empty()) {
    desk_->select_named(options_.select);
    if (desk_->state().selection.fixtures.empty()) {
      return fail(ErrorCode::kNotFound, "--select {}: no fixture of this rig has such a name", options_.select);
    }
  }
  if (options_.quality.error > 0) controls_.error_percent = static_cast<float>(100 * options_.quality.error);
  if (options_.quality.ms > 0) controls_.picture_ms = static_cast<float>(options_.quality.ms);
  knobs_.nodes = static_cast<std::uint32_t>(options_.nodes);
  knobs_.tile_error = options_.tile_error;
  knobs_.body_error_px = options_.body_error_px;
  controls_.nodes = options_.nodes;
  controls_.glare_percent = static_cast<float>(100 * options_.display.glare);
  controls_.tone = options_.display.tone;
  controls_.balances_white = options_.display.white_k > 0;
  if (options_.display.white_k > 0) controls_.white_k = static_cast<float>(options_.display.white_k);
  facts_.quality = options_.quality;
  const double usual_lx = work_light_lx(camera.exposure_ev);
  controls_.work_light = options_.work_light_lx.value_or(by_hand() ? usual_lx : 0) > 0;
  const double asked_lx = options_.work_light_lx.value_or(0);
  controls_.work_light_lx = static_cast<float>(asked_lx > 0 ? asked_lx : usual_lx);
  controls_.transport.repeats = options_.files.demo && options_.files.log.empty();
  controls_.panel = window_->width() < kStripWidth ? PanelState::kStrip : PanelState::kFull;
  if (device_->is_software()) {
    // One picture every few seconds is too slow: start with fewer pixels; the user can select all of them.
    const int pixels = place_of(0).width * place_of(0).height;
    while (controls_.divisor < 4 && pixels / (controls_.divisor * controls_.divisor) > kSoftwarePixels) {
      controls_.divisor *= 2;
    }
    // Nor is the automatic exposure to begin from another picture.
    is_rough_ = !facts_.quality.any() && !controls_.auto_exposure;
  }
  facts_.rig = framed_->rig.name;
  facts_.device = device_->name();
  show_cameras();
  for (const auto& fixture : framed_->rig.fixtures) facts_.fixtures.push_back(fixture.name);
  facts_.can_haze = framed_->compiled.needs.haze;
  facts_.can_probes = framed_->compiled.needs.probes && options_.probes && options_.bounce;
  return {};
}

// The window opens first and shows the progress, while another thread reads the rig and then makes the frame. A rig
// that loads quickly is read first, so that its errors are printed before the window opens.
Result<bool> Preview::open(const StopSignal& signal) {
  FL_ASSIGN(const PictureSize size, parse_size(options_.size));
  if (!starts_without_inputs_ && !options_.files.log.empty()) {
    return fail(ErrorCode::kBadInput, "--log and --in: expected one of them");
  }
  FL_TRY(check_panel_words(options_.panels));
  FL_TRY(check_outputs(options_.outputs));
  if (!options_.compare.empty()) FL_TRY(check_level_log(options_.compare));
  begun_ns_ = clock_.now_ns();
  const double aspect = static_cast<double>(size.width) / size.height;
  std::future<Status> reading = begin([this, aspect] { return load_rig(aspect); });
  fixtures::Camera camera;
  const auto take_rig = [&]() -> Status {
    FL_ASSIGN(camera, find_camera(framed_->rig, options_.camera));
    FL_TRY(take_lens(options_.camera_words, camera, lens_));
    FL_TRY(options_.outputs_stay ? keep_outputs(options_.outputs) : open_outputs(options_.outputs));
    FL_TRY(open_hand());
    return open_levels();
  };
  const bool quick = reading.wait_for(kQuickRead) == std::future_status::ready;
  if (quick) {
    FL_TRY(reading.get());
    FL_TRY(take_rig());
  }
  FL_TRY(open_settings());
  FL_ASSIGN(window_, Window::open("Footlight", size.width, size.height));
  mark_start("window");
  show_look();
  FL_TRY(open_window_device());
  mark_start("window_device");
  FL_TRY(show_progress(quick ? tr("Preparing the picture") : tr("Reading the rig")));
  FL_TRY(open_device());
  mark_start("stage_device");
  if (!quick) {
    FL_ASSIGN(const bool goes_on, wait_for(reading, signal, tr("Reading the rig")));
    if (!goes_on) return false;
    FL_TRY(take_rig());
  }
  mark_start("rig");
  title_ = fmt::format("{} - Footlight", framed_->rig.name);
  window_->set_title(title_);
  FL_TRY(show_progress(tr("Preparing the picture")));
  FL_TRY(set_controls(camera));
  const PixelRect where = place_of(0);
  std::future<Status> making = begin([this, where]() -> Status {
    FL_TRY(make_ladder());
    FL_TRY(rebuild(where));
    return player_ ? player_->show(options_.at_ns, driven()) : Status{};
  });
  FL_ASSIGN(const bool goes_on, wait_for(making, signal, tr("Preparing the picture")));
  mark_start("frame");
  return goes_on;
}

// Keeps the window responsive until the work is done. False: it was closed, and the work is done.
Result<bool> Preview::wait_for(std::future<Status>& work, const StopSignal& signal, const char* what) {
  while (work.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    window_->poll(kProgressS);
    if (const Status display = check_display(); !display) {
      closed_ = true;
      (void)work.get();
      return tl::unexpected(display.error());
    }
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
  FL_ASSIGN(const Window::Shown shown, window_->show({}));
  if (shown == Window::Shown::kNew && progress_ns_ < 0) {
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

Status Preview::start_live(std::vector<std::unique_ptr<Source>> sources) {
  FL_ASSIGN(live_, LiveLevels::start(framed_->compiled.universes, std::move(sources), clock_));
  live_timeline_ =
      std::make_unique<Timeline>(live_->changes(), framed_->compiled, vrsl_replay(*framed_), clock_.now_ns());
  live_timeline_->pass_over(fixtures::pixel_universes(framed_->rig, framed_->compiled));
  layer_->join(*live_);
  return {};
}

// again: as of open_input().
Status Preview::open_levels(bool again) {
  if (!ins_.empty()) {
    std::vector<std::unique_ptr<Source>> sources;
    for (const std::string& text : ins_) {
      FL_ASSIGN(std::unique_ptr<Source> source, open_input(text, again));
      sources.push_back(std::move(source));
    }
    return start_live(std::move(sources));
  }
  FL_ASSIGN(log_, open_scene_log(options_.files));
  if (log_) {
    log_watch_.emplace(*log_);
    player_ = make_player(framed_, *log_);
    facts_.has_log = true;
    controls_.transport.duration_ns = player_->duration_ns();
  } else {
    hand_ = std::make_unique<HandLevels>(framed_->rig, framed_->compiled);
  }
  return rest_hand();
}

// The knobs for --error or --ms.
Status Preview::make_ladder() {
  if (!(facts_.quality.error > 0) && !(facts_.quality.ms > 0)) return {};
  FL_ASSIGN(curves_, read_curves());
  take_curves(*curves_);
  return {};
}

}  // namespace footlight::tools
