#include "tools/footlight/report/chosen_knobs.h"

namespace footlight::tools {

using render::FrameSettings;

Result<ChosenKnobs> choose_for(render::vk::Device& device, const Scene& scene, const render::KnobCurves& curves,
                               const render::QualityRequest& request, int width, int height, int runs) {
  const std::vector<render::KnobPoint> ladder = render::ladder_of(curves, scene.compiled.needs, request);
  if (ladder.empty()) return fail(ErrorCode::kUnsupported, "no curves of knobs: nothing can be chosen");
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  FrameSettings all = settings;
  all.edge_samples = render::suited_edge_samples(device);
  all.bounce = all.probes = true;
  all.shadow_map_px = render::window_map_px(device);
  FL_ASSIGN(KnobBench whole, KnobBench::make(device, scene, all));
  settings.bodies = false;
  FL_ASSIGN(KnobBench light, KnobBench::make(device, scene, settings));
  const auto ms_of = [&](const render::Knobs& knobs) -> Result<double> {
    FL_TRY(whole.ms_of(knobs, 1));
    return whole.ms_of(knobs, runs);
  };
  const render::Knobs usual;
  FL_ASSIGN(const double usual_ms, ms_of(usual));
  const auto usual_point = render::predicted(curves, scene.compiled.needs, usual);
  const double scale = usual_point ? usual_ms / usual_point->ms : 1;
  ChosenKnobs chosen;
  chosen.request = request;
  std::size_t at = render::choose(ladder, request, scale);
  chosen.predicted = ladder[at];
  chosen.predicted.ms *= scale;
  FL_ASSIGN(chosen.ms, ms_of(chosen.predicted.knobs));
  // As the preview, which goes on from the time that a picture took.
  while (request.ms > 0 && chosen.ms > request.ms && at + 1 < ladder.size()) {
    const double own_scale = chosen.ms / ladder[at].ms;
    do {
      ++at;
    } while (at + 1 < ladder.size() && own_scale * ladder[at].ms > request.ms);
    chosen.predicted = ladder[at];
    chosen.predicted.ms *= own_scale;
    FL_ASSIGN(chosen.ms, ms_of(chosen.predicted.knobs));
  }
  // Of beams, as the predicted one: what is left out has none.
  FL_ASSIGN(chosen.error, light.error_of(render::with_everything(chosen.predicted.knobs)));
  if (!(request.error > 0)) return chosen;
  if (const auto fixed = render::fixed_knobs(request.error)) {
    chosen.fixed = *fixed;
    FL_ASSIGN(chosen.fixed->ms, ms_of(fixed->knobs));
    FL_ASSIGN(chosen.fixed->error, light.error_of(fixed->knobs));
  }
  return chosen;
}

std::string text_of(const ChosenKnobs& chosen) {
  const bool by_error = chosen.request.error > 0;
  std::string text = fmt::format("Knobs chosen for {}: {}.\n{:<30}{:>11}{:>11}\n{:<30}{:>11.1e}{:>11.1e}\n",
                                 by_error ? fmt::format("an error of {:g} %", 100 * chosen.request.error)
                                          : fmt::format("{:g} ms", chosen.request.ms),
                                 render::text_of(chosen.predicted.knobs), "", "predicted", "measured",
                                 "error, general path", chosen.predicted.error, chosen.error);
  if (chosen.judged > 0) {
    text += fmt::format("{:<30}{:>11}{:>11.1e}  ({:.1e} to {:.1e})\n", "error, judge", "", chosen.judged,
                        chosen.judged_low, chosen.judged_high);
  }
  text += fmt::format("{:<30}{:>11.3f}{:>11.3f}\n", "whole frame, ms", chosen.predicted.ms, chosen.ms);
  if (by_error && chosen.predicted.error > chosen.request.error) text += "No knobs have so small an error.\n";
  if (!by_error && chosen.ms > chosen.request.ms) text += "No knobs take so little time.\n";
  if (chosen.fixed) {
    text += fmt::format("'footlight render' takes the same on every machine: {}; measured {:.1e} and {:.3f} ms.\n",
                        render::text_of(chosen.fixed->knobs), chosen.fixed->error, chosen.fixed->ms);
  }
  return text + "\n";
}

std::string json_of(const ChosenKnobs& chosen) {
  const render::Knobs& knobs = chosen.predicted.knobs;
  return fmt::format(
      R"({{"event":"chosen","error":{},"ms":{},"tile_error":{},"nodes":{},"gobo_tables":{},"gobo_taps":{},)"
      R"("body_error_px":{},"smooth_edges":{},"bounce":{},"shadows":{},"divisor":{},)"
      R"("predicted_error":{:.4g},"measured_error":{:.4g},"predicted_ms":{:.4f},"measured_ms":{:.4f}}})"
      "\n",
      chosen.request.error, chosen.request.ms, knobs.tile_error, knobs.nodes,
      knobs.gobo_method == render::GoboMethod::kTables, knobs.gobo_taps, knobs.body_error_px, knobs.smooth_edges,
      knobs.bounce, knobs.shadows, knobs.divisor, chosen.predicted.error, chosen.error, chosen.predicted.ms, chosen.ms);
}

}  // namespace footlight::tools
