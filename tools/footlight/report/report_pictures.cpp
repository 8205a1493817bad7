// footlight report --pictures: error against run time of the picture methods, and the features that the rig leaves out.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fixtures/displays/pixel_slots.h"
#include "fixtures/projectors/projector.h"
#include "fixtures/simulate/machines.h"
#include "render/frame.h"
#include "render/reference/report.h"
#include "render/reference/time_judges.h"
#include "tools/footlight/displays/display_videos.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/pictures/knob_curves.h"
#include "tools/footlight/pictures/log_damage.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/report/chosen_knobs.h"
#include "tools/footlight/report/left_out.h"
#include "tools/footlight/report/other_light.h"
#include "tools/footlight/report/picture_report.h"
#include "tools/footlight/report/report_fleet.h"
#include "tools/footlight/report/report_parts.h"
#include "tools/footlight/report/report_sweep.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

struct PictureArguments {
  SceneFiles files;
  DurationNs at_ns = 30 * kNsPerS;
  int beams = 0;
  std::string photometry;
  bool gobos = false;
  bool gates = false;
  int clutter = 0;
  std::string sweep;
  int fleet = 0;
  std::string size = "640x360";
  int judge_pixels = kJudgePixels;
  std::string camera;
  std::string device;
  int runs = 11;
  double body_error_px = render::FrameSettings{}.body_error_px;
  std::string shadow_words = "on";
  std::string penumbra = "1";
  std::string reflections;  // on, off; empty: where the rig has something that mirrors
  render::FrameSettings shadows;  // of which the shadows of the whole frame
  std::string error;  // "0.1%"
  std::string ms;
  bool no_judge = false;
  bool rivals = false;
  std::string methods;
  double row_seconds = PictureReportOptions{}.row_seconds;
  bool lit = false;
  std::vector<std::string> sets;
};

// Haze and fog that machines have added to the air until `--at`. Rigs without machines have no report.
struct AirReport {
  double haze_per_m = 0;
  double fog_per_m = 0;
  double error_per_m = 0;  // of the sum of both, against the judge
  double plumes_m2 = 0;    // that has not mixed yet, and is seen
  int steps = 0;
  double ns_per_step = 0;  // wall clock time, including the decoding of levels
};

// Steps the machines as a replay does, in steps of at most 40 ms.
class AirWatch {
 public:
  explicit AirWatch(std::unique_ptr<fixtures::MachineAir> air) : air_(std::move(air)) {}

  void step(std::span<const std::uint8_t> levels, std::int64_t dt_ns) {
    for (std::int64_t left = dt_ns; left > 0; left -= kAirStepNs) {
      const auto start = std::chrono::steady_clock::now();
      air_->step(levels, std::min(left, kAirStepNs));
      ns_ += std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
      ++steps_;
    }
    const fixtures::MachineInflow now = air_->inflow(levels);
    add(haze_, now.haze_per_m_s, now.mixing_hz, dt_ns);
    add(fog_, now.fog_per_m_s, now.mixing_hz, dt_ns);
  }

  [[nodiscard]] AirReport report(const fixtures::Room& room) const {
    const render::Wide judged =
        render::air_judged(haze_, room.haze_s).scattering_per_m + render::air_judged(fog_, room.fog_s).scattering_per_m;
    return {air_->haze_per_m(), air_->fog_per_m(), std::abs(air_->scattering_per_m() - static_cast<double>(judged)),
            0, steps_, steps_ > 0 ? ns_ / steps_ : 0};
  }
  [[nodiscard]] std::vector<fixtures::PlumePuff> puffs() const { return air_->puffs(); }

 private:
  static constexpr std::int64_t kAirStepNs = 40 * kNsPerMs;

  static void add(std::vector<render::AirStretch>& list, double inflow, double mixing_hz, std::int64_t dt_ns) {
    if (list.empty() || list.back().inflow_per_m_s != inflow || list.back().mixing_hz != mixing_hz) {
      list.push_back({inflow, mixing_hz, 0});
    }
    list.back().dt_ns += static_cast<std::uint64_t>(dt_ns);
  }

