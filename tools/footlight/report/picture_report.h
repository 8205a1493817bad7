// Error against run time of pictures: GPU methods over their knobs, against the judge.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "render/frame.h"
#include "render/reference/judge.h"
#include "render/reference/report.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

struct PictureReport;

// Chosen between time and the width of the interval. A drawn pixel takes 3 times as long as an evenly spread one, since
// bright ones and edges are drawn more often (the demo at 30 s; docs/numerics.md).
inline constexpr int kJudgePixels = 1500;

struct PictureReportOptions {
  int width = 640;  // of the frames that are timed and judged
  int height = 360;
  // So many of their pixels are judged, since the judge is slow: a sample as render/reference/pixel_sample.h draws it,
  // or all where there are no more.
  int judge_pixels = kJudgePixels;
  int runs = 11;  // timed frames, after 3 that are not
  std::vector<std::uint32_t> gauss_nodes{1, 2, 3, 4, 6, 8};
  std::vector<std::uint32_t> march_steps{8, 16, 32, 64, 128, 256};
  std::vector<std::uint32_t> gobo_taps{8, 16, 32, 64, 128};  // with the default nodes; for rigs with gobos only
  bool judge = true;                                         // false: only times
  // Optional. When the judge is done, and after each row: the last of report.rows.
  std::function<void(const PictureReport&report)> on_judged, on_row;
  // Optional. Called between parts; false ends the report with the rows so far.
  std::function<bool(std::string_view what, double done, double all)> go_on;
};

struct PictureReport {
  std::vector<render::PictureRow> rows;
  std::int64_t judged_pixels = 0;
  double judge_own_rel_l2 = 0;  // the judge's stated error
  double judge_seconds = 0;
  std::vector<render::PassTime> passes;  // median GPU time of each pass with the default method
  double whole_ms = 0;                   // median of a frame as `footlight render` draws it, bodies and all
  std::string device;
  std::vector<std::string> validation_messages;
  bool ended = false;  // by go_on
};

// The value of which `share` (0 to 1) are not above it, to the nearest of `values`; there is at least one.
[[nodiscard]] double percentile(std::vector<double> values, double share);

// Times and judges the same frames: without bodies and lenses, and with thin beams as thin as they are, since the judge
// knows neither. kBadInput where no beam of the scene is lit, since errors of a black picture say nothing.
[[nodiscard]] Result<PictureReport> make_picture_report(render::vk::Device& device, const Scene& scene,
                                                        const PictureReportOptions& options);

}  // namespace footlight::tools
