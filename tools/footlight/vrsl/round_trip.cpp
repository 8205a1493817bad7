#include "tools/footlight/vrsl/round_trip.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <set>

#include "drivers/vrsl/grid_find.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

using drivers::GridCodec;
using drivers::GridFormat;
using drivers::GridLayout;
using drivers::GridPlanes;
using drivers::GridRange;
using drivers::GridTransfer;
using drivers::Picture;

// Each new pixel is the mean of the area that it covers, as scalers of video do it.
void scale_to(Picture& picture, int width, int height) {
  Picture smaller;
  smaller.clear(width, height);
  const double step_x = static_cast<double>(picture.width) / width;
  const double step_y = static_cast<double>(picture.height) / height;
  for (int y = 0; y < height; ++y) {
    const double top = y * step_y, bottom = (y + 1) * step_y;
    for (int x = 0; x < width; ++x) {
      const double left = x * step_x, right = (x + 1) * step_x;
      double sum[3] = {}, area = 0;
      for (int py = static_cast<int>(top); py < picture.height && py < bottom; ++py) {
        const double high = std::min<double>(bottom, py + 1) - std::max<double>(top, py);
        for (int px = static_cast<int>(left); px < picture.width && px < right; ++px) {
          const double weight = high * (std::min<double>(right, px + 1) - std::max<double>(left, px));
          const std::uint8_t* const pixel = picture.at(px, py);
          for (int c = 0; c < 3; ++c) sum[c] += weight * pixel[c];
          area += weight;
        }
      }
      for (int c = 0; c < 3; ++c) smaller.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(sum[c] / area));
    }
  }
  picture = std::move(smaller);
}

std::uint8_t code_of(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

// ITU-R BT.709: 8 bits, luma 16 to 235, chroma 16 to 240 for each 2 x 2 pixels.
void pass_yuv420(Picture& picture) {
  constexpr double kRed = 0.2126, kGreen = 0.7152, kBlue = 0.0722;
  const auto luma = [](const std::uint8_t* p) { return kRed * p[0] + kGreen * p[1] + kBlue * p[2]; };
  for (int y = 0; y < picture.height; y += 2) {
    for (int x = 0; x < picture.width; x += 2) {
      double blue = 0, red = 0;
      double stored[4] = {};
      int count = 0;
      const int right = std::min(x + 2, picture.width), bottom = std::min(y + 2, picture.height);
      for (int py = y; py < bottom; ++py) {
        for (int px = x; px < right; ++px) {
          const std::uint8_t* const pixel = picture.at(px, py);
          const double bright = luma(pixel);
          blue += (pixel[2] - bright) / 1.8556;
          red += (pixel[0] - bright) / 1.5748;
          stored[count++] = code_of(16 + 219 * bright / 255);
        }
      }
      blue = (code_of(128 + 224 * blue / count / 255) - 128) * 255 / 224.0;
      red = (code_of(128 + 224 * red / count / 255) - 128) * 255 / 224.0;
      count = 0;
      for (int py = y; py < bottom; ++py) {
        for (int px = x; px < right; ++px) {
          const double bright = (stored[count++] - 16) * 255 / 219;
          std::uint8_t* const pixel = picture.at(px, py);
          pixel[0] = code_of(bright + 1.5748 * red);
          pixel[1] = code_of(bright - (kBlue * 1.8556 * blue + kRed * 1.5748 * red) / kGreen);
          pixel[2] = code_of(bright + 1.8556 * blue);
        }
      }
    }
  }
}

std::vector<std::uint8_t> random_levels(std::uint64_t& state) {
  std::vector<std::uint8_t> levels(std::size_t{9} * kSlotCountMax);
  for (std::uint8_t& level : levels) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    level = static_cast<std::uint8_t>(state >> 32);
  }
  return levels;
}

std::vector<GridFormat> formats() {
  std::vector<GridFormat> all;
  for (const auto layout : {GridLayout::kHorizontalBottom, GridLayout::kVerticalLeft}) {
    for (const auto planes : {GridPlanes::kLuma, GridPlanes::kRgb}) {
      for (const auto range : {GridRange::kFull, GridRange::kLimited}) {
        for (const auto transfer : {GridTransfer::kLinear, GridTransfer::kFromSrgb, GridTransfer::kToSrgb}) {
          all.push_back({.layout = layout, .planes = planes, .range = range, .transfer = transfer});
        }
      }
    }
  }
  return all;
}

}  // namespace

