// footlight render: makes pictures and videos of a rig driven by a log, without a display.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "render/frame.h"
#include "render/quality.h"
#include "tools/footlight/command.h"
#include "tools/footlight/displays/display_videos.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/exr_file.h"
#include "tools/footlight/pictures/flash_watch.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/pictures/log_damage.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/pictures/shown_view.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/pictures/video_file.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/progress.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

struct Options {
  SceneFiles files;
  std::string out;
  std::string size = "1280x720";
  std::string camera;
  std::string device;
  DurationNs at_ns = -1;  // -1: not given
  DurationNs every_ns = -1;
  DurationNs from_ns = 0;
  DurationNs until_ns = -1;
  DurationNs exposure_ns = -1;
  std::optional<double> exposure_ev;  // default: the camera's own
  std::string error;                  // "0.1%"
  std::string ms;                     // refused
  std::optional<int> nodes;
  std::optional<int> gobo_taps;
  int gobo_gates = static_cast<int>(render::FrameSettings{}.gobo_gates);
  std::optional<int> gobo_px;
  std::string gobos;  // "samples", "tables"
  std::optional<double> tile_error;
  std::optional<double> body_error_px;
  std::string edges;
  std::string shadows = "on";
  std::string penumbra = "1";
  ReflectionWords reflections;
  CameraWords camera_words;
  int supersample = 1;
  std::string flashes = "warn";
  std::string show = "picture";
  std::vector<std::string> probes;  // "320,180"
  std::vector<std::string> sets;    // "Prism1=2", "Spot 3:Pan=30"
  bool lit = false;
  std::optional<double> work_light_lx;
  bool json = false;
};

constexpr DurationNs kStillExposureNs = 20 * kNsPerMs;

bool is_video(const std::string& path) { return path.size() > 4 && path.compare(path.size() - 4, 4, ".mp4") == 0; }

Status check_options(const Options& options) {
  if (options.out.empty()) {
    return fail(ErrorCode::kBadInput,
                "no output: expected -o frame.png, -o frame.exr, -o frame_%04d.png or -o show.mp4");
  }
  const bool many = options.every_ns >= 0;
  if (many == (options.at_ns >= 0)) {
    return fail(ErrorCode::kBadInput, "expected --at TIME for one picture, or --every TIME for many");
  }
  if (many && options.every_ns < kNsPerMs) {
    return fail(ErrorCode::kBadInput, "--every {}: expected 1 ms or more", show_duration(options.every_ns));
  }
  if (many && !is_video(options.out) && !is_numbered(options.out)) {
    return fail(ErrorCode::kBadInput,
                "{}: with --every, expected a placeholder for the number, such as frame_%04d.png, or a name that ends "
                "in .mp4",
                options.out);
  }
  if (options.camera_words.auto_exposure && options.exposure_ev) {
    return fail(ErrorCode::kBadInput, "--ev {} and --auto-exposure: each sets the exposure; leave out one of them",
                *options.exposure_ev);
  }
  if (options.flashes != "warn" && options.flashes != "limit" && options.flashes != "ignore") {
    return fail(ErrorCode::kBadInput, "--flashes {}: expected warn, limit or ignore", options.flashes);
  }
  FL_ASSIGN(const ShownView shown, shown_view_of(options.show));
  const bool views = shown != ShownView::kPicture;
  FL_TRY(parse_style(options.camera_words.style, {{"--show", views}, {"--error", !options.error.empty()}}));
  if (views && is_exr(options.out)) {
    return fail(ErrorCode::kBadInput, "--show {}: false colours are no light; expected .png or .mp4 instead of {}",
                options.show, options.out);
  }
  if (views && options.flashes == "limit") {
    return fail(ErrorCode::kBadInput, "--flashes limit: is for pictures; remove it or --show {}", options.show);
  }
  for (const std::string& probe : options.probes) FL_TRY(parse_probe(probe));
  if (!options.probes.empty() && shown != ShownView::kLux) {
    return fail(ErrorCode::kBadInput, "--probe: reads the light on surfaces; expected --show lux as well");
  }
  if (is_exr(options.out)) FL_TRY(check_exr(options.out));
  if (options.flashes == "limit" && is_exr(options.out)) {
    return fail(ErrorCode::kBadInput,
                "--flashes limit: dims what a screen shows, and {} is light before that; expected .png or .mp4",
                options.out);
  }
  if (options.flashes == "limit" && (!many || options.every_ns > kFlashPauseMaxNs)) {
    return fail(ErrorCode::kBadInput,
                "--flashes limit: expected --every {} or less; pictures further apart hide flashes",
                show_duration(kFlashPauseMaxNs));
  }
  if ((options.lit || !options.sets.empty()) && (!options.files.log.empty() || options.files.demo)) {
    return fail(ErrorCode::kBadInput, "--lit and --set are for a rig without a log; remove them or --log");
  }
  if (!many && is_video(options.out)) {
    return fail(ErrorCode::kBadInput, "{}: a video needs --every, as in --every 40ms", options.out);
  }
  return {};
}