  std::unique_ptr<fixtures::MachineAir> air_;
  std::vector<render::AirStretch> haze_, fog_;
  int steps_ = 0;
  double ns_ = 0;
};

// Of a rig that nothing drives: passes if anything shines all the same, and says what.
Status expect_other_light(const Scene& scene, const std::string& name) {
  const OtherLight light = other_light(scene);
  const std::string lights = lights_of(scene.rig);
  if (!light.any()) {
    return fail(ErrorCode::kBadInput,
                "{}: nothing drives the rig, and nothing in it shines by itself ({}); use --log, --lit or --set", name,
                lights.empty() ? "it has no fixture and no display" : lights);
  }
  fmt::print(stderr,
             "footlight: {}: nothing drives the rig, so no lamp is lit: the report is of {} alone; --log, --lit or "
             "--set light lamps\n",
             name, !light.displays ? "sunlight" : light.sun ? "displays and sunlight" : "displays");
  return {};
}

// The scene at a time of the log. Motors start at their targets, so that GPU and judge start from the same state
// without a history. Haze and fog that machines have added by then count as haze of the room.
Result<Scene> scene_of_files(const SceneFiles& files, const PictureArguments& arguments, double aspect,
                             std::optional<AirReport>& air) {
  const DurationNs at_ns = arguments.at_ns;
  const bool by_hand = arguments.lit || !arguments.sets.empty();
  if (by_hand && (!files.log.empty() || arguments.files.demo)) {
    return fail(ErrorCode::kBadInput, "--lit and --set cannot be used with a log or --demo; leave out one of them");
  }
  Scene scene;
  FL_ASSIGN(scene.rig, load_scene_rig(files));
  FL_TRY(hold_videos(scene.rig, at_ns));
  add_start_view(scene.rig, aspect, true);
  if (by_hand) give_hand_addresses(scene.rig);
  FL_ASSIGN(scene.compiled, fixtures::compile(scene.rig));
  FL_ASSIGN(scene.camera, find_camera(scene.rig, arguments.camera));
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(files));
  const DamageWarning warning(log);
  std::optional<AirWatch> watch;
  if (auto machines = fixtures::MachineAir::make(scene.rig, scene.compiled)) watch.emplace(std::move(machines));
  const auto media = fixtures::MediaPlayer::make(scene.rig, scene.compiled);
  if (log) {
    Timeline timeline(std::move(*log), scene.compiled);
    timeline.pass_over(fixtures::pixel_universes(scene.rig, scene.compiled));
    FL_TRY(timeline.advance(at_ns, 0, [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool) {
      scene.levels.assign(levels.begin(), levels.end());
      if (watch) watch->step(levels, dt_ns);
      if (media) media->step(levels, dt_ns);
    }));
  }
  if (by_hand) {
    HandLevels hand(scene.rig, scene.compiled);
    for (const std::string& text : arguments.sets) FL_TRY(set_by_hand(text, scene.rig, hand));
    scene.levels.assign(hand.levels().begin(), hand.levels().end());
    if (watch) watch->step(scene.levels, at_ns);
    if (media) media->step(scene.levels, at_ns);
  }
  const bool driven = by_hand || log || files.demo;
  if (!driven && media) media->step(scene.levels, at_ns);
  if (media) FL_TRY(hold_media(scene.rig, *media));
  fixtures::hold_projections(scene.rig, scene.compiled, scene.levels);
  if (!driven) FL_TRY(expect_other_light(scene, printable_utf8(files.rig)));
  if (watch) {
    air = watch->report(scene.rig.room);
    scene.rig.haze.scattering_per_m += air->haze_per_m + air->fog_per_m;
    scene.puffs = watch->puffs();
    for (const fixtures::PlumePuff& puff : scene.puffs) air->plumes_m2 += puff.area_m2;
  }
  scene.name = by_hand ? fmt::format("{}, lit by hand", files.demo ? "demo" : files.rig)
                       : fmt::format("{}@{}", files.demo ? "demo" : files.rig, show_duration(at_ns));
  return scene;
}

