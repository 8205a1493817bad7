#include "tools/footlight/report/picture_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <fmt/ranges.h>

#include "render/pass.h"
#include "render/reference/norms.h"
#include "render/reference/pixel_sample.h"
#include "render/rivals/rivals.h"
#include "tools/footlight/report/judged_scene.h"
#include "tools/footlight/report/laser_report.h"
#include "tools/footlight/report/other_light.h"

namespace footlight::tools {

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::llround(share * static_cast<double>(values.size() - 1)))];
}

namespace {

using namespace render;

Result<std::unique_ptr<Frame>> make_frame(vk::Device& device, const Scene& scene, const FrameSettings& settings,
                                          const PassList& passes = product_passes()) {
  FL_ASSIGN(auto frame, Frame::create(device, scene.rig, scene.compiled, settings, passes));
  frame->set_puffs(scene.puffs);
  frame->step(scene.levels, 0);
  return frame;
}

// The times of one pass in several frames, ms. A frame with floors that mirror also has one of the mirrored picture.
struct PassTimes {
  std::string name;
  std::vector<double> ms;
};

void add_times(std::vector<PassTimes>& times, const std::vector<PassTime>& frame) {
  for (const PassTime& pass : frame) {
    const auto found =
        std::find_if(times.begin(), times.end(), [&](const PassTimes& each) { return each.name == pass.name; });
    PassTimes& own = found == times.end() ? times.emplace_back(PassTimes{pass.name, {}}) : *found;
    own.ms.push_back(pass.gpu_ms);
  }
}

// Returns the times of `runs` frames after 3 warm-up frames. Writes the times of each pass to `pass_ms` and those of
// the first frame to `first`, if they are not null. After row_seconds there are no more than one warm-up and 3 runs.
// Calls `go_on` with the finished share before each frame; false ends the timing early.
Result<std::vector<double>> time_frames(Frame& frame, const View& view, const Scene& scene, int runs,
                                        double row_seconds, std::vector<PassTimes>* pass_ms,
                                        const std::function<bool(double)>& go_on,
                                        std::vector<PassTime>* first = nullptr) {
  std::vector<double> times_ms;
  if (pass_ms != nullptr) pass_ms->clear();
  const auto start = std::chrono::steady_clock::now();
  for (int i = -3; i < runs; ++i) {
    if (!go_on((i + 3.0) / (runs + 4.0))) break;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    if (taken.count() > row_seconds) {
      if (i > -3) i = std::max(i, 0);
      if (times_ms.size() >= 3) break;
    }
    FL_TRY(frame.draw(view, scene.camera.exposure_ev));
    FL_ASSIGN(const auto passes, frame.read_times());
    if (i == -3 && first != nullptr) *first = passes;
    if (i < 0) continue;
    double total_ms = 0;
    for (const PassTime& pass : passes) total_ms += pass.gpu_ms;
    if (pass_ms != nullptr) add_times(*pass_ms, passes);
    times_ms.push_back(total_ms);
  }
  return times_ms;
}

// The pixels that are compared, and the judge's values.
struct Judged {
  PixelSample sample;
  JudgedPixels pixels;
  double hits_per_px = 0;
  ScreenImage screen;  // empty unless every pixel is compared
};

// Arbitrary, but fixed.
constexpr std::uint64_t kSampleSeed = 1;

FrameSettings judged_settings(const PictureReportOptions& options) {
  FrameSettings settings;
  settings.width = options.width;
  settings.height = options.height;
  settings.bodies = false;
  settings.widen_thin = false;
  settings.edge_samples = 0;
  settings.penumbra = options.penumbra;
  settings.gloss_px = 0;       // nor behind that of what floors mirror
  settings.shadow_map_px = 0;  // what other knobs do is not hidden behind the error of maps
  return settings;
}

// Stratifies the sample by the picture of the default method.
Result<Judged> judge_scene_of(vk::Device& device, const Scene& scene, const View& view,
                              const PictureReportOptions& options) {
  Judged judged;
  {
    FL_ASSIGN(const auto frame, make_frame(device, scene, judged_settings(options)));
    FL_TRY(frame->draw(view, scene.camera.exposure_ev));
    FL_ASSIGN(const RadianceImage pilot, frame->read_radiance());
    judged.sample = sample_pixels(pilot, options.judge_pixels, kSampleSeed);
  }
  JudgeScene judge = judge_of(scene, judged_settings(options), device.is_software());
  if (options.penumbra > 1) judge.lens = judge_lens(kJudgeLens);
  JudgeOptions judge_options;
  if (options.go_on) {
    judge_options.go_on = [&](int done, int all) { return options.go_on("judged pixels", done, all); };
  }
  judged.pixels = judge_pixels(judge, view, options.width, options.height, judged.sample.pixels, judge_options);
  const auto all = static_cast<double>(options.width) * options.height;
  for (std::size_t i = 0; i < judged.pixels.hits.size(); ++i) {
    judged.hits_per_px += judged.sample.weight(i) * judged.pixels.hits[i] / all;
  }
  if (judged.sample.whole) {
    const std::vector<float> rgb(judged.pixels.rgb.begin(), judged.pixels.rgb.end());
    judged.screen = screen_of({options.width, options.height, rgb}, scene.camera.exposure_ev);
  }
  return judged;
}

// Of a row that is not judged: 0 would say that it is exact.
void leave_errors_out(PictureRow& row) {
  row.rel_l2 = row.rel_l2_low = row.rel_l2_high = row.rel_mse = row.p999 = row.max = row.flip = std::nan("");
}

void fill_norms(const Judged& judged, const std::vector<float>& values, PictureRow& row) {
  const SampledNorms sampled = sampled_norms(judged.sample, values, judged.pixels.rgb);
  row.rel_l2 = sampled.norms.rel_l2;
  row.rel_l2_low = sampled.rel_l2_low;
  row.rel_l2_high = sampled.rel_l2_high;
  row.rel_mse = sampled.norms.rel_mse;
  row.p999 = sampled.norms.p999;
  row.max = sampled.norms.max;
}

Status judge_row(Frame& frame, const Judged& judged, PictureRow& row) {
  FL_ASSIGN(const RadianceImage picture, frame.read_radiance());
  fill_norms(judged, at_sample<float>(judged.sample, picture.rgb, 3), row);
  // Counts over all pixels, because this needs no judge.
  row.nonfinite = std::count_if(picture.rgb.begin(), picture.rgb.end(), [](float v) { return !std::isfinite(v); });
  if (!judged.sample.whole) return {};
  FL_ASSIGN(const ScreenImage screen, frame.read_screen());
  row.flip = flip(screen, judged.screen).mean;
  return {};
}

// A method with one value of its knob.
struct Knob {
  const char* method;
  double value;
  FrameSettings settings;
  PassList passes = product_passes();
  const Rival* rival = nullptr;  // null: of the product
};

// The picture without the light that a rival makes, at the pixels that are compared. Without light on surfaces it
// shows them black, behind the haze.
Result<std::vector<float>> sample_without(vk::Device& device, const Scene& scene, const View& view,
                                          const PictureReportOptions& options, const Rival& rival,
                                          const Judged& judged) {
  FrameSettings settings = judged_settings(options);
  settings.tile_error = 0;
  Scene dark = scene;
  if (rival.on_surfaces) {
    for (fixtures::StageBox& box : dark.rig.boxes) box.albedo = glm::dvec3(0);
  }
  const PassList passes = rival.on_surfaces ? product_passes() : passes_with_air({});
  FL_ASSIGN(const auto frame, make_frame(device, dark, settings, passes));
  FL_TRY(frame->draw(view, scene.camera.exposure_ev));
  FL_ASSIGN(const RadianceImage picture, frame->read_radiance());
  return at_sample<float>(judged.sample, picture.rgb, 3);
}

// Whether a pass is one of those in which methods differ: light in the haze, or on surfaces where the method is one of
// surfaces.
bool is_own(const Knob& knob, const std::string& pass) {
  if (knob.rival != nullptr && knob.rival->on_surfaces) return pass == "clusters";
  const PassList shared = passes_with_air({});
  return std::none_of(shared.begin(), shared.end(), [&](const PassEntry* each) { return pass == each->name; });
}

// The row of a rival without a unit with its light times the factor that gives the least error. The knob is that
// factor. `without`: the picture without the light that the rival makes.
Status fit_row(Frame& frame, const Judged& judged, const std::vector<float>& without, double exposure_ev,
               PictureRow& row) {
  FL_ASSIGN(const RadianceImage picture, frame.read_radiance());
  std::vector<float> values = at_sample<float>(judged.sample, picture.rgb, 3);
  double with_reference = 0;
  double with_itself = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double light = static_cast<double>(values[i]) - static_cast<double>(without[i]);
    const double weight = judged.sample.weight(i / 3);
    if (!std::isfinite(light)) continue;
    with_reference += weight * light * (judged.pixels.rgb[i] - static_cast<double>(without[i]));
    with_itself += weight * light * light;
  }
  row.knob = with_itself > 0 ? std::max(with_reference / with_itself, 0.0) : 0;
  const auto factor = static_cast<float>(row.knob);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = without[i] + factor * (values[i] - without[i]);
  fill_norms(judged, values, row);
  if (judged.sample.whole) {
    row.flip = flip(screen_of({picture.width, picture.height, values}, exposure_ev), judged.screen).mean;
  }
  return {};
}