// The settings of all pictures, and the error that they were chosen for; 0: none.
struct Chosen {
  render::FrameSettings settings;
  double error = 0;
};

// A picture must not depend on how fast a machine is, so an error has fixed knobs, and a time has none.
Result<Chosen> choose_settings(const Options& options) {
  if (!options.ms.empty()) {
    return fail(ErrorCode::kBadInput,
                "--ms {}: a rendered picture does not depend on time; use --error, as in --error 0.1%, or footlight "
                "preview --ms",
                options.ms);
  }
  FL_ASSIGN(const render::QualityRequest request, render::parse_quality(options.error, ""));
  Chosen chosen;
  chosen.error = request.error;
  render::Knobs knobs = render::knobs_of(chosen.settings);
  if (request.error > 0) {
    const std::pair<const char*, bool> others[] = {
        {"--nodes", options.nodes.has_value()},     {"--tile-error", options.tile_error.has_value()},
        {"--gobos", !options.gobos.empty()},        {"--gobo-taps", options.gobo_taps.has_value()},
        {"--gobo-px", options.gobo_px.has_value()}, {"--body-error", options.body_error_px.has_value()}};
    for (const auto& [name, given] : others) {
      if (given) return fail(ErrorCode::kBadInput, "--error and {}: expected one of them; --error sets it", name);
    }
    FL_ASSIGN(const render::KnobPoint point, render::fixed_knobs(request.error));
    knobs = point.knobs;
  }
  if (options.gobos == "samples" || options.gobos == "tables") {
    knobs.gobo_method = options.gobos == "tables" ? render::GoboMethod::kTables : render::GoboMethod::kTaps;
  } else if (!options.gobos.empty()) {
    return fail(ErrorCode::kBadInput, "--gobos {}: expected samples or tables", options.gobos);
  }
  if (options.gobo_px && !std::has_single_bit(static_cast<unsigned>(*options.gobo_px))) {
    return fail(ErrorCode::kBadInput, "--gobo-px {}: expected a power of two", *options.gobo_px);
  }
  if (options.nodes) knobs.nodes = static_cast<std::uint32_t>(*options.nodes);
  if (options.gobo_taps) knobs.gobo_taps = static_cast<std::uint32_t>(*options.gobo_taps);
  knobs.tile_error = options.tile_error.value_or(knobs.tile_error);
  knobs.body_error_px = options.body_error_px.value_or(knobs.body_error_px);
  chosen.settings = render::with_knobs(chosen.settings, knobs);
  chosen.settings.supersample = options.supersample;
  return chosen;
}

// One render job: steps through the log, takes each picture, and writes it to its file.
class Job {
 public:
  Job(const Options& options, const StopSignal& stop, Timeline* timeline, render::Frame& frame,
      const render::View& view, double exposure_ev, std::string settings, DisplayVideos videos)
      : options_(options),
        stop_(stop),
        timeline_(timeline),
        frame_(frame),
        view_(view),
        exposure_ev_(exposure_ev),
        settings_(std::move(settings)),
        videos_(std::move(videos)),
        shown_(shown_view_of(options.show).value_or(ShownView::kPicture)) {
    const bool watches = shown_ == ShownView::kPicture && options.flashes != "ignore" && options.every_ns > 0 &&
                         options.every_ns <= kFlashPauseMaxNs;
    if (watches) flashes_.emplace(options.flashes == "limit");
  }

