// Error against run time of pictures: GPU methods at several knobs, compared with the judge.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/frame.h"
#include "render/quality.h"
#include "render/reference/judge.h"
#include "render/reference/report.h"
#include "tools/footlight/pictures/shown_view.h"
#include "tools/footlight/report/laser_report.h"
#include "tools/footlight/report/mirror_report.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

struct PictureReport;

// A compromise between time and the width of the interval. A sampled pixel takes 3 times as long as an evenly spread
// one, because bright pixels and edges are sampled more often (the demo at 30 s; docs/numerics.md).
inline constexpr int kJudgePixels = 1500;

// Places of each lens from which the judge casts shadows with soft edges.
inline constexpr int kJudgeLens = 96;

struct PictureReportOptions {
  int width = 640;  // of the frames that are timed and compared
  int height = 360;
  // The number of pixels that the judge computes, because it is slow. They are a sample
  // (render/reference/pixel_sample.h), or all pixels if the picture has no more.
  int judge_pixels = kJudgePixels;
  int runs = 11;                                            // timed frames, after 3 warm-up frames
  std::vector<double> tile_errors{3e-4, 1e-3, 4e-3, 2e-2};  // FrameSettings::tile_error
  std::vector<std::uint32_t> gauss_nodes{1, 2, 3, 4, 6, 8};
  std::vector<std::uint32_t> march_steps{8, 16, 32, 64, 128, 256};
  std::vector<std::uint32_t> gobo_taps{8, 16, 32, 64, 128};  // with the default nodes; for rigs with gobos only
  double body_error_px = 0.5;                                // FrameSettings::body_error_px, of the whole frame
  bool shadows = true;                                       // the same two, of the whole frame
  std::uint32_t shadow_map_px = render::kShadowsSuited;
  // FrameSettings::penumbra of all rows. Above 1 the judge's lenses shine from kJudgeLens places each.
  std::uint32_t penumbra = 1;
  bool reflections = false;  // FrameSettings::bounce and probes, of the whole frame; with probes a row of their error
  std::optional<render::Knobs> chosen;                       // a row of its own, "chosen", the first one
  bool judge = true;                                         // false: only times are measured
  bool rivals = false;                                       // rows of the methods of render/rivals
  bool quick = false;                                        // of those, quick_knobs
  // Only rows whose method begins with one of these words, which commas part; empty: all rows.
  std::string methods;
  double row_seconds = 1e9;  // a row takes no more frames after that time, but at least three
  // Optional. on_judged is called when the judge is done, on_row after each row, which is the last of report.rows.
  std::function<void(const PictureReport&report)> on_judged, on_row;
  // Optional. Called between parts; false ends the report with the rows so far.
  std::function<bool(std::string_view what, double done, double all)> go_on;
};

// How far edges of solid things in the whole frame are from those of the same frame with 4 x 4 pixels for one.
struct EdgeRow {
  std::uint32_t samples = 0;  // FrameSettings::edge_samples; 0: jagged
  double ms = 0;              // median GPU time of the pass
  double steps = 0;  // root mean square of the error on the screen, of 255 steps, at the pixels that edges change
  double flip = 0;   // mean FLIP of the whole picture
};

// Larger frames are not compared: their reference has 16 times as many pixels.
inline constexpr std::int64_t kEdgePixelsMax = 1'100'000;

struct PictureReport {
  std::vector<render::PictureRow> rows;
  std::int64_t judged_pixels = 0;
  double judge_own_rel_l2 = 0;  // the judge's own error
  double judge_seconds = 0;
  std::vector<render::PassTime> passes;        // median GPU time of each pass with the default method
  double whole_ms = 0;                         // median time of a frame as `footlight render` draws it, with bodies
  std::vector<render::PassTime> whole_passes;  // median GPU time of each of its passes
  render::BodyCounts bodies;                   // that it draws
  std::vector<EdgeRow> edges;                  // jagged, then each number of samples; empty: not measured
  std::int64_t edge_pixels = 0;                // that 16 samples change
  std::int64_t body_bytes = 0;                 // memory of its bodies and objects
  render::GatesHead gates{};                   // of the whole frame; 0 where gobos are sampled
  std::uint32_t live_beams = 0;                // that it draws
  std::uint32_t shadows = 0;                   // pairs of a beam and what hides some of its light
  std::uint32_t shadows_lost = 0;              // of them, for want of room
  render::DisplayWork displays;                // of the whole frame
  std::optional<MirrorRow> mirrored;           // empty: not judged, or nothing in the picture mirrors
  LaserError lasers;                           // of the row of lasers; without a judge only how many are lit
  bool only_lasers = false;                    // nothing else is lit: there are no rows of beams
  double gobo_build_ms = 0;                    // GPU time of the pass of gobos in its first frame
  ClassShares classes;                         // how its beams are computed
  std::string device;
  std::vector<std::string> validation_messages;
  bool reflections = false;  // PictureReportOptions::reflections
  bool sheen = false;        // something is not matt, the files of meshes included
  bool ended = false;        // go_on ended it
};

// Returns the quantile at `share` (0 to 1), the nearest of `values`, which must not be empty.
[[nodiscard]] double percentile(std::vector<double> values, double share);

// Times and compares the same frames. They have no bodies, no lenses and no widening of thin beams, because the judge
// computes none of these. Lit lasers have a row of their own, the last one. kBadInput if neither a beam nor a laser of
// the scene is lit, because the error of a black picture has no meaning, and if no row has one of `methods`.
[[nodiscard]] Result<PictureReport> make_picture_report(render::vk::Device& device, const Scene& scene,
                                                        const PictureReportOptions& options);

}  // namespace footlight::tools