std::vector<Knob> knobs_of(const PictureReportOptions& options, const fixtures::Needs& needs) {
  std::vector<Knob> knobs;
  if (options.chosen) {
    const FrameSettings chosen = render::with_knobs(judged_settings(options), *options.chosen);
    knobs.push_back({"chosen", chosen.tile_error, chosen});
  }
  FrameSettings settings = judged_settings(options);
  for (const double error : options.tile_errors) {
    settings.tile_error = error;
    knobs.push_back({"tiles", error, settings});
  }
  settings = judged_settings(options);
  settings.tile_error = 0;
  if (needs.gobo && !options.gobo_taps.empty()) {
    settings.gobo_method = GoboMethod::kTables;
    knobs.push_back({"gobo tables", static_cast<double>(settings.gobo_taps), settings});
  }
  for (const std::uint32_t taps : options.gobo_taps) {
    if (!needs.gobo) break;
    settings.gobo_taps = taps;
    settings.gobo_method = GoboMethod::kMidpoints;
    knobs.push_back({"gobo midpoints", static_cast<double>(taps), settings});
    settings.gobo_method = GoboMethod::kTaps;
    knobs.push_back({"gobo taps", static_cast<double>(taps), settings});
  }
  settings = judged_settings(options);
  settings.tile_error = 0;
  for (const std::uint32_t nodes : options.gauss_nodes) {
    settings.nodes = nodes;
    knobs.push_back({"gauss", static_cast<double>(nodes), settings});
  }
  settings.method = BeamMethod::kMarch;
  for (const std::uint32_t steps : options.march_steps) {
    settings.nodes = steps;
    knobs.push_back({"march", static_cast<double>(steps), settings});
  }
  settings = judged_settings(options);
  for (const std::uint32_t points : {1u, 4u, 7u}) {
    if (options.penumbra == 1 || !render::has_shadows(needs, settings)) break;
    settings.penumbra = points;
    knobs.push_back({"shadows from lens points", static_cast<double>(points), settings});
  }
  if (!options.rivals) return knobs;
  settings = judged_settings(options);
  settings.tile_error = 0;
  knobs.push_back({"no haze", 0, settings, passes_with_air({})});
  settings = judged_settings(options);
  if (render::has_shadows(needs, settings)) {
    settings.shadows = false;
    knobs.push_back({"no shadows", settings.tile_error, settings});
    settings.shadows = true;
    for (const std::uint32_t px : {32u, 64u, 128u, 256u}) {
      settings.shadow_map_px = px;
      knobs.push_back({"cut shadow maps", static_cast<double>(px), settings});
    }
  }
  for (const Rival& rival : rivals()) {
    if (rival.of_shadows && !render::has_shadows(needs, judged_settings(options))) continue;
    if (rival.of_panes && !needs.panes) continue;
    for (const double knob : options.quick ? rival.quick_knobs : rival.knobs) {
      knobs.push_back({rival.method, knob, rival.settings(judged_settings(options), knob), rival.passes(), &rival});
    }
  }
  return knobs;
}

