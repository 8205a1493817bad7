#include "tools/footlight/picture_report.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "fixtures/gobo.h"
#include "fixtures/walker.h"
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

}  // namespace

Result<PictureReport> make_picture_report(vk::Device& device, const Scene& scene, const PictureReportOptions& options) {
  PictureReport report;
  report.device = fmt::format("{} ({})", device.name(), device.driver());
  const View view = view_of(scene.camera);

  JudgedImage judged;
  ScreenImage judged_screen;
  if (options.judge) {
    fixtures::f64::Walker walker(scene.compiled);
    walker.step(scene.levels, 0);
    const JudgeScene judge = judge_scene(scene.rig, walker, [](int gobo, double x, double y) {
      return fixtures::gobo_transmission(gobo, x, y, kGoboEdge);
    });
    const auto start = std::chrono::steady_clock::now();
    JudgeOptions judge_options;
    if (options.go_on) {
      judge_options.go_on = [&](int done, int all) { return options.go_on("lines of the judge's picture", done, all); };
    }
    judged = judge_image(judge, view, options.judge_width, options.judge_height, judge_options);
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
    settings.dark_lm = 0;
    {
      FL_ASSIGN(auto frame, make_frame(device, scene, settings));
      std::vector<double> times_ms;
      std::vector<std::vector<double>> pass_ms(frame->plan().size());
      for (int i = -3; i < options.runs; ++i) {
        if (ends_at((i + 3.0) / (options.runs + 4.0))) return {};
        FL_TRY(frame->draw(view, scene.camera.exposure_ev));
        FL_ASSIGN(const auto passes, frame->read_times());
        if (i < 0) continue;
        double total_ms = 0;
        for (std::size_t p = 0; p < passes.size(); ++p) {
          total_ms += passes[p].gpu_ms;
          pass_ms[p].push_back(passes[p].gpu_ms);
        }
        times_ms.push_back(total_ms);
      }
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
    }
    if (options.judge) {
      settings.width = options.judge_width;
      settings.height = options.judge_height;
      FL_ASSIGN(auto frame, make_frame(device, scene, settings));
      FL_TRY(frame->draw(view, scene.camera.exposure_ev));
      FL_ASSIGN(const RadianceImage picture, frame->read_radiance());
      FL_ASSIGN(const ScreenImage screen, frame->read_screen());
      const PictureNorms norms = picture_norms(picture.rgb, judged.rgb);
      row.rel_l2 = norms.rel_l2;
      row.rel_mse = norms.rel_mse;
      row.p999 = norms.p999;
      row.max = norms.max;
      row.nonfinite = norms.nonfinite;
      row.flip = flip(screen, judged_screen).mean;
    }
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