// Prints what the rig leaves out, and the cost of each feature. has_sheen: with the files of meshes.
Status report_left_out(render::vk::Device& device, const Scene& of_rig, bool has_sheen,
                       const PictureReportOptions& pictures, const ReportOptions& options) {
  Scene scene = of_rig;
  scene.compiled.needs.sheen = scene.compiled.needs.sheen || has_sheen;
  LeftOutOptions left_out{
      .settings = {.width = pictures.width, .height = pictures.height}, .runs = pictures.runs, .go_on = {}};
  left_out.settings.bounce = left_out.settings.probes = true;  // else they are left out whatever the rig needs
  if (options.quick) left_out.runs = 0;  // each timed row compiles shaders
  if (options.go_on) {
    left_out.go_on = [&](double done, double all) { return options.go_on("features that are left out", done, all); };
  }
  FL_ASSIGN(const std::vector<LeftOutRow> rows, measure_left_out(device, scene, left_out));
  options.print(options.json ? json_of(rows) : text_of(rows, scene.name) + "\n");
  return {};
}

Status report_fleet(const PictureArguments& arguments, const ReportOptions& options) {
  FL_ASSIGN(const auto device, render::vk::Device::create({.name_contains = arguments.device}));
  const FleetOptions fleet{.fixtures = arguments.fleet, .runs = options.quick ? 5 : 21};
  FL_ASSIGN(const FleetReport report, make_fleet_report(*device, fleet));
  fmt::print("{}", options.json ? json_of(report, fleet) : text_of(report, fleet));
  return {};
}

std::string intro_of(const Scene& scene, const PictureArguments& arguments, const PictureReportOptions& options,
                     const PictureReport& report) {
  std::string text = fmt::format(
      "Pictures of {}: beams in haze and on surfaces, on {}.\nTimes: GPU, {}x{}, {} runs after 3 warm-up runs. ",
      scene.name, report.device, options.width, options.height, arguments.runs);
  if (report.only_lasers) text += "No beam is lit but those of lasers. ";
  if (arguments.no_judge) return text + "Errors are not measured.\n\n";
  if (report.only_lasers) return text + "\n\n";
  const std::int64_t all = std::int64_t{options.width} * options.height;
  const bool sampled = report.judged_pixels < all;
  return text + fmt::format(
                    "Errors: at {} of the {} pixels of these frames{}, against adaptive quadrature in double, whose "
                    "own error is {:.1e} ({:.1f} s).\n"
                    "{}"
                    "The rows leave out the bodies and lenses of fixtures, and the widening of thin beams{}.\n\n",
                    report.judged_pixels, all, sampled ? ", a stratified random sample" : "", report.judge_own_rel_l2,
                    report.judge_seconds,
                    sampled ? "rel_l2 is an estimate for the whole picture, with rel_l2_low to rel_l2_high as its 95 % "
                              "confidence interval.\n"
                            : "",
                    report.lasers.lit > 0 ? "; that of lasers has these alone" : "");
}

// How the beams of the whole frame are computed.
std::string classes_text(const ClassShares& classes) {
  if (!(classes.hits_per_px > 0)) return "No beam but those of lasers is in the picture.";
  return fmt::format(
      "Its beams, {:.1f} a pixel: {:.1f} % computed pixel by pixel, {:.1f} % together as smooth, {:.1f} % together but "
      "for "
      "rims and cuts.",
      classes.hits_per_px, 100 * classes.pixel, 100 * classes.smooth, 100 * classes.record);
}
std::string classes_json(const ClassShares& classes) {
  return fmt::format(R"({{"event":"classes","hits_per_px":{:.4g},"pixel":{:.4f},"smooth":{:.4f},"record":{:.4f}}})"
                     "\n",
                     classes.hits_per_px, classes.pixel, classes.smooth, classes.record);
}