std::vector<PictureWay> plain_ways() {
  return {
      {"none", [](Picture&) -> Status { return {}; }},
      {"1280x720",
       [](Picture& picture) -> Status {
         scale_to(picture, 1280, 720);
         return {};
       }},
      {"640x360",
       [](Picture& picture) -> Status {
         scale_to(picture, 640, 360);
         return {};
       }},
      {"yuv420",
       [](Picture& picture) -> Status {
         pass_yuv420(picture);
         return {};
       }},
  };
}

Result<RoundTripRow> round_trip(const GridFormat& format, const PictureWay& way, int pictures) {
  RoundTripRow row;
  row.format = format;
  row.way = way.name;
  row.pictures = pictures;
  row.confidence = 1;
  FL_ASSIGN(const GridCodec codec, GridCodec::make(format));
  row.unreachable = codec.unreachable_count();
  row.addresses = codec.universe_count() * kSlotCountMax - row.unreachable;
  std::set<int> left;
  for (int level = 0; level < 256; ++level) left.insert(codec.through(static_cast<std::uint8_t>(level)));
  row.levels_left = static_cast<int>(left.size());
  std::uint64_t state = 0x9E37'79B9'7F4A'7C15u;
  std::vector<std::uint8_t> got(std::size_t{9} * kSlotCountMax);
  for (int i = 0; i < pictures; ++i) {
    const auto sent = random_levels(state);
    Picture picture;
    codec.encode(sent, picture);
    FL_TRY(way.pass(picture));
    GridFormat arrived = format;
    arrived.width = picture.width;
    arrived.height = picture.height;
    FL_ASSIGN(const GridCodec reader, GridCodec::make(arrived));
    drivers::GridReading reading;
    FL_TRY(reader.decode(picture.view(), got, reading));
    row.confidence = std::min(row.confidence, static_cast<double>(reading.lowest(codec.universe_count())));
    for (int universe = 1; universe <= codec.universe_count(); ++universe) {
      for (int slot = 0; slot < codec.slot_count(universe); ++slot) {
        const auto at = static_cast<std::size_t>((universe - 1) * kSlotCountMax + slot);
        const int error = std::abs(static_cast<int>(sent[at]) - got[at]);
        row.changed += error != 0 ? 1 : 0;
        row.error_max = std::max(row.error_max, error);
      }
    }
    const auto found = drivers::find_grid(picture.view());
    row.found = found && found->format.layout == format.layout && found->format.planes == format.planes &&
                found->format.range == format.range && !found->format.place && (i == 0 || row.found);
  }
  return row;
}

Result<std::vector<RoundTripRow>> round_trips(std::span<const PictureWay> ways, int pictures) {
  std::vector<RoundTripRow> rows;
  for (const PictureWay& way : ways) {
    for (const GridFormat& format : formats()) {
      FL_ASSIGN(RoundTripRow row, round_trip(format, way, pictures));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

PictureTimes picture_times(int pictures) {
  const auto codec = GridCodec::make({.planes = GridPlanes::kRgb});
  FL_CHECK(codec.has_value());
  std::vector<std::vector<std::uint8_t>> sent;
  std::uint64_t state = 1;
  for (int i = 0; i < 8; ++i) sent.push_back(random_levels(state));
  std::vector<std::uint8_t> got(std::size_t{9} * kSlotCountMax);
  Picture picture;
  codec->encode(sent[0], picture);  // allocates
  drivers::GridReading reading;
  const auto mean_ms = [&](const auto& work) {
    const std::clock_t before = std::clock();
    for (int i = 0; i < pictures; ++i) work(static_cast<std::size_t>(i) % sent.size());
    return 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / pictures;
  };
  PictureTimes times;
  times.encode_ms = mean_ms([&](std::size_t i) { codec->encode(sent[i], picture); });
  times.decode_ms = mean_ms([&](std::size_t) { (void)codec->decode(picture.view(), got, reading); });
  times.find_ms = mean_ms([&](std::size_t) { (void)drivers::find_grid(picture.view()); });
  return times;
}

}  // namespace footlight::tools