// Those of PictureReportOptions::methods, and what --error or --ms chose.
Result<std::vector<Knob>> asked_knobs(const PictureReportOptions& options, const fixtures::Needs& needs) {
  std::vector<Knob> all = knobs_of(options, needs);
  if (options.methods.empty()) return all;
  std::vector<bool> asked(all.size());
  for (std::size_t at = 0; at <= options.methods.size();) {
    const std::size_t end = std::min(options.methods.find(',', at), options.methods.size());
    const std::string word = options.methods.substr(at, end - at);
    bool any = false;
    for (std::size_t i = 0; i < all.size() && !word.empty(); ++i) {
      if (!std::string_view(all[i].method).starts_with(word)) continue;
      any = asked[i] = true;
    }
    if (!any) {
      std::vector<std::string_view> names;
      for (const Knob& knob : all) names.emplace_back(knob.method);
      names.erase(std::unique(names.begin(), names.end()), names.end());
      return fail(ErrorCode::kBadInput, "--methods: no row of the scene begins with \"{}\"; expected some of: {}", word,
                  fmt::join(names, ", "));
    }
    at = end + 1;
  }
  std::vector<Knob> some;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (asked[i] || std::string_view(all[i].method) == "chosen") some.push_back(all[i]);
  }
  return some;
}

