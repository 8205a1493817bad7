// Generated scenes that differ in one property, for the report's curves of cost.
#pragma once

#include <string>
#include <vector>

#include "tools/footlight/report/picture_report.h"

namespace footlight::tools {

// A property of the scene and its values.
struct Sweep {
  enum class Of { kBeams, kPixels, kGobos, kClutter };
  Of of = Of::kBeams;
  std::vector<double> values;
};

// Reads "beams=100,1000", "pixels=230400" (16 : 9), "gobos=0,50" (per cent of the beams that have one) or
// "clutter=0,100" (boxes).
[[nodiscard]] Result<Sweep> parse_sweep(const std::string& text);

// What its values are, for the axis of a plot.
[[nodiscard]] const char* axis_of(const Sweep& sweep);

// The scene at one value; the other properties are as given. Sets the size of the pictures if that is swept.
struct SweepScene {
  int beams = 1000;
  double gobo_share = 0;
  int clutter = 0;
  int wheels = 1;  // with gobos on each
};
[[nodiscard]] Result<Scene> scene_of_sweep(const Sweep& sweep, double value, const SweepScene& scene,
                                           PictureReportOptions& options);

}  // namespace footlight::tools
