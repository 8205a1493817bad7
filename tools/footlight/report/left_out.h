// What a rig does not need and the frame therefore leaves out, with the GPU time and memory that this saves.
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
  int width = 640;
  int height = 360;
  int runs = 11;  // pairs of frames a row, after one that is not counted; 0: bytes only
  // Optional. Called between rows; false ends the measuring with the rows so far.
  std::function<bool(double done, double all)> go_on;
};

// The cost of one thing that is left out. Times are differences of pairs of frames, with and without it, drawn one
// after the other, in the passes that it brings or changes; each frame has one step of 20 ms.
struct LeftOutRow {
  std::string name;  // of the pass or the need
  std::string text;  // what the rig lacks, or what the picture lacks
  bool pass = false;
  bool on_gpu = true;  // false: no shader, buffer or image depends on it, so nothing was measured
  std::uint64_t bytes = 0;
  struct Times {
    double ms_p10 = 0;
    double ms_p50 = 0;
    double ms_p90 = 0;
  };
  std::optional<Times> times;  // empty where nothing was timed
};

// Passes first, then needs; as footlight::render::left_out_passes() and fixtures::features() order them. The time of a
// pass is its own within the frame of the need that brings it.
[[nodiscard]] Result<std::vector<LeftOutRow>> measure_left_out(render::vk::Device& device, const Scene& scene,
                                                               const LeftOutOptions& options);

[[nodiscard]] std::string text_of(const std::vector<LeftOutRow>& rows, const std::string& scene);
[[nodiscard]] std::string json_of(const std::vector<LeftOutRow>& rows);  // one object a line

}  // namespace footlight::tools
