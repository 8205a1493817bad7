// How wrong the light of scanned lasers is: against brute force over the paths of the scanners.
#pragma once

#include <functional>
#include <optional>

#include "render/frame.h"
#include "render/reference/norms.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

// Width of the picture that is judged: the time of the judge grows with the square of it.
inline constexpr int kLaserJudgePx = 96;

// The picture with lasers minus the same without, in even haze and without plumes, which the judge knows nothing of.
struct LaserError {
  render::PictureNorms norms;
  double own_rel_l2 = 0;  // of the judge: pieces of twice the length against its own
  int lit = 0;            // lasers that are lit
  int width = 0, height = 0;
};

// How many lasers of the scene are lit.
[[nodiscard]] Result<int> lit_lasers(const Scene& scene);

// `settings`: of the picture, whose shape the smaller one that is judged has. go_on is optional and gets the share that
// is done; false ends the measurement. Empty: no laser is lit, or go_on ended it.
[[nodiscard]] Result<std::optional<LaserError>> measure_lasers(render::vk::Device& device, const Scene& scene,
                                                               const render::View& view,
                                                               const render::FrameSettings& settings,
                                                               const std::function<bool(double done)>& go_on);

}  // namespace footlight::tools
