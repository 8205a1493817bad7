// H.264 as a way of pictures, for 'footlight vrsl round-trip'.
#pragma once

#include <string_view>
#include <vector>

#include "tools/footlight/vrsl/round_trip.h"

namespace footlight::tools {

inline constexpr int kWayHeldPictures = 6;

// Through an encoder and a decoder, without a file, at 60 pictures a second and three bit rates; in the size of the
// picture, and scaled to 1280 x 720 before. Each picture is sent kWayHeldPictures times, as levels that change every
// 100 ms are; the last one counts. Errors: kUnsupported without libav, in the build or on the machine.
[[nodiscard]] Result<std::vector<PictureWay>> video_ways();
// True for the names of these ways, also where they are missing.
[[nodiscard]] inline bool is_video_way(std::string_view name) {
  return name.starts_with("h264-") || name.starts_with("720p-");
}

}  // namespace footlight::tools
