// footlight report: error against run time of every approximation, and what the rig left out.
#include <cstdio>
#include <fstream>
#include <memory>

#include "render/frame.h"
#include "render/reference/report.h"
#include "render/reference/time_report.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/picture_report.h"
#include "tools/footlight/scene_files.h"
#include "tools/footlight/timeline.h"

namespace footlight::tools {
namespace {

struct Options {
  SceneFiles files;
  DurationNs at_ns = 30 * kNsPerS;
  int beams = 0;
  std::string size = "640x360";
  std::string judge_size = "64x36";
  std::string camera;
  std::string device;
  std::string csv;
  std::string svg;
  int runs = 11;
  bool pictures = false;
  bool time = false;
  bool no_judge = false;
  bool quick = false;
  bool json = false;
};

Status write_text(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) return fail(ErrorCode::kIo, "{}: cannot be written; choose a folder that exists and is yours", path);
  return {};
}

// "plot.svg" and "axis" give "plot-axis.svg".
std::string with_suffix(const std::string& path, const std::string& suffix) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return path + "-" + suffix;
  return path.substr(0, dot) + "-" + suffix + path.substr(dot);
}

// The scene as the log has it at a time. Motors stand where the levels send them, so that GPU and judge start from the
// same state without a history.
Result<Scene> scene_of_files(const SceneFiles& files, DurationNs at_ns, const std::string& camera) {
  Scene scene;
  FL_ASSIGN(scene.rig, load_scene_rig(files));
  FL_ASSIGN(scene.compiled, fixtures::compile(scene.rig));
  FL_ASSIGN(scene.camera, find_camera(scene.rig, camera));
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(files));
  if (log) {
    Timeline timeline(std::move(*log), scene.compiled);
    FL_TRY(timeline.advance(at_ns, 0, [&](std::span<const std::uint8_t> levels, std::int64_t, bool) {
      scene.levels.assign(levels.begin(), levels.end());
    }));
  }
  scene.name = fmt::format("{}@{}", files.demo ? "demo" : files.rig, show_duration(at_ns));
  return scene;
}

void print_left_out(const Scene& scene) {
  fmt::print("Left out, since {} does not need it:\n", scene.name);
  const render::FrameSettings settings;
  bool any = false;
  for (const auto& pass : render::left_out_passes(scene.compiled.needs, settings)) {
    fmt::print("  pass {}: {}\n", pass.name, pass.gives);
    any = true;
  }
  for (const std::string& line : fixtures::left_out(scene.compiled.needs)) {
    fmt::print("  {}\n", line);
    any = true;
  }
  if (!any) fmt::print("  nothing\n");
}

Status report_pictures(const Options& options) {
  if (options.beams > 0 && (options.files.demo || !options.files.rig.empty())) {
    return fail(ErrorCode::kBadInput, "--beams makes its own scene: expected it without --rig and --demo");
  }
  SceneFiles files = options.files;
  if (files.rig.empty()) files.demo = true;
  FL_ASSIGN(const Scene scene,
            options.beams > 0 ? make_beams_scene(options.beams) : scene_of_files(files, options.at_ns, options.camera));
  FL_ASSIGN(const PictureSize size, parse_size(options.size));
  FL_ASSIGN(const PictureSize judge_size, parse_size(options.judge_size));
  FL_ASSIGN(const auto device, render::vk::Device::create({.name_contains = options.device}));
  PictureReportOptions picture_options;
  picture_options.width = size.width;
  picture_options.height = size.height;
  picture_options.judge_width = judge_size.width;
  picture_options.judge_height = judge_size.height;
  picture_options.runs = options.runs;
  picture_options.judge = !options.no_judge;
  if (options.quick) {
    picture_options.gauss_nodes = {2, 3, 4};
    picture_options.march_steps = {16, 64};
    picture_options.gobo_taps = {16, 64};
  }
  FL_ASSIGN(const PictureReport report, make_picture_report(*device, scene, picture_options));
  const auto curves = render::curves_of(report.rows);
  if (options.json) {
    fmt::print("{}", render::json_lines_of(report.rows));
  } else {
    fmt::print("Pictures of {}: beams in haze and on surfaces, on {}.\n", scene.name, report.device);
    fmt::print("Times: GPU, {}x{}, {} runs after 3. ", size.width, size.height, options.runs);
    if (options.no_judge) {
      fmt::print("Not judged.\n\n");
    } else {
      fmt::print(
          "Errors: {}x{} of the same view against adaptive quadrature in double, whose own error is {:.1e} "
          "(it took {:.1f} s).\n\n",
          judge_size.width, judge_size.height, report.judge_own_rel_l2, report.judge_seconds);
    }
    fmt::print("{}\n", render::table_of(report.rows));
    for (const auto& row : report.rows) {
      if (row.ms_p10 > 0 && row.ms_p90 / row.ms_p10 > 1.15) {
        fmt::print("unstable: {} {} varies by {:.2f} between p10 and p90\n", row.method, row.knob,
                   row.ms_p90 / row.ms_p10);
      }
    }
    if (!options.no_judge) {
      const double costs[] = {1, 4, 16};
      fmt::print("{}\n", render::summary_of(curves, "ms", costs));
    }
    fmt::print("GPU time a pass with {} nodes:", render::FrameSettings{}.nodes);
    for (const auto& pass : report.passes) fmt::print("  {} {:.3f} ms", pass.name, pass.gpu_ms);
    fmt::print("\n\n");
    print_left_out(scene);
    fmt::print("\n");
  }
  if (!options.csv.empty()) FL_TRY(write_text(options.csv, render::csv_of(report.rows)));
  if (!options.svg.empty()) {
    FL_TRY(write_text(options.svg, render::svg_plot({scene.name + ": beams", report.device, "GPU time a frame, ms",
                                                     "relative L2 error"},
                                                    curves)));
  }
  return {};
}

