#include "tools/footlight/pictures/knob_curves.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include <unistd.h>

#include "sim/core/fnv.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/pictures/timeline.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using render::Frame;
using render::FrameSettings;
using render::GoboMethod;
using render::KnobCurves;
using render::KnobPoint;
using render::Knobs;
using render::RadianceImage;

constexpr double kTileErrors[] = {0, 1e-3, 4e-3, 2e-2};
constexpr std::uint32_t kNodes[] = {2, 3, 4};
constexpr std::uint32_t kGoboTaps[] = {16, 32, 64, 128, 256};
constexpr double kBodyErrorsPx[] = {0, 0.25, 0.5, 1, 2};
constexpr DurationNs kDemoNs = 30 * kNsPerS;  // of the built-in show, whose whole pictures are timed
constexpr std::size_t kPointsMax = 1000;
constexpr std::uintmax_t kFileBytesMax = 1 << 20;

class Checksum {
 public:
  void add(std::span<const std::byte> bytes) { sum_ = fnv_sum(bytes, sum_); }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", sum_); }

 private:
  std::uint64_t sum_ = kFnvStart;
};

double relative_l2(const RadianceImage& picture, const RadianceImage& reference) {
  double error = 0;
  double square = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    const double r = static_cast<double>(reference.rgb[i]);
    const double x = std::isfinite(picture.rgb[i]) ? static_cast<double>(picture.rgb[i]) : 0;
    error += (x - r) * (x - r);
    square += r * r;
  }
  return square > 0 ? std::sqrt(error / square) : 0;
}

}  // namespace

KnobBench::KnobBench(const Scene& scene, const FrameSettings& settings)
    : settings_(settings), view_(render::view_of(scene.camera)), exposure_ev_(scene.camera.exposure_ev) {}

Result<KnobBench> KnobBench::make(render::vk::Device& device, const Scene& scene, const FrameSettings& settings) {
  KnobBench bench(scene, settings);
  FL_ASSIGN(bench.frame_, Frame::create(device, scene.rig, scene.compiled, render::general_settings(settings)));
  bench.frame_->step(scene.levels, 0);
  return bench;
}

Status KnobBench::draw() { return frame_->draw(view_, exposure_ev_); }

Result<double> KnobBench::error_of(const Knobs& knobs) {
  if (general_.rgb.empty()) {
    FL_TRY(frame_->change(render::general_settings(settings_)));
    FL_TRY(draw());
    FL_ASSIGN(general_, frame_->read_radiance());
  }
  FL_TRY(frame_->change(render::with_knobs(settings_, knobs)));
  FL_TRY(draw());
  FL_ASSIGN(const RadianceImage picture, frame_->read_radiance());
  return relative_l2(picture, general_);
}

Result<double> KnobBench::ms_of(const Knobs& knobs, int runs) {
  FrameSettings settings = render::with_knobs(settings_, knobs);
  settings.width = std::max(settings.width / knobs.divisor, 1);
  settings.height = std::max(settings.height / knobs.divisor, 1);
  FL_TRY(frame_->change(settings));
  double least_ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    FL_TRY(draw());
    const double wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    FL_ASSIGN(const auto passes, frame_->read_times());
    double gpu_ms = 0;
    for (const render::PassTime& pass : passes) gpu_ms += pass.gpu_ms;
    least_ms = std::min(least_ms, passes.empty() ? wall_ms : gpu_ms);
  }
  return std::max(least_ms, 1e-4);
}

KnobCurveOptions suited_curve_options(const render::vk::Device& device) {
  KnobCurveOptions options;
  if (!device.is_software()) return options;
  options.width = 192;
  options.height = 108;
  options.beams = 150;  // tiles are for 128 beams and more
  options.gobo_beams = 4;
  options.whole_width = 320;
  options.whole_height = 180;
  options.runs = 2;
  return options;
}