// Times the frame as `footlight render` draws it, and counts its bodies and the classes of its beams.
Status measure_whole(vk::Device& device, const Scene& scene, const View& view, const PictureReportOptions& options,
                     PictureReport& report) {
  FrameSettings whole;
  whole.width = options.width;
  whole.height = options.height;
  whole.body_error_px = options.body_error_px;
  whole.shadows = options.shadows;
  whole.shadow_map_px = options.shadow_map_px;
  whole.penumbra = options.penumbra;
  whole.bounce = whole.probes = options.reflections;
  FL_ASSIGN(auto frame, make_frame(device, scene, whole));
  std::vector<PassTimes> pass_ms;
  std::vector<PassTime> first;
  FL_ASSIGN(const auto times_ms, time_frames(
                                     *frame, view, scene, options.runs, options.row_seconds, &pass_ms,
                                     [&](double share) {
                                       report.ended =
                                           options.go_on && !options.go_on("frames of the whole picture",
                                                                           share * options.runs, options.runs);
                                       return !report.ended;
                                     },
                                     &first));
  if (report.ended) return {};
  FL_ASSIGN(const CountsRow counts, frame->read_counts());
  FL_ASSIGN(report.lasers.lit, lit_lasers(scene));
  if (counts.live_count == 0 && !other_light(scene).any()) {
    if (report.lasers.lit == 0) {
      const std::string lights = lights_of(scene.rig);
      return fail(ErrorCode::kBadInput,
                  "{}: no beam is lit and no display shines ({}), so no error can be measured; use --log with an --at "
                  "at which one is lit, --lit or --set",
                  scene.name, lights.empty() ? "the rig has neither" : lights + ", all dark");
    }
    report.only_lasers = true;
  }
  report.live_beams = counts.live_count;
  report.shadows = counts.shadows;
  report.shadows_lost = counts.shadows_lost;
  report.whole_ms = percentile(times_ms, 0.5);
  for (const PassTimes& pass : pass_ms) report.whole_passes.push_back({pass.name, percentile(pass.ms, 0.5)});
  FL_ASSIGN(report.bodies, frame->read_bodies());
  for (const PassTime& pass : first) report.gobo_build_ms += pass.name == "gobos" ? pass.gpu_ms : 0;
  FL_ASSIGN(report.gates, frame->read_gates());
  FL_ASSIGN(report.displays, frame->read_display_work());
  report.reflections = options.reflections;
  report.sheen = frame->resources().rig.sheen_count > 0;
  report.body_bytes = static_cast<std::int64_t>(frame->resources().body_bytes());
  whole.view = render::FrameView::kClasses;
  FL_TRY(frame->change(whole));
  FL_TRY(frame->draw(view, scene.camera.exposure_ev));
  FL_ASSIGN(const RadianceImage classes, frame->read_radiance());
  report.classes = class_shares(classes);
  return {};
}

