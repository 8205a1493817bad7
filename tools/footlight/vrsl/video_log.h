// A video of VRSL's grid as a log: 'footlight log convert club.mp4 club.dmxlog'.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "drivers/vrsl/vrsl_source.h"
#include "sim/dmx_log/log_input.h"
#include "tools/footlight/vrsl/video_reader.h"

namespace footlight::tools {

struct UniverseConfidence {
  std::uint64_t frames = 0;    // those that were left out too
  std::uint64_t left_out = 0;  // their confidence was below kGridConfidenceMin
  double mean = 0;
  double lowest = 1;
};

// What a video is and what became of its pictures; of all of them when its end was read.
struct VideoLogReport {
  VideoFacts facts;
  VideoCounters video;
  drivers::VrslReaderCounters grids;
  std::optional<drivers::GridCodec> codec;  // of the newest picture; nullopt: none has a grid so far
  std::array<UniverseConfidence, drivers::kGridUniversesMax> universes;
  std::uint64_t other_grids = 0;  // pictures with the grid in another place or form than in the first
  std::string refusal;            // of the newest picture without a grid
  DurationNs longest_gap_ns = 0;  // from a picture that was decoded to the next one
};

// A frame for each universe of each picture, at the time that the stream gives the picture. Left out and counted in
// notes(): damaged pictures, pictures without a grid, and frames whose universe has a confidence below
// kGridConfidenceMin. notes() states the confidence of each universe. A video in which no picture has a grid ends with
// kBadInput.
class VideoLog : public LogInput {
 public:
  [[nodiscard]] virtual VideoLogReport report() const = 0;
};

// `format`: options of the grid as after "?" of an endpoint, with a layout; empty: found in the pictures. `option`: its
// name on the command line. Errors: those of VideoReader::open(); kBadInput for the options.
[[nodiscard]] Result<std::unique_ptr<VideoLog>> open_video_log(const std::string& path, const std::string& format,
                                                               const std::string& option);

}  // namespace footlight::tools
