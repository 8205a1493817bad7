// How many levels survive a picture: every layout, range and transfer, through every way that pictures take.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drivers/vrsl/grid.h"

namespace footlight::tools {

// What happens to pictures between an encoder and a decoder: scaling, a codec. `pass` replaces the picture, whose size
// may change. It gets several pictures, in the order of a film.
struct PictureWay {
  std::string name;
  std::function<Status(drivers::Picture&)> pass;
};

// Ways that need no library: none; scaled to 1280 x 720 and 640 x 360; as a video stores colours, BT.709 in limited
// range with chroma at half the resolution.
[[nodiscard]] std::vector<PictureWay> plain_ways();

struct RoundTripRow {
  drivers::GridFormat format;
  std::string way;
  int addresses = 0;    // that the layout carries
  int unreachable = 0;  // and those that it does not
  int levels_left = 0;  // of 256, that the format distinguishes without a loss on the way
  int changed = 0;      // addresses whose level differs from the one sent, of all pictures
  int pictures = 0;
  int error_max = 0;      // of a level
  double confidence = 0;  // the lowest of all pictures and universes
  bool found = false;     // find_grid() found layout, planes and place
};

// Random levels, the same each time; `pictures` of them.
[[nodiscard]] Result<RoundTripRow> round_trip(const drivers::GridFormat& format, const PictureWay& way, int pictures);
// For each way: two layouts, both planes, both ranges, all transfers.
[[nodiscard]] Result<std::vector<RoundTripRow>> round_trips(std::span<const PictureWay> ways, int pictures);

// Mean processor time for one picture of 1920 x 1080 with nine universes of random levels.
struct PictureTimes {
  double encode_ms = 0;
  double decode_ms = 0;
  double find_ms = 0;  // at its usual place
};
[[nodiscard]] PictureTimes picture_times(int pictures);

}  // namespace footlight::tools
