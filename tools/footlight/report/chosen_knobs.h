// The report's section on --error and --ms: the knobs that this machine's curves choose, predicted and measured.
#pragma once

#include <optional>
#include <string>

#include "render/quality.h"
#include "tools/footlight/pictures/knob_curves.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

struct ChosenKnobs {
  render::QualityRequest request;
  render::KnobPoint predicted;  // by the curves; the time as the scene's frame with the default knobs takes it
  double error = 0;             // measured against the general path, all pixels of a frame without bodies
  double ms = 0;                // measured, the whole frame, bodies and lenses included
  // For an error: what `footlight render` takes for it, and its error and time.
  std::optional<render::KnobPoint> fixed;
  // From the judge's row, where there is one.
  double judged = 0;
  double judged_low = 0;
  double judged_high = 0;
};

// runs: timed frames.
[[nodiscard]] Result<ChosenKnobs> choose_for(render::vk::Device& device, const Scene& scene,
                                             const render::KnobCurves& curves, const render::QualityRequest& request,
                                             int width, int height, int runs);
[[nodiscard]] std::string text_of(const ChosenKnobs& chosen);
[[nodiscard]] std::string json_of(const ChosenKnobs& chosen);

}  // namespace footlight::tools
