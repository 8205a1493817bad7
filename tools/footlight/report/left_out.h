// The features and passes that a frame leaves out because the rig does not need them, and the GPU time and memory that
// each would cost.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/frame.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

struct LeftOutOptions {
  render::FrameSettings settings{.width = 640, .height = 360};
  int runs = 11;  // pairs of timed frames per row, after one uncounted pair; 0: only bytes
  // Optional. Called between rows; false ends the measurement with the rows so far.
  std::function<bool(double done, double all)> go_on;
};

// The cost of one feature or pass that is left out. Each time is a difference: the frame with it minus the frame
// without it, drawn in turn, over the passes that it adds or changes. Each frame takes one step of 20 ms.
struct LeftOutRow {
  std::string name;  // of the pass or the need
  std::string text;  // what the rig or the picture lacks
  bool pass = false;
  bool on_gpu = true;  // false: no shader, buffer or image depends on it, so nothing is measured
  std::uint64_t bytes = 0;
  struct Times {
    double ms_p10 = 0;
    double ms_p50 = 0;
    double ms_p90 = 0;
  };
  std::optional<Times> times;  // empty: not timed
};

// Returns passes first, in the order of footlight::render::left_out_passes(), then needs, in the order of
// fixtures::features(). The time of a pass is its GPU time in the frame of the need that adds it.
[[nodiscard]] Result<std::vector<LeftOutRow>> measure_left_out(render::vk::Device& device, const Scene& scene,
                                                               const LeftOutOptions& options);

[[nodiscard]] std::string text_of(const std::vector<LeftOutRow>& rows, const std::string& scene);
[[nodiscard]] std::string json_of(const std::vector<LeftOutRow>& rows);  // one object per line

}  // namespace footlight::tools
