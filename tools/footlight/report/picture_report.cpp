#include "tools/footlight/report/picture_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "fixtures/gobos/gobo.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/simulate/walker.h"
#include "render/reference/norms.h"

namespace footlight::tools {

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

namespace {

using namespace render;

Result<std::unique_ptr<Frame>> make_frame(vk::Device& device, const Scene& scene, const FrameSettings& settings) {
  FL_ASSIGN(auto frame, Frame::create(device, scene.rig, scene.compiled, settings));
  frame->step(scene.levels, 0);
  return frame;
}

// Texels of an image, between which the judge interpolates as the GPU does.
struct Texels {
  int size = 0;
  std::vector<float> rgb;

  [[nodiscard]] glm::dvec3 at(int column, int row) const {
    const int x = std::clamp(column, 0, size - 1);
    const int y = std::clamp(row, 0, size - 1);
    const float* texel =
        &rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x))];
    return {texel[0], texel[1], texel[2]};
  }
  // x, y: -1 to 1.
  [[nodiscard]] glm::dvec3 through(double x, double y) const {
    const double column = (0.5 * x + 0.5) * size - 0.5;
    const double row = (0.5 * y + 0.5) * size - 0.5;
    const double left = std::floor(column);
    const double top = std::floor(row);
    const int i = static_cast<int>(left);
    const int j = static_cast<int>(top);
    return glm::mix(glm::mix(at(i, j), at(i + 1, j), column - left),
                    glm::mix(at(i, j + 1), at(i + 1, j + 1), column - left), row - top);
  }
};

// The images of the rig, in the order of its layers: our own by their formulas, others by their texels.
GoboColors gobos_of(const fixtures::CompiledRig& compiled) {
  struct Layer {
    int builtin = 0;
    Texels texels;
  };
  std::vector<Layer> layers;
  for (const fixtures::ImageSource& image : compiled.images) {
    Layer layer;
    for (int gobo = 1; gobo <= fixtures::kGoboCount; ++gobo) {
      if (image.name == std::string(fixtures::kBuiltinImage) + fixtures::gobo_name(gobo)) layer.builtin = gobo;
    }
    if (layer.builtin == 0) {
      auto texels = fixtures::gobo_texels(image, kGoboSizePx, kGoboEdge);
      layer.texels = {kGoboSizePx,
                      texels ? std::move(*texels) : fixtures::stand_in_texels(layers.size(), kGoboSizePx, kGoboEdge)};
    }
    layers.push_back(std::move(layer));
  }
  const auto shared = std::make_shared<const std::vector<Layer>>(std::move(layers));  // the judge copies the function
  return [shared](int layer, double x, double y) {
    const Layer& one = shared->at(static_cast<std::size_t>(layer - 1));
    return one.builtin > 0 ? glm::dvec3(fixtures::gobo_transmission(one.builtin, x, y, kGoboEdge))
                           : one.texels.through(x, y);
  };
}

bool only_builtin(const fixtures::CompiledRig& compiled) {
  return std::all_of(compiled.images.begin(), compiled.images.end(), [](const fixtures::ImageSource& image) {
    return image.name.starts_with(fixtures::kBuiltinImage);
  });
}

// Times of `runs` frames after 3 that are not counted; `pass_ms`: of each pass, where it is asked for. `go_on` gets the
// share that is done before each frame, and ends the timing early when it returns false.
Result<std::vector<double>> time_frames(Frame& frame, const View& view, const Scene& scene, int runs,
                                        std::vector<std::vector<double>>* pass_ms,
                                        const std::function<bool(double)>& go_on) {
  std::vector<double> times_ms;
  if (pass_ms != nullptr) pass_ms->assign(frame.plan().size(), {});
  for (int i = -3; i < runs; ++i) {
    if (!go_on((i + 3.0) / (runs + 4.0))) break;
    FL_TRY(frame.draw(view, scene.camera.exposure_ev));
    FL_ASSIGN(const auto passes, frame.read_times());
    if (i < 0) continue;
    double total_ms = 0;
    for (std::size_t p = 0; p < passes.size(); ++p) {
      total_ms += passes[p].gpu_ms;
      if (pass_ms != nullptr) (*pass_ms)[p].push_back(passes[p].gpu_ms);
    }
    times_ms.push_back(total_ms);
  }
  return times_ms;
}

// The judged pixels of a timed frame, `values` a pixel.
template <class T>
std::vector<T> sampled(const std::vector<T>& pixels, std::size_t values, const PictureReportOptions& options) {
  std::vector<T> sample;
  for (int y = 0; y < options.judge_height; ++y) {
    for (int x = 0; x < options.judge_width; ++x) {
      const int row = sampled_pixel(y, options.judge_height, options.height);
      const int column = sampled_pixel(x, options.judge_width, options.width);
      const std::size_t at =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(options.width) + static_cast<std::size_t>(column);
      for (std::size_t i = 0; i < values; ++i) sample.push_back(pixels[at * values + i]);
    }
  }
  return sample;
}

JudgedImage judge_scene_of(const Scene& scene, const View& view, const PictureReportOptions& options) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const GoboColors gobos = gobos_of(scene.compiled);
  JudgeScene judge =
      judge_scene(scene.rig, walker, [gobos](int gobo, double x, double y) { return gobos(gobo, x, y).x; });
  if (!only_builtin(scene.compiled)) judge.colors = gobos;
  JudgeOptions judge_options{.of_width = options.width, .of_height = options.height};
  if (options.go_on) {
    judge_options.go_on = [&](int done, int all) { return options.go_on("lines of the judge's picture", done, all); };
  }
  return judge_image(judge, view, options.judge_width, options.judge_height, judge_options);
}

