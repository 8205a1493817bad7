// H.264 as a way of pictures, for 'footlight vrsl round-trip'.
#pragma once

#include <vector>

#include "tools/footlight/vrsl/round_trip.h"

namespace footlight::tools {

inline constexpr int kWayHeldPictures = 6;

// Through an encoder and a decoder, without a file, at 60 pictures a second and three bit rates; in the size of the
// picture, and scaled to 1280 x 720 before. Each picture is sent kWayHeldPictures times, as levels that change every
// 100 ms are; the last one counts. Empty in a build without libav.
[[nodiscard]] std::vector<PictureWay> video_ways();

}  // namespace footlight::tools