// What the whole frame draws of bodies, and what it leaves out.
std::string bodies_text(const PictureReport& report, double body_error_px) {
  const render::BodyCounts& bodies = report.bodies;
  if (bodies.bodies + bodies.object_triangles == 0) return "";
  const auto pass = std::find_if(report.whole_passes.begin(), report.whole_passes.end(),
                                 [](const render::PassTime& one) { return one.name == "bodies"; });
  return fmt::format(
      "Bodies, {:.3f} ms, {:.1f} MB: {} of {} are drawn, with {} of {} triangles; "
      "{} are left out. Their models are off by at most {:g} pixels. Objects of the scene: {} "
      "triangles.\n\n",
      pass != report.whole_passes.end() ? pass->gpu_ms : 0.0, static_cast<double>(report.body_bytes) * 1e-6,
      bodies.drawn, bodies.bodies, bodies.drawn_triangles, bodies.triangles, bodies.bodies - bodies.drawn,
      body_error_px, bodies.object_triangles);
}

// What hides light in the whole frame.
std::string shadows_text(const PictureReport& report) {
  if (report.shadows == 0) return "";
  return fmt::format(
      "Shadows: {} pairs of a beam and what stands in it, {:.1f} a lit beam; {} are missing for want of "
      "room.\n\n",
      report.shadows, static_cast<double>(report.shadows) / report.live_beams, report.shadows_lost);
}
std::string shadows_json(const PictureReport& report) {
  return fmt::format(R"({{"event":"shadows","pairs":{},"beams":{},"missing":{}}})"
                     "\n",
                     report.shadows, report.live_beams, report.shadows_lost);
}

// The judge of lasers.
std::string lasers_text(const PictureReport& report) {
  const LaserError& lasers = report.lasers;
  if (lasers.width == 0) return "";
  return fmt::format(
      "Lasers: {} lit. The errors of their row are those of their light in a picture of {} x {} pixels, against brute "
      "force in double over the path of the scanner, whose own error is {:.1e}.\n\n",
      lasers.lit, lasers.width, lasers.height, lasers.own_rel_l2);
}
std::string lasers_json(const PictureReport& report) {
  const LaserError& lasers = report.lasers;
  return fmt::format(R"({{"event":"lasers","lit":{},"judged_width":{},"judged_height":{},"own_rel_l2":{:.4g}}})"
                     "\n",
                     lasers.lit, lasers.width, lasers.height, lasers.own_rel_l2);
}

// Where the light of displays is computed in the whole frame.
std::string displays_text(const PictureReport& report) {
  const render::DisplayWork& work = report.displays;
  if (work.records[0] + work.pixels + work.surface_pixels == 0) return "";
  return fmt::format(
      "Light of displays: 21 places in each of {} parts of squares of 64 pixels a side, {} of 32, {} of 16 and {} of "
      "8; {} pixels one by one, {} more on surfaces only.\n\n",
      work.records[0], work.records[1], work.records[2], work.records[3], work.pixels, work.surface_pixels);
}
std::string displays_json(const PictureReport& report) {
  const render::DisplayWork& work = report.displays;
  return fmt::format(R"({{"event":"displays","parts":[{}],"pixels":{},"surface_pixels":{}}})"
                     "\n",
                     fmt::join(work.records, ","), work.pixels, work.surface_pixels);
}

// Tables of gobos, and how many beams have several images in them but no table.
std::string gates_text(const PictureReport& report) {
  return fmt::format(
      "Gobos: the first frame took {:.3f} ms for their tables. Gates with several images: {} different ones, {} drawn "
      "in the last frame; {} beams are sampled for want of a gate.\n\n",
      report.gobo_build_ms, report.gates.states, report.gates.builds, report.gates.sampled_beams);
}
std::string gates_json(const PictureReport& report) {
  return fmt::format(R"({{"event":"gates","build_ms":{:.4f},"states":{},"builds":{},"sampled_beams":{}}})"
                     "\n",
                     report.gobo_build_ms, report.gates.states, report.gates.builds, report.gates.sampled_beams);
}