// Root mean square of the differences of two pictures at the pixels where `jagged` and `smooth` differ; counts these.
double steps_between(const ScreenImage& a, const ScreenImage& b, const ScreenImage& jagged, const ScreenImage& smooth,
                     std::int64_t& pixels) {
  pixels = 0;
  double sum = 0;
  for (std::size_t p = 0; p < a.rgba.size(); p += 4) {
    if (std::equal(&jagged.rgba[p], &jagged.rgba[p] + 3, &smooth.rgba[p])) continue;
    ++pixels;
    for (std::size_t c = p; c < p + 3; ++c) sum += (a.rgba[c] - b.rgba[c]) * (a.rgba[c] - b.rgba[c]);
  }
  return std::sqrt(sum / std::max(3.0 * static_cast<double>(pixels), 1.0));
}

// Of the whole frame, but thin beams are left as they are, since their width is in pixels.
Status report_edges(vk::Device& device, const Scene& scene, const View& view, const PictureReportOptions& options,
                    PictureReport& report) {
  constexpr int kSide = 4;
  FrameSettings whole;
  whole.width = options.width;
  whole.height = options.height;
  whole.body_error_px = options.body_error_px;
  whole.shadows = options.shadows;
  whole.shadow_map_px = options.shadow_map_px;
  whole.penumbra = options.penumbra;
  const int runs = std::min(options.runs, 3);  // a CPU takes seconds for each
  if (options.quick || !render::has_smooth_edges(scene.compiled.needs, whole) ||
      std::int64_t{whole.width} * whole.height > kEdgePixelsMax ||
      kSide * std::max(whole.width, whole.height) > static_cast<int>(device.limits().maxImageDimension2D)) {
    return {};
  }
  whole.widen_thin = false;
  FrameSettings fine = whole;
  fine.width *= kSide;
  fine.height *= kSide;
  fine.supersample = kSide;
  fine.body_error_px *= kSide;
  fine.edge_samples = 0;
  ScreenImage reference;
  {
    FL_ASSIGN(const auto frame, make_frame(device, scene, fine));
    FL_TRY(frame->draw(view, scene.camera.exposure_ev));
    FL_ASSIGN(reference, frame->read_screen());
  }
  FL_ASSIGN(const auto frame, make_frame(device, scene, whole));
  std::vector<ScreenImage> pictures;
  for (const std::uint32_t samples : {0u, 4u, 8u, 16u}) {
    whole.edge_samples = samples;
    FL_TRY(frame->change(whole));
    EdgeRow row{.samples = samples};
    std::vector<PassTimes> pass_ms;
    bool ended = false;
    FL_ASSIGN(
        const auto times_ms, time_frames(*frame, view, scene, runs, options.row_seconds, &pass_ms, [&](double share) {
          ended = options.go_on && !options.go_on("smooth edges", static_cast<double>(pictures.size()) + share, 4);
          return !ended;
        }));
    report.ended = ended;
    if (report.ended) return {};
    for (const PassTimes& pass : pass_ms) {
      if (pass.name == "edges") row.ms = percentile(pass.ms, 0.5);
    }
    FL_ASSIGN(pictures.emplace_back(), frame->read_screen());
    row.flip = flip(pictures.back(), reference).mean;
    report.edges.push_back(row);
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    report.edges[i].steps =
        steps_between(pictures[i], reference, pictures.front(), pictures.back(), report.edge_pixels);
  }
  return {};
}

