// Pictures of 8-bit RGB, rows from the top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace footlight::drivers {

// Pixels that belong to someone else: valid during the call that receives it as an argument.
struct PictureView {
  const std::uint8_t* pixels = nullptr;  // red, green, blue of the top left pixel
  int width = 0;
  int height = 0;
  std::size_t stride_bytes = 0;  // from a row to the next one, at least 3 * width

  [[nodiscard]] const std::uint8_t* row(int y) const { return pixels + static_cast<std::size_t>(y) * stride_bytes; }
  [[nodiscard]] const std::uint8_t* at(int x, int y) const { return row(y) + 3 * static_cast<std::size_t>(x); }
};

// Pixels of its own, without gaps between rows.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  // Black. Allocates only if it grows.
  void clear(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    rgb.assign(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  }
  [[nodiscard]] PictureView view() const { return {rgb.data(), width, height, 3 * static_cast<std::size_t>(width)}; }
  [[nodiscard]] std::uint8_t* at(int x, int y) {
    return rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

}  // namespace footlight::drivers
