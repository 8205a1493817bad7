// Finds a grid in a picture of which nothing is known: its place and scale, layout, planes, range and transfer, and
// whether it is upside down.
#pragma once

#include <string>
#include <vector>

#include "drivers/vrsl/grid.h"

namespace footlight::drivers {

struct GridFinding {
  GridFormat format;     // with the picture's size, and a place if it is not the layout's own
  float confidence = 0;  // as of GridReading, of the whole grid; at least kGridConfidenceMin
  // What the picture leaves open and how it is taken, as whole sentences.
  std::vector<std::string> open;
};

// Places that a layout has of itself come first. Any other place, scale included, is found by its edges; the cells must
// be square there and of 5 pixels or more, most of them must be lit, and the place must be the only one. kNotFound with
// the reason for anything else: a black picture, a photo, text.
[[nodiscard]] Result<GridFinding> find_grid(const PictureView& picture);

}  // namespace footlight::drivers
