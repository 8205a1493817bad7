// Pictures of luma and chroma, 8 bits each, from and to RGB: by the exact formulas of BT.709 and BT.601, rounded once.
// (libswscale's fast path is one level off for 108 of 256 greys of limited range.)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/vrsl/picture.h"

namespace footlight::tools {

enum class YuvMatrix { kBt601, kBt709 };

struct YuvCoding {
  YuvMatrix matrix = YuvMatrix::kBt709;
  bool full_range = false;  // luma 0 to 255, else 16 to 235
  bool operator==(const YuvCoding&) const = default;
};

// Three planes that belong to someone else. Chroma of the pixel (x, y) is at (x >> shift_x, y >> shift_y).
struct YuvView {
  std::array<const std::uint8_t*, 3> planes = {};
  std::array<std::ptrdiff_t, 3> strides = {};
  std::array<std::ptrdiff_t, 3> steps = {1, 1, 1};  // octets from a sample to the next one; 2 and 4 in packed pictures
  int width = 0;
  int height = 0;
  int shift_x = 1;
  int shift_y = 1;
};
struct YuvPlanes {
  std::array<std::uint8_t*, 3> planes = {};
  std::array<std::ptrdiff_t, 3> strides = {};
};

class YuvToRgb {
 public:
  explicit YuvToRgb(YuvCoding coding);
  [[nodiscard]] const YuvCoding& coding() const { return coding_; }
  // Rows from `first` to before `last`, into a picture of the same size.
  void convert(const YuvView& yuv, int first, int last, drivers::Picture& rgb) const;

 private:
  YuvCoding coding_;
  // 16 bits of fraction.
  std::array<std::int32_t, 256> luma_{}, red_{}, green_u_{}, green_v_{}, blue_{};
};

class RgbToYuv {
 public:
  explicit RgbToYuv(YuvCoding coding);
  // 4:2:0: even width and height; chroma is that of the mean of four pixels. Pairs of rows that equal the pair above
  // are copied, which makes a grid cheap.
  void convert(const drivers::PictureView& rgb, const YuvPlanes& yuv) const;

 private:
  void convert_pair(const drivers::PictureView& rgb, int y, const YuvPlanes& yuv) const;
  std::array<std::array<std::int32_t, 3>, 3> factors_{};  // of red, green and blue, 16 bits of fraction
  std::int32_t luma_floor_ = 0;
};

}  // namespace footlight::tools
