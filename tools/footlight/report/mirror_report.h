// How wrong the light is that shiny surfaces mirror by reflection probes: against rays of the judge.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "render/frame.h"
#include "render/quality.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

// Rays of each place that is judged. The same with half of them says how wrong the judge is.
inline constexpr int kMirrorRays = 64;
// One place is judged where this many pixels of the picture are. A place takes kMirrorRays rays, so fewer are judged.
inline constexpr int kMirrorShare = 10;

struct MirrorOptions {
  render::FrameSettings settings;  // of the picture; its bodies, bounce and probes are on
  int judge_pixels = 150;          // of pixels that mirror; more are a sample of so many
  // Optional. Called with the share that is done; false ends the measurement without a row.
  std::function<bool(double done)> go_on;
};

// Light that surfaces with sheen mirror, as far as probes show it: the picture minus the same without probes, at the
// pixels that show boxes, scenery or objects with sheen and no body of a fixture.
struct MirrorRow {
  std::int64_t pixels = 0;  // that show such surfaces
  std::int64_t judged = 0;  // of these
  double rel_l2 = 0;        // of the mirrored light
  // 95 % confidence interval of rel_l2 if only a sample of them is judged; else equal to rel_l2
  double rel_l2_low = 0;
  double rel_l2_high = 0;
  double own_rel_l2 = 0;      // of the judge: half its rays against all
  double picture_rel_l2 = 0;  // the same error over all light of these pixels
  double sum = 0;             // of the mirrored light over that of the judge
  double probes_ms = 0;       // of the whole frame: the maps
  double reflections_ms = 0;  // and looking them up
};

// Empty: nothing in the picture mirrors, or go_on ended it. The times are left 0. The row is the same in each run on
// one device.
[[nodiscard]] Result<std::optional<MirrorRow>> measure_mirrored(render::vk::Device& device, const Scene& scene,
                                                                const render::View& view,
                                                                const MirrorOptions& options);

[[nodiscard]] std::string text_of(const MirrorRow& row, std::int64_t pixels);  // pixels: of the picture
[[nodiscard]] std::string json_of(const MirrorRow& row);                       // one line

}  // namespace footlight::tools