  // Takes the picture; none if a stop request arrives before it.
  Status take(DurationNs at_ns, DurationNs exposure_ns) {
    const auto start = std::chrono::steady_clock::now();
    Status flushed;
    const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
      if (stop_.came()) return;
      frame_.step(levels, dt_ns, new_exposure);
      if (frame_.steps_are_due() && flushed) flushed = frame_.run_steps();
    };
    ExrHeader exr{exposure_ev_, at_ns, 0, std::max<DurationNs>(options_.every_ns, 0), settings_};
    if (timeline_ != nullptr) {
      exr.shutter_ns = at_ns - std::clamp(timeline_->now_ns(), at_ns - exposure_ns, at_ns);
      FL_TRY(timeline_->advance(at_ns, exposure_ns, step));
      FL_TRY(flushed);
    }
    if (stop_.came()) return {};
    if (number_ > 0) frame_.adapt_for(at_ns - last_ns_);
    FL_TRY(videos_.show(at_ns, frame_));
    for (const std::string& line : videos_.take_news()) fmt::print(stderr, "footlight: {}\n", printable_utf8(line));
    FL_TRY(frame_.draw(view_, exposure_ev_));
    FL_ASSIGN(exr.exposure_ev, frame_.read_exposure_ev());
    if (shown_ == ShownView::kPicture) {
      FL_ASSIGN(picture_, frame_.read_screen());
    } else {
      FL_TRY(show_view());
    }
    const double wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    watch_flashes(at_ns);
    FL_TRY(store(exr));
    FL_ASSIGN(const auto counts, frame_.read_counts());
    if (counts.shadows_lost > 0 && !lost_shadows_) {
      progress_.clear();
      fmt::print(stderr,
                 "footlight: {} of {} shadows are missing in this picture, since there is no room for them; "
                 "use --shadows maps, or fewer boxes or beams\n",
                 counts.shadows_lost, counts.shadows);
      lost_shadows_ = true;
    }
    if (options_.json) {
      FL_ASSIGN(const auto times, frame_.read_times());
      double gpu_ms = 0;
      std::string passes;
      for (const auto& time : times) {
        gpu_ms += time.gpu_ms;
        passes += fmt::format(R"({}"{}":{:.3f})", passes.empty() ? "" : ",", time.name, time.gpu_ms);
      }
      fmt::print(R"({{"event":"picture","number":{},"time_ns":{},"gpu_ms":{:.3f},"passes_ms":{{{}}},"wall_ms":{:.3f},)"
                 R"("live":{},"dark":{},"shadows":{},"ev":{:.6g},"settings":{}}})"
                 "\n",
                 number_, at_ns, gpu_ms, passes, wall_ms, counts.live_count, counts.dark_count, counts.shadows,
                 exr.exposure_ev, settings_);
      std::fflush(stdout);
    }
    ++number_;
    last_ns_ = at_ns;
    return {};
  }

  // What each colour of the last picture means, for --show; empty for pictures.
  [[nodiscard]] const std::string& legend() const { return legend_; }

  void show_progress(std::size_t all) { progress_.show(static_cast<std::size_t>(number_), all); }

  Status finish() {
    progress_.clear();
    if (video_) FL_TRY(video_->close());
    if (!flashes_) return {};
    for (const FlashStretch& stretch : flashes_->stretches()) say_flashes(stretch);
    if (flashes_->least_gain() < 1) {
      print_event(fmt::format(R"({{"event":"flashes-limited","least_gain":{:.3f}}})", flashes_->least_gain()),
                  fmt::format("flashes were held back, down to {:.0f} % of their light", 100 * flashes_->least_gain()));
    }
    return {};
  }
  [[nodiscard]] int count() const { return number_; }
  void tell_stop() const {
    print_event(fmt::format(R"({{"event":"stopped","pictures":{},"time_ns":{}}})", number_, last_ns_),
                number_ == 0 ? "stopped before the first picture; nothing was written"
                             : fmt::format("stopped after {} picture{}, at {}; they are in {}", number_,
                                           number_ == 1 ? "" : "s", show_duration(last_ns_), options_.out));
  }

 private:
  void print_event(const std::string& json, const std::string& text) const {
    if (options_.json) {
      fmt::print("{}\n", json);
    } else {
      fmt::print(stderr, "footlight: {}\n", text);
    }
  }

  // Reported as soon as it begins, since a video takes long; measured at the end.
  void watch_flashes(DurationNs at_ns) {
    if (!flashes_ || !flashes_->check(at_ns, picture_) || flashes_->stretches().size() > 1) return;
    progress_.clear();
    print_event(
        fmt::format(R"({{"event":"flashes-begin","time_ns":{}}})", at_ns),
        fmt::format("flashes that may harm people with photosensitive epilepsy from {} on{}", show_duration(at_ns),
                    options_.flashes == "limit" ? ", held back" : "; --flashes limit holds them back"));
  }

  void say_flashes(const FlashStretch& stretch) const {
    print_event(
        fmt::format(
            R"({{"event":"flashes","from_ns":{},"until_ns":{},"flashes_a_second":{:.1f},"area":{:.3f},"red":{}}})",
            stretch.from_ns, stretch.until_ns, stretch.flashes, stretch.area, stretch.red),
        fmt::format("{} to {}: up to {:.1f}{} flashes within a second over {:.0f} % of the picture{}",
                    show_duration(stretch.from_ns), show_duration(stretch.until_ns), stretch.flashes,
                    stretch.flashes >= 16 ? " or more" : "", 100 * stretch.area, stretch.red ? ", saturated red" : ""));
  }

  // Replaces the picture by one of how it was computed, or of the light on surfaces.
  Status show_view() {
    FL_ASSIGN(const render::RadianceImage whole, frame_.read_radiance());
    const render::RadianceImage image = render::averaged(whole, options_.supersample);
    switch (shown_) {
      case ShownView::kPicture: break;
      case ShownView::kClasses: {
        picture_ = class_picture(image);
        const ClassShares shares = class_shares(image);
        legend_ = fmt::format(
            "{:.1f} beams a pixel; red: pixel by pixel, {:.1f} % of them; green: smooth, {:.1f} %; blue: rims and "
            "cuts, {:.1f} %",
            shares.hits_per_px, 100 * shares.pixel, 100 * shares.smooth, 100 * shares.record);
        break;
      }
      case ShownView::kSteps: show_heat(lux_of(image), 1, "steps through glass"); break;  // all channels are equal
      case ShownView::kHits: show_heat(hits_of(image), 1, "beams a pixel"); break;
      case ShownView::kLux: {
        const Values lux = lux_of(image);
        for (const std::string& probe : options_.probes) FL_TRY(probe_lux(probe, lux));
        show_heat(lux, 1, "lx");
        break;
      }
      case ShownView::kError: {
        // The same states once more: no step is pending.
        const render::FrameSettings own = frame_.settings();
        render::FrameSettings reference = render::general_settings(own);
        reference.body_error_px = own.body_error_px;  // what a pixel shows is the same
        FL_TRY(frame_.change(reference));
        FL_TRY(frame_.draw(view_, exposure_ev_));
        FL_ASSIGN(const render::RadianceImage exact, frame_.read_radiance());
        FL_TRY(frame_.change(own));
        show_heat(error_of(image, render::averaged(exact, options_.supersample)), 1e-5, "of the light", 1e-1);
        break;
      }
    }
    return {};
  }

  // high: 0 for the largest value.
  void show_heat(const Values& values, double low, const char* unit, double high = 0) {
    double most = 0;
    double sum = 0;
    for (const float v : values.values) {
      most = std::max<double>(most, v);
      sum += v;
    }
    const double top = high > 0 ? high : std::max(most, 10 * low);
    picture_ = heat_picture(values, low, top);
    legend_ = fmt::format(
        "black: below {:.3g} {}; blue to red: {:.3g} to {:.3g}, by the logarithm; mean {:.4g}, largest "
        "{:.4g}",
        low, unit, low, top, sum / static_cast<double>(std::max<std::size_t>(values.values.size(), 1)), most);
  }

  Status probe_lux(const std::string& probe, const Values& lux) {
    FL_ASSIGN(const auto place, parse_probe(probe));
    const auto [x, y] = place;
    if (x >= lux.width || y >= lux.height) {
      return fail(ErrorCode::kBadInput, "--probe {}: expected X,Y in pixels from the top left, up to {},{}", probe,
                  lux.width - 1, lux.height - 1);
    }
    const double value =
        lux.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(lux.width) + static_cast<std::size_t>(x)];
    if (options_.json) {
      fmt::print(R"({{"event":"probe","number":{},"x":{},"y":{},"lx":{:.6g}}})"
                 "\n",
                 number_, x, y, value);
    } else {
      fmt::print("{},{}: {:.4g} lx\n", x, y, value);
    }
    return {};
  }

  Status store_exr(const std::string& path, const ExrHeader& exr) {
    FL_ASSIGN(const render::RadianceImage light, frame_.read_radiance());
    return write_exr(path, render::averaged(light, options_.supersample), exr);
  }

  Status store(const ExrHeader& exr) {
    if (is_video(options_.out)) {
      if (!video_) {
        FL_ASSIGN(video_, VideoFile::create(options_.out, picture_.width, picture_.height, options_.every_ns));
      }
      return video_->add(picture_);
    }
    std::string path = options_.out;
    if (options_.every_ns >= 0) {
      FL_ASSIGN(path, numbered_path(options_.out, number_));
    }
    return is_exr(path) ? store_exr(path, exr) : write_png(path, picture_, settings_);
  }

  const Options& options_;
  bool lost_shadows_ = false;  // this was reported
  const StopSignal& stop_;
  Timeline* timeline_;
  render::Frame& frame_;
  const render::View& view_;
  double exposure_ev_;
  std::string settings_;  // JSON, for the files
  DisplayVideos videos_;
  ShownView shown_;
  std::string legend_;
  render::ScreenImage picture_;
  std::unique_ptr<VideoFile> video_;
  std::optional<FlashWatch> flashes_;
  Progress progress_{"pictures"};
  int number_ = 0;
  DurationNs last_ns_ = 0;  // time of the last picture
};