Status report_time(const Options& options) {
  render::TimeReportOptions time_options;
  if (options.quick) {
    time_options.stiffness_per_s = {20, 200};
    time_options.fps = {30, 60};
    time_options.substeps = {1, 16};
    time_options.seconds = 5;
  }
  const auto rows = render::time_rows(time_options);
  if (options.json) {
    fmt::print("{}", render::json_lines_of(rows));
  } else {
    fmt::print("Motors and shutters: error against run time on one CPU core; the judge's own error is {:.1e}.\n\n",
               render::axis_judge_own_error(time_options));
    fmt::print("{}\n", render::table_of(rows));
  }
  const std::string csv = options.csv.empty() ? "" : with_suffix(options.csv, "time");
  if (!csv.empty()) FL_TRY(write_text(csv, render::csv_of(rows)));
  if (!options.svg.empty()) {
    std::vector<render::TimeRow> axis;
    for (const auto& row : rows) {
      if (row.model == "axis" && row.stiffness == 20 && row.fps == 60) axis.push_back(row);
    }
    FL_TRY(write_text(with_suffix(options.svg, "time"),
                      render::svg_plot({"axis: 540 degrees of pan, stiffness 20 /s, 60 fps", "one CPU core",
                                        "time a step, ns", "largest error over the range"},
                                       render::curves_of(axis))));
  }
  return {};
}

Result<int> report(const Options& options) {
  const bool both = options.pictures == options.time;
  if (both || options.pictures) FL_TRY(report_pictures(options));
  if (both || options.time) FL_TRY(report_time(options));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  add_scene_arguments(arguments, options->files);
  arguments.duration("--at", options->at_ns, "the moment of the log that is looked at");
  arguments.option("--beams", options->beams, 1, 1'000'000, "a made scene of this many beams in place of a rig");
  arguments.option("--camera", options->camera, "NAME", "a camera of the rig; its first one");
  arguments.option("--size", options->size, "WxH", "size of the pictures that are timed");
  arguments.option("--judge-size", options->judge_size, "WxH", "size of the pictures that are judged");
  arguments.option("--runs", options->runs, 3, 1000, "timed frames a row");
  arguments.option("--device", options->device, "TEXT", "the Vulkan device whose name contains this");
  arguments.flag("--pictures", options->pictures, "pictures only");
  arguments.flag("--time", options->time, "motors and shutters only");
  arguments.flag("--no-judge", options->no_judge, "times only");
  arguments.flag("--quick", options->quick, "fewer knobs");
  arguments.option("--csv", options->csv, "FILE", "rows of pictures as CSV; those of time go beside it, FILE-time");
  arguments.option("--svg", options->svg, "FILE", "the plot; that of time goes beside it, FILE-time");
  arguments.flag("--json", options->json, "one JSON object a row");
  arguments.job([options]() -> Result<int> { return report(*options); });
}

}  // namespace

extern const CommandInfo report_command{
    .name = "report",
    .help = "How wrong each approximation is, what it costs, and what the rig left out",
    .examples =
        "  footlight report --quick\n"
        "  footlight report --rig rig.toml --log show.dmxlog --at 12.5s --svg beams.svg --csv beams.csv\n"
        "  footlight report --pictures --beams 10000 --size 3840x2160 --judge-size 96x54\n"
        "  footlight report --time --json\n"
        "Without a rig: the demo. Errors are against adaptive quadrature in double, or an event-exact integrator.",
    .add = add,
};

}  // namespace footlight::tools
