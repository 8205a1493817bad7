// Videos for tests, and a display that shows one.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fixtures/displays/display.h"
#include "tests/support/must.h"
#include "tools/footlight/vrsl/video_output.h"

namespace footlight::tools {

inline constexpr double kHz = 25;
inline constexpr DurationNs kPictureNs = 40 * kNsPerMs;

// Fields of colour that drift, a ramp, and a bar whose place is the number of the picture.
inline drivers::Picture picture_of(int number, int width, int height) {
  drivers::Picture picture;
  picture.clear(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint8_t* const at = picture.at(x, y);
      const bool bar = x * 50 / width == number % 50;
      at[0] = bar ? 255 : static_cast<std::uint8_t>(255 * x / width);
      at[1] = bar ? 255 : static_cast<std::uint8_t>((x / 8 + y / 8 + number) % 2 == 0 ? 40 : 200);
      at[2] = bar ? 0 : static_cast<std::uint8_t>(255 * y / height);
    }
  }
  return picture;
}

inline void write_clip(const std::string& path, int count, int width = 160, int height = 90,
                std::vector<EndpointOption> options = {{"lossless", "yes"}}) {
  drivers::PictureTarget target;
  target.endpoint = target.name = path;
  target.pictures_hz = kHz;
  target.width = width;
  target.height = height;
  target.options = std::move(options);
  const auto output = testing::must(open_video_output(target));
  for (int i = 0; i < count; ++i) testing::must(output->show(picture_of(i, width, height), i * kPictureNs));
  testing::must(output->finish());
}

inline fixtures::Display display_of(const std::string& path) {
  fixtures::Display display;
  display.columns = 16;
  display.rows = 9;
  display.video.emplace().path = path;
  return display;
}

}  // namespace footlight::tools