Result<int> render_pictures(const Options& options) {
  FL_TRY(check_options(options));
  FL_ASSIGN(const Chosen chosen, choose_settings(options));
  const StopSignal stop;
  FL_ASSIGN(const PictureSize size, parse_size(options.size));
  FL_ASSIGN(fixtures::Rig rig, load_scene_rig(options.files));
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options.files));
  const DamageWarning warning(log);
  FL_ASSIGN(DisplayVideos videos, DisplayVideos::open(rig, ClipPace::kExact));
  const bool by_hand = options.lit || !options.sets.empty();
  add_start_view(rig, static_cast<double>(size.width) / size.height, log || by_hand);
  FL_ASSIGN(const fixtures::Camera camera, find_camera(rig, options.camera));
  render::FrameSettings settings = chosen.settings;
  FL_TRY(take_lens(options.camera_words, camera, settings));
  if (by_hand) give_hand_addresses(rig);
  const double exposure_ev = options.exposure_ev.value_or(camera.exposure_ev);
  const double usual_lx = by_hand ? faint_light_lx(exposure_ev) : log ? 0 : work_light_lx(exposure_ev);
  FL_ASSIGN(DrivenRig driven, compile_driven(rig, std::move(log)));
  const fixtures::CompiledRig& compiled = driven.compiled;
  std::optional<Timeline>& timeline = driven.timeline;

  FL_ASSIGN(const auto device,
            render::vk::Device::create({.name_contains = options.device, .cache_folder = cache_folder()}));
  for (const std::string& note : device->notes()) fmt::print(stderr, "footlight: {}\n", note);
  settings.width = size.width * options.supersample;
  settings.height = size.height * options.supersample;
  settings.edge_samples = render::suited_edge_samples(*device);
  if (!options.edges.empty()) {
    FL_ASSIGN(settings.edge_samples, parse_edges(options.edges));
  }
  FL_TRY(take_shadows(options.shadows, settings));
  FL_TRY(take_penumbra(options.penumbra, settings));
  FL_TRY(take_reflections(options.reflections, settings.bounce, settings.probes));
  FL_TRY(take_camera_words(options.camera_words, settings));
  settings.gobo_gates = static_cast<std::uint32_t>(options.gobo_gates);
  settings.gate_builds = FL_GATES_MAX;  // a picture may wait for all of them
  // Samples need no images of gates.
  if (settings.gobo_method == render::GoboMethod::kTaps ||
      (settings.gobo_method == render::GoboMethod::kSuited && device->is_software())) {
    settings.gobo_gates = 0;
  }
  if (chosen.error > 0) settings.gobo_px = render::kGoboSizePx;  // the same on every device
  settings.gobo_px = options.gobo_px.value_or(settings.gobo_px);
  FL_ASSIGN(const ShownView shown, shown_view_of(options.show));
  FL_ASSIGN(settings.view, frame_view_of(shown, compiled.needs.panes));
  FL_ASSIGN(const auto style, parse_style(options.camera_words.style));
  settings = render::settings_of(style, settings);
  FL_ASSIGN(const auto frame, render::Frame::create(*device, rig, compiled, settings, render::passes_of(style)));
  warn_of_hard_edges(frame->settings());
  frame->set_work_light_lx(options.work_light_lx.value_or(usual_lx));
  print_warnings(frame->resources().rig.diagnostics);
  if (by_hand) {
    HandLevels hand(rig, compiled);
    // Machines in --set start with clear air.
    const bool sets_air = std::any_of(options.sets.begin(), options.sets.end(), [](const std::string& text) {
      return text.find("Haze") != std::string::npos || text.find("Fog") != std::string::npos;
    });
    if (!sets_air) frame->settle_machine_air(hand.levels());
    for (const std::string& text : options.sets) FL_TRY(set_by_hand(text, rig, hand));
    timeline.emplace(hand.levels(), compiled);
  } else if (!timeline && frame->resources().rig.levels_bytes > 0) {
    // No log: every level is 0.
    frame->step(std::vector<std::uint8_t>(frame->resources().rig.levels_bytes), 0);
  }
  const render::View view = render::view_of(camera);
  device->lose_from_environment();
  Job job(options, stop, timeline ? &*timeline : nullptr, *frame, view, exposure_ev,
          with_style(render::json_of(frame->settings(), FOOTLIGHT_VERSION, chosen.error), style), std::move(videos));

  if (options.at_ns >= 0) {
    FL_TRY(job.take(options.at_ns, options.exposure_ns >= 0 ? options.exposure_ns : kStillExposureNs));
  } else {
    const DurationNs end_ns = options.until_ns >= 0 ? options.until_ns : timeline ? timeline->duration_ns() : 0;
    const DurationNs exposure_ns = options.exposure_ns >= 0 ? options.exposure_ns : options.every_ns;
    FL_TRY(check_span(options.from_ns, end_ns));
    // A picture of a video lasts until the next one, so none begins at the end; but there is at least one.
    const DurationNs last_ns = is_video(options.out) ? std::max(end_ns - 1, options.from_ns) : end_ns;
    const DurationNs span_ns = std::max<DurationNs>(last_ns - options.from_ns, 0);
    const auto all = static_cast<std::size_t>(span_ns / options.every_ns) + 1;
    for (DurationNs at_ns = options.from_ns; at_ns <= last_ns && !stop.came(); at_ns += options.every_ns) {
      FL_TRY(job.take(at_ns, exposure_ns));
      if (!options.json) job.show_progress(all);
    }
  }
  FL_TRY(job.finish());
  if (stop.came() && (options.every_ns >= 0 || job.count() == 0)) {
    job.tell_stop();
    if (job.count() == 0) return kExitFailed;
  }
  if (!options.json) {
    fmt::print("{}: {} picture{} of {}x{} on {}\n", options.out, job.count(), job.count() == 1 ? "" : "s", size.width,
               size.height, device->name());
    if (!job.legend().empty()) fmt::print("{}\n", job.legend());
  }
  return device->validation_messages().empty() ? kExitOk : kExitFailed;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  add_scene_arguments(arguments, options->files);
  arguments.option("--out,-o", options->out, "FILE",
                   "frame.png, frame.exr, frame_%04d.png, frame_%04d.exr or show.mp4");
  arguments.duration("--at", options->at_ns, "one picture, at this time of the log");
  arguments.duration("--every", options->every_ns, "many pictures, at this interval");
  arguments.duration("--from", options->from_ns, "with --every: time of the first picture [0]");
  arguments.duration("--until", options->until_ns,
                     "with --every: no picture after this time, and end of the video; default: the end of the log");
  arguments.option("--size", options->size, "WxH", "size of the picture in pixels");
  arguments.option("--camera", options->camera, "NAME", "a camera of the rig; default: its first one");
  arguments.flag("--lit", options->lit,
                 "without a log: every fixture at full, open and at its own white, axes in the middle, hazers on");
  arguments.list("--set", options->sets, "WORDS",
                 "as --lit, with ATTRIBUTE=VALUE of all fixtures or FIXTURE:ATTRIBUTE=VALUE of one; several times");
  arguments.option(
      "--work-light", options->work_light_lx, 0, 1e6,
      "lx on every surface in addition to the rig's; default: 150 or more without input, little with --lit");
  arguments.option("--flashes", options->flashes, "WORD",
                   "harmful flashes (more than three a second): warn, limit or ignore [warn]");
  arguments.option(
      "--show", options->show, "WORD",
      "instead of the picture: classes, hits (beams a pixel), steps (through the glass of panes), lux (on surfaces) or "
      "error, in false colours");
  arguments.list("--probe", options->probes, "X,Y", "with --show lux: print the lx at a pixel; several times");
  arguments.duration("--exposure", options->exposure_ns,
                     "time that the shutter is open before the picture's time; default: 20ms, or all of --every");
  arguments.option("--ev", options->exposure_ev, -20, 30, "exposure value at ISO 100; default: the camera's own");
  arguments.option("--error", options->error, "SHARE",
                   "relative L2 error of the light, as in 0.1%: chooses the six options that follow, by a fixed table");
  arguments.option("--nodes", options->nodes, 1, 8,
                   "Gauss nodes per beam and pixel [3]; error and time: footlight report");
  arguments.option("--tile-error", options->tile_error, 0, 1,
                   "error that taking beams together for tiles may add, as a share of the light; 0: pixel by pixel "
                   "[0.004]");
  arguments.option("--body-error", options->body_error_px, 0, 1000,
                   "error of fixture bodies in pixels, for fewer triangles; 0: whole models [0.5]");
  arguments.option("--gobos", options->gobos, "WORD", "in the air: samples or tables; default: tables on a GPU");
  arguments.option("--gobo-taps", options->gobo_taps, 1, 1024,
                   "samples per beam and pixel without tables of gobos: wide blurs, several images out of focus [128]");
  arguments.option("--gobo-px", options->gobo_px, 64, 2048,
                   "texels a side of gobo images, a power of two; default: 1024 on a GPU where they fit, else 512");
  arguments.option("--edges", options->edges, "WORD",
                   "samples of each pixel that shows the edge of something solid: 4, 8 or 16; off: jagged edges; "
                   "default: 16 on a GPU, 4 on a CPU");
  arguments.option("--shadows", options->shadows, "WORD", kShadowsHelp);
  arguments.option("--penumbra", options->penumbra, "POINTS", kPenumbraHelp);
  add_reflection_arguments(arguments, options->reflections);
  add_camera_arguments(arguments, options->camera_words);
  arguments.option("--ms", options->ms, "MS", "refused: a rendered picture does not depend on time; use --error");
  arguments.option(
      "--supersample", options->supersample, 1, 4,
      "pixels per side for each pixel, averaged before the tone map: smooth edges at N x N times the work");
  arguments.option("--gobo-gates", options->gobo_gates, 0, FL_GATES_MAX,
                   "states of gates with several images, or a wheel between slots, that may have tables, at most 21 of "
                   "13 MB each, fewer with colours [16]; without tables none");
  arguments.option("--device", options->device, "TEXT", "the Vulkan device whose name contains this text");
  arguments.flag("--json", options->json, "one JSON object a line for each picture");
  arguments.job([options]() -> Result<int> { return render_pictures(*options); });
}

}  // namespace