Status judge_row(Frame& frame, const JudgedImage& judged, const ScreenImage& judged_screen,
                 const PictureReportOptions& options, PictureRow& row) {
  FL_ASSIGN(const RadianceImage picture, frame.read_radiance());
  const PictureNorms norms = picture_norms(sampled(picture.rgb, 3, options), judged.rgb);
  row.rel_l2 = norms.rel_l2;
  row.rel_mse = norms.rel_mse;
  row.p999 = norms.p999;
  row.max = norms.max;
  row.nonfinite = norms.nonfinite;
  FL_ASSIGN(const ScreenImage screen, frame.read_screen());
  const ScreenImage shown{options.judge_width, options.judge_height, sampled(screen.rgba, 4, options)};
  row.flip = flip(shown, judged_screen).mean;
  return {};
}

}  // namespace

Result<PictureReport> make_picture_report(vk::Device& device, const Scene& scene, const PictureReportOptions& given) {
  PictureReportOptions options = given;
  options.judge_width = std::min(options.judge_width, options.width);
  options.judge_height = std::min(options.judge_height, options.height);
  PictureReport report;
  report.device = fmt::format("{} ({})", device.name(), device.driver());
  const View view = view_of(scene.camera);
  {
    FrameSettings whole;
    whole.width = options.width;
    whole.height = options.height;
    FL_ASSIGN(auto frame, make_frame(device, scene, whole));
    FL_ASSIGN(const auto times_ms, time_frames(*frame, view, scene, options.runs, nullptr, [&](double share) {
                report.ended =
                    options.go_on && !options.go_on("frames of the whole picture", share * options.runs, options.runs);
                return !report.ended;
              }));
    if (report.ended) return report;
    FL_ASSIGN(const CountsRow counts, frame->read_counts());
    if (counts.live_count == 0) {
      return fail(
          ErrorCode::kBadInput,
          "{}: no beam is lit, so there is nothing to judge; expected --log with --at at a lit moment, --lit, or "
          "--set",
          scene.name);
    }
    report.whole_ms = percentile(times_ms, 0.5);
  }

  JudgedImage judged;
  ScreenImage judged_screen;
  if (options.judge) {
    const auto start = std::chrono::steady_clock::now();
    judged = judge_scene_of(scene, view, options);
    report.ended = !judged.whole;
    if (report.ended) return report;
    report.judge_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.judge_own_rel_l2 = judged.own_rel_l2;
    judged_screen = screen_of(judged.image, scene.camera.exposure_ev);
  }

  if (options.on_judged) options.on_judged(report);
  const FrameSettings defaults;
  const auto all_rows = static_cast<double>(options.gauss_nodes.size() + options.march_steps.size() +
                                            (scene.compiled.needs.gobo ? options.gobo_taps.size() : 0));
  // `share` of the row that is being measured is done. True: there shall be no more of it.
  const auto ends_at = [&](double share) {
    report.ended = report.ended ||
                   (options.go_on &&
                    !options.go_on("methods and knobs", static_cast<double>(report.rows.size()) + share, all_rows));
    return report.ended;
  };
  const auto run = [&](const std::string& name, BeamMethod method, std::uint32_t nodes,
                       std::uint32_t gobo_taps = FrameSettings{}.gobo_taps) -> Status {
    if (ends_at(0)) return {};
    PictureRow row;
    row.scene = scene.name;
    row.method = name;
    row.knob = name == "gobo taps" ? gobo_taps : nodes;
    row.hits_per_px = judged.hits_per_px;
    FrameSettings settings;
    settings.width = options.width;
    settings.height = options.height;
    settings.method = method;
    settings.nodes = nodes;
    settings.gobo_taps = gobo_taps;
    settings.bodies = false;
    settings.widen_thin = false;
    FL_ASSIGN(auto frame, make_frame(device, scene, settings));
    std::vector<std::vector<double>> pass_ms;
    const auto go_on = [&](double share) { return !ends_at(share); };
    FL_ASSIGN(const auto times_ms, time_frames(*frame, view, scene, options.runs, &pass_ms, go_on));
    if (report.ended) return {};
    row.ms_p10 = percentile(times_ms, 0.1);
    row.ms_p50 = percentile(times_ms, 0.5);
    row.ms_p90 = percentile(times_ms, 0.9);
    row.bytes = static_cast<std::int64_t>(frame->resources().total_bytes);
    if (method == defaults.method && nodes == defaults.nodes && gobo_taps == defaults.gobo_taps) {
      report.passes.clear();
      for (std::size_t p = 0; p < pass_ms.size(); ++p) {
        report.passes.push_back({frame->plan()[p].name, percentile(pass_ms[p], 0.5)});
      }
    }
    if (options.judge) FL_TRY(judge_row(*frame, judged, judged_screen, options, row));
    report.rows.push_back(row);
    if (options.on_row) options.on_row(report);
    return {};
  };
  for (const std::uint32_t nodes : options.gauss_nodes) FL_TRY(run("gauss", BeamMethod::kGauss, nodes));
  for (const std::uint32_t steps : options.march_steps) FL_TRY(run("march", BeamMethod::kMarch, steps));
  if (scene.compiled.needs.gobo) {
    for (const std::uint32_t taps : options.gobo_taps)
      FL_TRY(run("gobo taps", BeamMethod::kGauss, defaults.nodes, taps));
  }
  report.validation_messages = device.validation_messages();
  return report;
}

}  // namespace footlight::tools
