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
  std::uint64_t code_bytes = 0;  // of a pass: SPIR-V of its shaders
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

// The same rows with bytes alone, and with the code of each pass. Needs no device: any thread. `needs`: of the rig, or
// drawn_needs() of it.
struct LeftOutPlan {
  std::vector<LeftOutRow> rows;
  std::uint64_t code_bytes = 0;       // SPIR-V of all pipelines of the passes that are left out
  std::uint64_t used_code_bytes = 0;  // of those that are in use
};
[[nodiscard]] LeftOutPlan plan_left_out(const render::MemoryShape& shape);

// "512 B", "9.8 KiB", "3.0 MiB".
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);
[[nodiscard]] std::string text_of(const std::vector<LeftOutRow>& rows, const std::string& scene);
[[nodiscard]] std::string json_of(const std::vector<LeftOutRow>& rows);  // one object per line

}  // namespace footlight::tools