extern const CommandInfo render_command{
    .name = "render",
    .help = "Make pictures or a video of a rig, without a display",
    .examples =
        "  footlight render --demo --at 12.5s -o frame.png\n"
        "  footlight render rig.toml --log show.dmxlog --at 12.5s --size 1920x1080 -o frame.png\n"
        "  footlight render rig.toml --log show.dmxlog --every 40ms -o frame_%04d.png\n"
        "  footlight render rig.toml --log show.dmxlog --at 12.5s -o frame.exr         linear light in cd/m2, OpenEXR\n"
        "  footlight render hall.mvr --at 0s -o hall.png              in work light\n"
        "  footlight render hall.mvr --lit --set Tilt=30 --set Iris=0.4 --at 0s -o tilted.png\n"
        "  footlight render hall.mvr --lit --at 0s --show lux --probe 640,500 -o lux.png\n"
        "  footlight render hall.mvr --lit --at 0s --error 0.1% -o fine.png        the same knobs on every machine\n"
        "  footlight render --demo --every 40ms --from 10s --until 20s --camera side -o side.mp4\n"
        "The same rig, log and time give the same picture, bit for bit on one device. PNG and OpenEXR files\n"
        "state their settings as footlight/settings. Ctrl-C stops after the current picture; the video or the\n"
        "pictures so far are complete.",
    .add = add,
};

}  // namespace footlight::tools