// The error of what shiny surfaces mirror, with the times of the whole frame.
Status report_mirrored(vk::Device& device, const Scene& scene, const View& view, const PictureReportOptions& options,
                       PictureReport& report) {
  if (!options.reflections) return {};
  MirrorOptions mirror{.settings = judged_settings(options), .go_on = {}};
  mirror.judge_pixels = std::max(options.judge_pixels / kMirrorShare, 1);
  if (options.go_on) {
    mirror.go_on = [&](double done) {
      report.ended = !options.go_on("mirrored light", done, 1);
      return !report.ended;
    };
  }
  FL_ASSIGN(report.mirrored, measure_mirrored(device, scene, view, mirror));
  if (!report.mirrored) return {};
  for (const PassTime& pass : report.whole_passes) {
    if (pass.name == "probes") report.mirrored->probes_ms = pass.gpu_ms;
    if (pass.name == "reflections") report.mirrored->reflections_ms = pass.gpu_ms;
  }
  return {};
}

// The row of lasers: times of the frame with them, and the error of their light alone.
Status report_lasers(vk::Device& device, const Scene& scene, const View& view, const PictureReportOptions& options,
                     PictureReport& report) {
  if (report.lasers.lit == 0 || report.ended) return {};
  const auto go_on = [&](double share) {
    report.ended = report.ended || (options.go_on && !options.go_on("lasers", share, 1));
    return !report.ended;
  };
  FrameSettings settings = judged_settings(options);
  settings.widen_thin = true;  // else no laser is drawn
  PictureRow row;
  row.scene = scene.name;
  row.method = "lasers";
  row.knob = settings.tile_error;
  leave_errors_out(row);
  {
    FL_ASSIGN(const auto frame, make_frame(device, scene, settings));
    std::vector<PassTimes> pass_ms;
    FL_ASSIGN(const auto times_ms, time_frames(*frame, view, scene, options.runs, options.row_seconds, &pass_ms,
                                               [&](double share) { return go_on(share / 4); }));
    if (report.ended) return {};
    row.ms_p10 = percentile(times_ms, 0.1);
    row.ms_p50 = percentile(times_ms, 0.5);
    row.ms_p90 = percentile(times_ms, 0.9);
    row.bytes = static_cast<std::int64_t>(frame->bytes());
    for (const PassTimes& pass : pass_ms) {
      if (pass.name == "lasers") row.own_ms = percentile(pass.ms, 0.5);
    }
  }
  if (options.judge) {
    FL_ASSIGN(const auto error,
              measure_lasers(device, scene, view, settings, [&](double share) { return go_on(0.25 + share * 3 / 4); }));
    if (!error) return {};
    report.lasers = *error;
    row.rel_l2 = row.rel_l2_low = row.rel_l2_high = error->norms.rel_l2;
    row.rel_mse = error->norms.rel_mse;
    row.p999 = error->norms.p999;
    row.max = error->norms.max;
    row.nonfinite = error->norms.nonfinite;
  }
  report.rows.push_back(row);
  if (options.on_row) options.on_row(report);
  return {};
}

}  // namespace

