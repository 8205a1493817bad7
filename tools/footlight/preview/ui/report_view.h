// What the report panel shows of the picture, and what its plot is made of. Plain data: the loop of the preview fills
// it in (preview_report.cpp). No Dear ImGui.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/frame.h"
#include "render/live_error.h"
#include "render/memory_groups.h"
#include "render/quality.h"
#include "tools/footlight/report/left_out.h"

namespace footlight::tools {

// GPU times of the passes of the last pictures.
class PassHistory {
 public:
  static constexpr std::size_t kPicturesMax = 120;

  struct Row {
    std::string name;
    std::vector<float> ms;  // the oldest first, at most kPicturesMax; 0 in pictures without the pass
    [[nodiscard]] double last_ms() const { return ms.empty() ? 0 : static_cast<double>(ms.back()); }
    [[nodiscard]] double median_ms() const;
    [[nodiscard]] double most_ms() const;
  };

  // Of one picture. A pass that none of the pictures has any more is forgotten.
  void add(std::span<const render::PassTime> passes);
  // In the order of the passes. Each has as many times as there are pictures.
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  [[nodiscard]] std::size_t pictures() const { return pictures_; }
  // Of all passes together.
  [[nodiscard]] Row total() const;

 private:
  std::vector<Row> rows_;
  std::size_t pictures_ = 0;
};

struct ReportView {
  // What is.
  std::uint64_t picture = 0;  // counts them; the data below are those of the last one
  std::vector<render::PassTime> passes;
  double picture_ms = 0;  // of the GPU; by the clock where it has no time stamps
  std::uint64_t bytes = 0;
  std::vector<render::MemoryGroup> memory;  // their sum is `bytes`
  bool has_left_out = false;                // else it is being computed
  LeftOutPlan left_out;
  render::ErrorWindow::Estimate error;
  render::QualityRequest target;             // --error or --ms; nothing: the user chooses
  std::vector<render::KnobPoint> ladder;     // what is chosen from, from the least error on; empty: not measured
  std::optional<render::KnobPoint> present;  // what the curves say of the knobs of the picture; nothing: they do not
  bool measures = false;                     // the curves, now
  std::string why_not_measure;               // empty: they can be measured

  // What the user asks for; the loop carries it out and resets it.
  bool measure = false;
};

// A diagram of error against time with logarithmic axes: x from 0 at the left to 1 at the right, y from 0 at the bottom
// to 1 at the top. The limits are powers of 10.
struct ErrorPlot {
  struct Point {
    float x = 0;
    float y = 0;
  };
  struct Knob {
    Point at;
    render::KnobPoint point;  // its time is that of this picture
  };
  struct Tick {
    float at = 0;
    std::string text;
  };
  std::vector<Knob> curve;        // in the order of the ladder
  std::optional<Point> present;   // what the curves say of the present setting
  std::optional<Point> measured;  // the error at samples of the last pictures, and their time
  float measured_low = 0;         // y of its interval
  float measured_high = 0;
  std::optional<float> target_x;  // the time that is asked for
  std::optional<float> target_y;  // the error that is asked for
  std::vector<Tick> ticks_x;      // ms
  std::vector<Tick> ticks_y;      // error
  // The times of the curve are those on the scenes that it was measured on, times this: then the present setting takes
  // as long as the picture does. 1 where the present setting is not on the curve.
  double scale = 1;
};
// Nothing where there is no curve.
[[nodiscard]] std::optional<ErrorPlot> plot_of(const ReportView& view);

// "0.032 %": an error as a share.
[[nodiscard]] std::string share_text(double share);
// About three digits.
[[nodiscard]] std::string ms_text(double ms);

}  // namespace footlight::tools