namespace {

// The built-in rig as the built-in show has it then, with motors at their targets.
Result<Scene> demo_scene(DurationNs at_ns) {
  SceneFiles files;
  files.demo = true;
  Scene scene;
  scene.name = "demo";
  FL_ASSIGN(scene.rig, load_scene_rig(files));
  FL_ASSIGN(scene.compiled, fixtures::compile(scene.rig));
  FL_ASSIGN(scene.camera, find_camera(scene.rig, {}));
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(files));
  FL_CHECK(log);
  Timeline timeline(std::move(*log), scene.compiled);
  FL_TRY(timeline.advance(at_ns, 0, [&](std::span<const std::uint8_t> levels, std::int64_t, bool) {
    scene.levels.assign(levels.begin(), levels.end());
  }));
  return scene;
}

// Times of the points, a run of each in turn, so that what else the machine does meets all alike.
// timed_with: the knobs with which a point is timed.
template <class TimedWith>
Status time_points(KnobBench& bench, std::vector<KnobPoint>& points, int runs, TimedWith timed_with) {
  for (KnobPoint& point : points) point.ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < runs; ++i) {
    for (KnobPoint& point : points) {
      FL_ASSIGN(const double ms, bench.ms_of(timed_with(point.knobs), 1));
      point.ms = std::min(point.ms, ms);
    }
  }
  return {};
}

// Errors of the points, then their times.
template <class TimedWith>
Status measure(KnobBench& bench, std::vector<KnobPoint>& points, int runs, const std::function<Status()>& begin_knob,
               TimedWith timed_with) {
  for (KnobPoint& point : points) {
    FL_TRY(begin_knob());
    FL_ASSIGN(point.error, bench.error_of(point.knobs));
  }
  return time_points(bench, points, runs, timed_with);
}

// With the cheapest of the other knobs, and the plainest bodies.
Status time_whole_pictures(render::vk::Device& device, const KnobCurveOptions& options,
                           const std::function<Status()>& begin_knob, KnobCurves& curves) {
  const auto cheapest = [](const std::vector<KnobPoint>& points) {
    return std::min_element(points.begin(), points.end(),
                            [](const KnobPoint& a, const KnobPoint& b) { return a.ms < b.ms; })
        ->knobs;
  };
  FrameSettings settings;
  settings.width = options.whole_width;
  settings.height = options.whole_height;
  settings.edge_samples = render::suited_edge_samples(device);
  settings.shadow_map_px = render::kMapUsualPx;
  settings.bounce = settings.probes = true;
  FL_ASSIGN(const Scene demo, demo_scene(kDemoNs));
  FL_ASSIGN(KnobBench bench, KnobBench::make(device, demo, settings));
  const Knobs gobos = cheapest(curves.gobos);
  Knobs whole = cheapest(curves.beams);
  whole.gobo_method = gobos.gobo_method;
  whole.gobo_taps = gobos.gobo_taps;
  whole.body_error_px = curves.bodies.back().knobs.body_error_px;
  curves.left_out.push_back({whole, 0, 0});
  for (const Knobs& leaves : render::left_out_knobs()) {
    curves.left_out.push_back({render::without(whole, leaves), 0, 0});
  }
  for (const KnobPoint& point : curves.left_out) {
    FL_TRY(begin_knob());
    FL_TRY(bench.ms_of(point.knobs, 1));  // compiles
  }
  return time_points(bench, curves.left_out, options.runs, [](const Knobs& knobs) { return knobs; });
}

}  // namespace