// How jagged the edges of solid things in the whole frame are, and what smoothing them costs.
std::string edges_text(const PictureReport& report, std::int64_t pixels) {
  if (report.edges.empty()) return "";
  std::string text = fmt::format(
      "Edges of solid things, {:.1f} % of the pixels, against the same frame with 4 x 4 pixels for one:\n"
      "  samples        ms  steps of 255   FLIP\n",
      100.0 * static_cast<double>(report.edge_pixels) / static_cast<double>(pixels));
  for (const EdgeRow& row : report.edges) {
    text += fmt::format("  {:>7} {:9.3f} {:13.2f} {:8.5f}\n", row.samples == 0 ? "off" : fmt::to_string(row.samples),
                        row.ms, row.steps, row.flip);
  }
  return text + "\n";
}
std::string edges_json(const PictureReport& report) {
  std::string text;
  for (const EdgeRow& row : report.edges) {
    text += fmt::format(R"({{"event":"edges","samples":{},"pixels":{},"ms_p50":{:.4f},"steps":{:.4f},"flip":{:.6f}}})"
                        "\n",
                        row.samples, report.edge_pixels, row.ms, row.steps, row.flip);
  }
  return text;
}

PictureReportOptions options_of(const PictureArguments& arguments, const PictureSize& size,
                                const ReportOptions& options) {
  PictureReportOptions pictures;
  pictures.width = size.width;
  pictures.height = size.height;
  pictures.judge_pixels = arguments.judge_pixels;
  pictures.runs = arguments.runs;
  pictures.body_error_px = arguments.body_error_px;
  pictures.shadows = arguments.shadows.shadows;
  pictures.shadow_map_px = arguments.shadows.shadow_map_px;
  pictures.penumbra = arguments.shadows.penumbra;
  pictures.judge = !arguments.no_judge;
  pictures.rivals = arguments.rivals;
  pictures.methods = arguments.methods;
  pictures.quick = options.quick;
  pictures.row_seconds = arguments.row_seconds;
  if (options.quick) {
    pictures.tile_errors = {1e-3, 4e-3};
    pictures.gauss_nodes = {2, 3, 4};
    pictures.march_steps = {16, 64};
    pictures.gobo_taps = {16, 64};
  }
  pictures.go_on = options.go_on;
  return pictures;
}

Status report_swept(const PictureArguments& arguments, const ReportOptions& options) {
  FL_ASSIGN(const Sweep sweep, parse_sweep(arguments.sweep));
  FL_ASSIGN(const PictureSize size, parse_size(arguments.size));
  FL_ASSIGN(const auto device, render::vk::Device::create({.name_contains = arguments.device}));
  SweepScene scene;
  if (arguments.beams > 0) scene.beams = arguments.beams;
  scene.gobo_share = arguments.gobos || arguments.gates ? 1 : 0;
  scene.wheels = arguments.gates ? 2 : 1;
  scene.clutter = arguments.clutter;
  return report_sweep(*device, sweep, scene, options_of(arguments, size, options), options);
}

// For --error or --ms: what this machine's curves choose, and the ladder that it comes from.
Result<ChosenKnobs> choose_knobs(render::vk::Device& device, const Scene& scene, const PictureReportOptions& pictures,
                                 const render::QualityRequest& request, const ReportOptions& options) {
  KnobCurveOptions curve_options = suited_curve_options(device);
  if (options.go_on) {
    curve_options.go_on = [&](double done, double all) { return options.go_on("knobs of this machine", done, all); };
  }
  FL_ASSIGN(const render::KnobCurves curves, machine_knob_curves(device, cache_folder(), curve_options, {}));
  FL_ASSIGN(const ChosenKnobs chosen,
            choose_for(device, scene, curves, request, pictures.width, pictures.height, pictures.runs));
  if (options.json) return chosen;
  std::string text = "Knobs of this machine that are worth their time, on generated scenes:\n";
  for (const render::KnobPoint& point : render::ladder_of(curves, scene.compiled.needs, request)) {
    text += fmt::format("{:>10.1e}{:>10.3f} ms  {}\n", point.error, point.ms, render::text_of(point.knobs));
  }
  options.print(text + "\n");
  return chosen;
}

