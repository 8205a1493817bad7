// How much two pictures of the stage differ, pixel by pixel, and a picture of that in false colours.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/footlight/preview/stage_picture.h"

namespace footlight::tools {

struct PictureDifference {
  double largest = 0;  // 0 to 1 of white: of a channel of a pixel
  double mean = 0;     // of the largest channels of all pixels
};

// a, b: of the same size, as the screen shows them. rgba: receives the picture, one colour for each largest difference
// of a pixel's channels: black where the pixels are equal, by way of blue, red and yellow to white. The steps of small
// ones are wider: a difference of one step of 255 can be seen.
PictureDifference difference_of(const HostPicture& a, const HostPicture& b, std::vector<std::uint8_t>& rgba);

// The colour of a difference of 0 to 1, 0 to 1 each.
struct DifferenceColour {
  float r, g, b;
};
[[nodiscard]] DifferenceColour colour_of_difference(double difference);

}  // namespace footlight::tools