Result<KnobCurves> measure_knob_curves(render::vk::Device& device, const KnobCurveOptions& options) {
  KnobCurves curves;
  const bool tables = !device.is_software();  // a CPU takes seconds to build tables, and samples faster
  const Knobs best = render::knobs_of(render::general_settings({}));
  const Knobs usual;
  const auto same = [](const Knobs& knobs) { return knobs; };

  Knobs exact;
  exact.tile_error = best.tile_error;
  exact.nodes = best.nodes;
  curves.beams.push_back({exact, 0, 0});
  for (const std::uint32_t nodes : kNodes) {
    for (const double tile_error : kTileErrors) {
      Knobs knobs;
      knobs.tile_error = tile_error;
      knobs.nodes = nodes;
      curves.beams.push_back({knobs, 0, 0});
    }
  }
  const auto gobo_point = [&](GoboMethod method, std::uint32_t taps) {
    Knobs knobs = best;
    knobs.gobo_method = method;
    knobs.gobo_taps = taps;
    curves.gobos.push_back({knobs, 0, 0});
  };
  gobo_point(GoboMethod::kTaps, best.gobo_taps);
  for (const std::uint32_t taps : kGoboTaps) gobo_point(GoboMethod::kTaps, taps);
  if (tables) gobo_point(GoboMethod::kTables, usual.gobo_taps);
  for (const double error_px : kBodyErrorsPx) {
    Knobs knobs = usual;
    knobs.body_error_px = error_px;
    curves.bodies.push_back({knobs, 0, 0});
  }
  double done = 0;
  const auto all = static_cast<double>(curves.beams.size() + curves.gobos.size() + curves.bodies.size() + 1 +
                                       render::left_out_knobs().size());
  const std::function<Status()> begin_knob = [&]() -> Status {
    if (!options.go_on || options.go_on(done++, all)) return {};
    return fail(ErrorCode::kIo, "the measurement of knobs was ended");
  };

  if (options.go_on && !options.go_on(0, all)) return fail(ErrorCode::kIo, "the measurement of knobs was ended");
  FrameSettings settings;
  settings.width = options.width;
  settings.height = options.height;
  settings.bodies = false;
  FL_ASSIGN(const Scene beams, make_beams_scene(options.beams));
  {
    FL_ASSIGN(KnobBench bench, KnobBench::make(device, beams, settings));
    FL_TRY(measure(bench, curves.beams, options.runs, begin_knob, same));
  }
  settings.bodies = true;
  settings.haze = false;
  {
    FL_ASSIGN(KnobBench bench, KnobBench::make(device, beams, settings));
    FL_TRY(measure(bench, curves.bodies, options.runs, begin_knob, same));
  }
  settings.bodies = false;
  settings.haze = true;
  settings.width /= options.gobo_divisor;
  settings.height /= options.gobo_divisor;
  FL_ASSIGN(const Scene gobos, make_beams_scene(options.gobo_beams, {}, true));
  {
    FL_ASSIGN(KnobBench bench, KnobBench::make(device, gobos, settings));
    FL_TRY(measure(bench, curves.gobos, options.runs, begin_knob, [&](Knobs knobs) {
      knobs.tile_error = usual.tile_error;
      knobs.nodes = usual.nodes;
      return knobs;
    }));
  }
  // Of the other knobs a point of gobos says nothing.
  for (KnobPoint& point : curves.gobos) {
    Knobs knobs;
    knobs.gobo_method = point.knobs.gobo_method;
    knobs.gobo_taps = point.knobs.gobo_taps;
    point.knobs = knobs;
  }
  FL_TRY(time_whole_pictures(device, options, begin_knob, curves));
  return curves;
}

std::string curves_program() {
  Checksum sum;
  for (const render::PassShaders& pass : render::pass_shaders()) {
    for (const auto& stages : pass.pipelines) {
      for (const render::vk::Spirv& stage : stages) sum.add(std::as_bytes(stage));
    }
  }
  return fmt::format("{}-{}", FOOTLIGHT_VERSION, sum.text());
}

std::string knob_curves_path(const std::string& folder, const render::vk::DeviceFacts& facts) {
  std::string name = folder + "/knobs-";
  for (const std::uint8_t byte : facts.id.deviceUUID) name += fmt::format("{:02x}", byte);
  return name + fmt::format("-{:08x}.txt", facts.properties.driverVersion);
}

namespace {

// What the curves hold for: the first line of the file, with the checksum of all that follows.
std::string first_line(const render::vk::DeviceFacts& facts, std::string_view program, std::string_view rows) {
  Checksum sum;
  sum.add(std::as_bytes(std::span(rows)));
  std::string uuid;
  for (const std::uint8_t byte : facts.id.deviceUUID) uuid += fmt::format("{:02x}", byte);
  return fmt::format("footlight-knobs 2 {} {:08x} {} {}\n", uuid, facts.properties.driverVersion, program, sum.text());
}

constexpr std::pair<const char*, std::vector<KnobPoint> KnobCurves::*> kGroups[] = {
    {"beams", &KnobCurves::beams},
    {"gobos", &KnobCurves::gobos},
    {"bodies", &KnobCurves::bodies},
    {"left_out", &KnobCurves::left_out}};

bool is_sound(const KnobPoint& point) {
  return std::isfinite(point.error) && point.error >= 0 && std::isfinite(point.ms) && point.ms > 0 &&
         point.knobs.nodes >= 1 && point.knobs.nodes <= 8 && point.knobs.tile_error >= 0 &&
         point.knobs.tile_error <= 1 && point.knobs.gobo_taps >= 1 && point.knobs.gobo_taps <= 1024 &&
         point.knobs.body_error_px >= 0 && point.knobs.body_error_px <= 1000 && point.knobs.divisor >= 1 &&
         point.knobs.divisor <= 4 && point.knobs.gobo_method <= GoboMethod::kSuited;
}

}  // namespace