// The figures behind the rows, as text.
void print_figures(const PictureArguments& arguments, const ReportOptions& options, const PictureReport& report,
                   std::int64_t pixels, const std::optional<AirReport>& air) {
  options.print("\n");
  for (const auto& row : report.rows) {
    if (row.ms_p10 > 0 && row.ms_p90 / row.ms_p10 > 1.15) {
      fmt::print("unstable: {} {}: p90 is {:.2f} times p10\n", row.method, row.knob, row.ms_p90 / row.ms_p10);
    }
  }
  if (!arguments.no_judge) {
    const double costs[] = {1, 4, 16};
    fmt::print("{}\n", render::summary_of(render::curves_of(report.rows), "ms", costs));
  }
  if (!report.only_lasers) {
    fmt::print("GPU time per pass, tiles with error {:g}:", render::FrameSettings{}.tile_error);
    for (const auto& pass : report.passes) fmt::print("  {} {:.3f} ms", pass.name, pass.gpu_ms);
    fmt::print("\n");
  }
  fmt::print("The whole frame as 'footlight render' draws it, bodies and lenses included{}: {:.3f} ms:",
             report.reflections ? "" : ", without light that surfaces reflect (--reflections on has it)",
             report.whole_ms);
  for (const auto& pass : report.whole_passes) fmt::print("  {} {:.3f} ms", pass.name, pass.gpu_ms);
  fmt::print("\n{}\n\n{}{}{}{}{}", classes_text(report.classes), lasers_text(report), shadows_text(report),
             displays_text(report), bodies_text(report, arguments.body_error_px), edges_text(report, pixels));
  if (report.mirrored) options.print(text_of(*report.mirrored, pixels));
  if (air) {
    fmt::print(
        "Air: machines have added {:.4g} /m of haze and {:.4g} /m of fog. Error against integrals over droplets in "
        "long double: {:.1e} /m after {} steps of at most 40 ms, {:.0f} ns each. In plumes in front of machines are "
        "{:.4g} m^2; the errors above include theirs.\n\n",
        air->haze_per_m, air->fog_per_m, air->error_per_m, air->steps, air->ns_per_step, air->plumes_m2);
  }
}