Result<PictureReport> make_picture_report(vk::Device& device, const Scene& scene, const PictureReportOptions& options) {
  PictureReport report;
  report.device = fmt::format("{} ({})", device.name(), device.driver());
  const View view = view_of(scene.camera);
  FL_ASSIGN(std::vector<Knob> all_knobs, asked_knobs(options, scene.compiled.needs));
  FL_TRY(measure_whole(device, scene, view, options, report));
  if (report.ended) return report;
  if (report.only_lasers) all_knobs.clear();

  Judged judged;
  if (options.judge) {
    FL_TRY(report_edges(device, scene, view, options, report));
    if (report.ended) return report;
    FL_TRY(report_mirrored(device, scene, view, options, report));
    if (report.ended) return report;
  }
  if (options.judge && !report.only_lasers) {
    const auto start = std::chrono::steady_clock::now();
    FL_ASSIGN(judged, judge_scene_of(device, scene, view, options));
    report.ended = !judged.pixels.whole;
    if (report.ended) return report;
    report.judge_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.judged_pixels = static_cast<std::int64_t>(judged.sample.pixels.size());
    report.judge_own_rel_l2 = judged.pixels.own_rel_l2;
  }

  if (options.on_judged) options.on_judged(report);
  const FrameSettings defaults;
  std::vector<float> without_air, without_surfaces;  // of rivals without a unit; empty: not drawn yet
  const auto fitted = std::count_if(all_knobs.begin(), all_knobs.end(), [&](const Knob& knob) {
    return options.judge && knob.rival != nullptr && !knob.rival->has_unit;
  });
  const auto all_rows = static_cast<double>(all_knobs.size()) + static_cast<double>(fitted);
  // Reports that `share` of the current row is done. Returns true if the report shall end.
  const auto ends_at = [&](double share) {
    report.ended = report.ended ||
                   (options.go_on &&
                    !options.go_on("methods and knobs", static_cast<double>(report.rows.size()) + share, all_rows));
    return report.ended;
  };
  const auto run = [&](const Knob& knob) -> Status {
    const FrameSettings& settings = knob.settings;
    if (ends_at(0)) return {};
    PictureRow row;
    row.scene = scene.name;
    row.method = knob.method;
    row.knob = knob.value;
    row.hits_per_px = judged.hits_per_px;
    leave_errors_out(row);
    FL_ASSIGN(auto frame, make_frame(device, scene, settings, knob.passes));
    std::vector<PassTimes> pass_ms;
    const auto go_on = [&](double share) { return !ends_at(share); };
    FL_ASSIGN(const auto times_ms,
              time_frames(*frame, view, scene, options.runs, options.row_seconds, &pass_ms, go_on));
    if (report.ended) return {};
    row.ms_p10 = percentile(times_ms, 0.1);
    row.ms_p50 = percentile(times_ms, 0.5);
    row.ms_p90 = percentile(times_ms, 0.9);
    row.bytes = static_cast<std::int64_t>(frame->bytes());
    row.own_ms = 0;
    for (const PassTimes& pass : pass_ms) {
      if (is_own(knob, pass.name)) row.own_ms += percentile(pass.ms, 0.5);
    }
    if (settings.tile_error == defaults.tile_error && settings.gobo_taps == defaults.gobo_taps && settings.shadows &&
        settings.shadow_map_px == 0 && settings.penumbra == options.penumbra) {
      report.passes.clear();
      for (const PassTimes& pass : pass_ms) report.passes.push_back({pass.name, percentile(pass.ms, 0.5)});
    }
    if (options.judge) FL_TRY(judge_row(*frame, judged, row));
    report.rows.push_back(row);
    if (options.on_row) options.on_row(report);
    if (!options.judge || knob.rival == nullptr || knob.rival->has_unit) return {};
    std::vector<float>& without = knob.rival->on_surfaces ? without_surfaces : without_air;
    if (without.empty()) {
      FL_ASSIGN(without, sample_without(device, scene, view, options, *knob.rival, judged));
    }
    FL_TRY(fit_row(*frame, judged, without, scene.camera.exposure_ev, row));
    row.method += ", fitted";
    report.rows.push_back(row);
    if (options.on_row) options.on_row(report);
    return {};
  };
  for (const Knob& knob : all_knobs) FL_TRY(run(knob));
  FL_TRY(report_lasers(device, scene, view, options, report));
  report.validation_messages = device.validation_messages();
  return report;
}

}  // namespace footlight::tools