Status write_knob_curves(const std::string& path, const render::vk::DeviceFacts& facts, std::string_view program,
                         const KnobCurves& curves) {
  std::string rows =
      "group tile_error nodes gobo_method gobo_taps body_error_px smooth_edges bounce shadows divisor error ms\n";
  for (const auto& [name, group] : kGroups) {
    for (const KnobPoint& point : curves.*group) {
      const Knobs& knobs = point.knobs;
      rows += fmt::format("{} {} {} {} {} {} {:d} {:d} {:d} {} {} {}\n", name, knobs.tile_error, knobs.nodes,
                          static_cast<std::uint32_t>(knobs.gobo_method), knobs.gobo_taps, knobs.body_error_px,
                          knobs.smooth_edges, knobs.bounce, knobs.shadows, knobs.divisor, point.error, point.ms);
    }
  }
  std::error_code trouble;
  fs::create_directories(fs::path(path).parent_path(), trouble);
  const std::string part = fmt::format("{}.{}.part", path, getpid());
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream << first_line(facts, program, rows) << rows;
  stream.close();
  if (stream && std::rename(part.c_str(), path.c_str()) == 0) return {};
  fs::remove(part, trouble);
  return fail(ErrorCode::kIo, "{}: cannot be written; the knobs are measured again by the next run", path);
}

std::optional<KnobCurves> read_knob_curves(const std::string& path, const render::vk::DeviceFacts& facts,
                                           std::string_view program) {
  std::error_code trouble;
  if (!fs::is_regular_file(path, trouble) || fs::file_size(path, trouble) > kFileBytesMax || trouble) return {};
  std::ifstream stream(path, std::ios::binary);
  std::string head;
  std::getline(stream, head);
  const std::string rows{std::istreambuf_iterator<char>(stream), {}};
  if (head + "\n" != first_line(facts, program, rows)) return {};
  KnobCurves curves;
  std::istringstream lines(rows);
  std::string line;
  std::getline(lines, line);  // the names of the columns
  for (std::size_t count = 0; std::getline(lines, line); ++count) {
    std::istringstream words(line);
    std::string name;
    KnobPoint point;
    std::uint32_t method = 0;
    Knobs& knobs = point.knobs;
    words >> name >> knobs.tile_error >> knobs.nodes >> method >> knobs.gobo_taps >> knobs.body_error_px >>
        knobs.smooth_edges >> knobs.bounce >> knobs.shadows >> knobs.divisor >> point.error >> point.ms;
    knobs.gobo_method = static_cast<GoboMethod>(method);
    const auto group =
        std::find_if(std::begin(kGroups), std::end(kGroups), [&](const auto& one) { return one.first == name; });
    if (!words || !is_sound(point) || group == std::end(kGroups) || count >= kPointsMax) return {};
    (curves.*(group->second)).push_back(point);
  }
  if (curves.beams.empty() || curves.gobos.empty() || curves.bodies.empty() || curves.left_out.empty()) return {};
  return curves;
}

Result<KnobCurves> machine_knob_curves(render::vk::Device& device, const std::string& folder,
                                       const KnobCurveOptions& options, const std::function<void()>& on_measure) {
  const std::string program = curves_program();
  const std::string path = folder.empty() ? "" : knob_curves_path(folder, device.facts());
  if (!path.empty()) {
    if (auto kept = read_knob_curves(path, device.facts(), program)) return std::move(*kept);
  }
  if (on_measure) on_measure();
  FL_ASSIGN(KnobCurves curves, measure_knob_curves(device, options));
  if (!path.empty()) (void)write_knob_curves(path, device.facts(), program, curves);
  return curves;
}

}  // namespace footlight::tools
