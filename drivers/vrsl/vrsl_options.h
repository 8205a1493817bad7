// The options of a vrsl endpoint that the grid uses; those that remain belong to the target.
//
//   layout    horizontal-bottom, horizontal-top, vertical-left, vertical-right; in: also auto, the default
//   planes    luma, rgb; default: rgb if one of its universes is above 3. In with layout=auto: found
//   range     full, limited
//   transfer  linear, from-srgb, to-srgb
//   flip      yes, no: upside down
//   check     yes, no: the row with a number and a CRC-32; in: pictures with a wrong one are refused
//   size      1920x1080: of the whole picture; in: only with a layout, and scaled from any size if left out
//   place     LEFT,TOP,CELL: of the grid in the picture, in pixels
//   fps       0.1 to 240; 30
#pragma once

#include <vector>

#include "drivers/vrsl/grid.h"
#include "drivers/vrsl/picture_port.h"

namespace footlight::drivers {

struct VrslOptions {
  GridFormat format;
  bool find = false;     // in: search for the grid; of `format` only check_row counts
  bool any_size = true;  // in: `format` has the size of the first picture
  PictureTarget target;  // all but width and height set for inputs
  std::vector<WireUniverse> universes;
};

// Errors: kBadInput; the message begins with the endpoint and names the option, what was expected and an example.
[[nodiscard]] Result<VrslOptions> vrsl_out_options(const Endpoint& endpoint);
[[nodiscard]] Result<VrslOptions> vrsl_in_options(const Endpoint& endpoint);

}  // namespace footlight::drivers