Status report_pictures(const PictureArguments& words, const ReportOptions& options) {
  PictureArguments arguments = words;
  FL_TRY(take_shadows(arguments.shadow_words, arguments.shadows));
  FL_TRY(take_penumbra(arguments.penumbra, arguments.shadows));
  FL_ASSIGN(const render::QualityRequest request, render::parse_quality(arguments.error, arguments.ms));
  if (request.any() && (arguments.fleet > 0 || !arguments.sweep.empty())) {
    return fail(ErrorCode::kBadInput, "{} chooses settings for one scene; use it without --sweep and --fleet",
                request.error > 0 ? "--error" : "--ms");
  }
  if (arguments.fleet > 0) return report_fleet(arguments, options);
  const bool generates = arguments.beams > 0 || !arguments.sweep.empty();
  if (generates && (arguments.files.demo || !arguments.files.rig.empty())) {
    return fail(ErrorCode::kBadInput,
                "--beams and --sweep generate their own scenes; use them without --rig and --demo");
  }
  if (!arguments.sweep.empty()) return report_swept(arguments, options);
  SceneFiles files = arguments.files;
  if (files.rig.empty()) files.demo = true;
  std::optional<AirReport> air;
  FL_ASSIGN(const PictureSize size, parse_size(arguments.size));
  const double aspect = static_cast<double>(size.width) / size.height;
  FL_ASSIGN(const Scene scene, arguments.beams > 0 ? make_beams_scene(arguments.beams, arguments.photometry,
                                                                      arguments.gobos || arguments.gates ? 1 : 0,
                                                                      arguments.clutter, arguments.gates ? 2 : 1)
                                                   : scene_of_files(files, arguments, aspect, air));
  FL_ASSIGN(const auto device, render::vk::Device::create({.name_contains = arguments.device}));
  PictureReportOptions picture_options = options_of(arguments, size, options);
  const char* reflections = scene.compiled.needs.probes ? "on" : "off";
  FL_ASSIGN(picture_options.reflections,
            parse_switch("--reflections", arguments.reflections.empty() ? reflections : arguments.reflections));
  picture_options.on_row = [&](const PictureReport& so_far) {
    const render::PictureRow& row = so_far.rows.back();
    if (options.json) {
      options.print(render::json_lines_of({&row, 1}));
    } else {
      options.print((so_far.rows.size() == 1 ? render::table_names_of(row) : "") + render::table_line_of(row));
    }
  };
  if (!options.json) {
    picture_options.on_judged = [&](const PictureReport& so_far) {
      options.print(intro_of(scene, arguments, picture_options, so_far));
    };
  }
  std::optional<ChosenKnobs> chosen;
  if (request.any()) {
    FL_ASSIGN(chosen, choose_knobs(*device, scene, picture_options, request, options));
    picture_options.chosen = chosen->predicted.knobs;
    if (arguments.no_judge && !options.json) options.print(text_of(*chosen));
  }
  FL_ASSIGN(const PictureReport report, make_picture_report(*device, scene, picture_options));
  if (report.rows.empty()) return {};
  if (chosen && !report.only_lasers) {
    const render::PictureRow& row = report.rows.front();
    if (picture_options.judge) {
      chosen->judged = row.rel_l2;
      chosen->judged_low = row.rel_l2_low;
      chosen->judged_high = row.rel_l2_high;
    }
    if (options.json) {
      options.print(json_of(*chosen));
    } else if (picture_options.judge) {
      options.print("\n" + text_of(*chosen));
    }
  }
  if (options.json) {
    options.print(fmt::format(R"({{"event":"whole-frame","ms_p50":{:.4f}}})"
                              "\n",
                              report.whole_ms));
    options.print(classes_json(report.classes));
    if (report.lasers.lit > 0) options.print(lasers_json(report));
    if (report.shadows > 0) options.print(shadows_json(report));
    if (scene.compiled.needs.displays) options.print(displays_json(report));
    options.print(edges_json(report));
    if (report.mirrored) options.print(json_of(*report.mirrored));
    if (scene.compiled.needs.gobo) options.print(gates_json(report));
    const render::BodyCounts& bodies = report.bodies;
    options.print(fmt::format(R"({{"event":"bodies","bodies":{},"drawn":{},"triangles":{},"drawn_triangles":{},)"
                              R"("object_triangles":{},"bytes":{}}})"
                              "\n",
                              bodies.bodies, bodies.drawn, bodies.triangles, bodies.drawn_triangles,
                              bodies.object_triangles, report.body_bytes));
    if (air) {
      fmt::print(R"({{"event":"air","haze_per_m":{:.9g},"fog_per_m":{:.9g},"error_per_m":{:.3g},"steps":{},)"
                 R"("ns_per_step":{:.1f}}})"
                 "\n",
                 air->haze_per_m, air->fog_per_m, air->error_per_m, air->steps, air->ns_per_step);
    }
  } else {
    print_figures(arguments, options, report, std::int64_t{size.width} * size.height, air);
    if (scene.compiled.needs.gobo) options.print(gates_text(report));
  }
  FL_TRY(report_left_out(*device, scene, report.sheen, picture_options, options));
  if (!options.csv.empty()) FL_TRY(write_report_file(options.csv, render::csv_of(report.rows)));
  if (!options.svg.empty()) {
    FL_TRY(write_report_file(options.svg, render::svg_plot({scene.name + ": beams", report.device,
                                                            "GPU time per frame, ms", "relative L2 error"},
                                                           render::curves_of(report.rows))));
  }
  return {};
}

}  // namespace

ReportHalf add_report_pictures(Arguments& arguments) {
  auto chosen = std::make_shared<PictureArguments>();
  add_scene_arguments(arguments, chosen->files);
  arguments.duration("--at", chosen->at_ns, "the time in the log");
  arguments.option("--beams", chosen->beams, 1, 1'000'000, "generate a scene of this many beams instead of a rig");
  arguments.option("--photometry", chosen->photometry, "FILE",
                   "with --beams: all beams have the light of this IES or EULUMDAT file");
  arguments.flag("--gobos", chosen->gobos, "with --beams: each beam has one of the eight built-in gobos");
  arguments.flag("--gates", chosen->gates, "with --beams: each beam has one of eight pairs of them");
  arguments.option("--clutter", chosen->clutter, 0, 100'000, "with --beams: boxes on the floor");
  arguments.option("--sweep", chosen->sweep, "WHAT=N,N",
                   "the rows of several generated scenes, and with --svg their times against what differs: beams, "
                   "pixels (16:9), gobos (per cent of the beams), clutter (boxes)");
  arguments.option("--fleet", chosen->fleet, 1, 1'000'000,
                   "no pictures: time a step of this many moving heads on the GPU and on one CPU core");
  arguments.option("--camera", chosen->camera, "NAME", "a camera of the rig; default: its first one");
  arguments.option("--size", chosen->size, "WxH", "size of the pictures that are timed and whose error is measured");
  arguments.option("--judge-pixels", chosen->judge_pixels, 100, 100'000'000,
                   "how many of their pixels are compared with the judge, a stratified random sample");
  arguments.option("--runs", chosen->runs, 3, 1000, "timed frames per row");
  arguments.option("--body-error", chosen->body_error_px, 0, 1000,
                   "error of fixture bodies in pixels, in the whole frame; 0: whole models");
  arguments.option("--shadows", chosen->shadow_words, "WORD", "of the whole frame; " + std::string(kShadowsHelp));
  arguments.option("--penumbra", chosen->penumbra, "POINTS",
                   "of all rows; with 4 and 7 errors are those to light from the whole of each lens, and there are "
                   "rows of 1, 4 and 7; " + std::string(kPenumbraHelp));
  arguments.option("--error", chosen->error, "SHARE", "choose the knobs for this error, as in 0.1%, and measure them");
  arguments.option("--ms", chosen->ms, "MS", "choose the knobs for this GPU time of a frame, and measure them");
  arguments.option("--device", chosen->device, "TEXT", "the Vulkan device whose name contains this text");
  arguments.option("--reflections", chosen->reflections, "WORD",
                   "on: the whole frame has light that surfaces reflect and what shiny ones mirror, with a row of the "
                   "error of that; off; default: on if the rig has something that mirrors");
  arguments.flag("--no-judge", chosen->no_judge, "measure times only, no errors");
  arguments.flag("--rivals", chosen->rivals,
                 "also rows of other methods: marches along the whole ray, equi-angular samples, froxels, cone meshes, "
                 "cards, clusters of lights on surfaces");
  arguments.option("--methods", chosen->methods, "NAME,NAME",
                   "only rows whose method begins with one of these, as in tiles,gauss");
  arguments.option("--row-seconds", chosen->row_seconds, 0, 1e9,
                   "take no more than three frames of a row after that many seconds");
  arguments.flag("--lit", chosen->lit, "without a log: every fixture at full, open and white, its axes in the middle");
  arguments.list("--set", chosen->sets, "WORDS",
                 "as --lit, and ATTRIBUTE=VALUE of all fixtures or FIXTURE:ATTRIBUTE=VALUE of one; several times");
  return [chosen](const ReportOptions& options) { return report_pictures(*chosen, options); };
}

}  // namespace footlight::tools
