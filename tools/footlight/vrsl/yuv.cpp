#include "tools/footlight/vrsl/yuv.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace footlight::tools {
namespace {

constexpr std::int32_t kFixedOne = 1 << 16;
constexpr std::int32_t kFixedHalf = kFixedOne / 2;

struct YuvWeights {
  double red;
  double blue;
};

// Weights of red and blue in luma: BT.709 item 3.2, BT.601 item 2.5.1.
YuvWeights weights_of(YuvMatrix matrix) {
  return matrix == YuvMatrix::kBt709 ? YuvWeights{0.2126, 0.0722} : YuvWeights{0.299, 0.114};
}

std::int32_t fixed_of(double value) { return static_cast<std::int32_t>(std::lround(value * kFixedOne)); }

std::uint8_t rounded(std::int32_t fixed) {
  return static_cast<std::uint8_t>(std::clamp((fixed + kFixedHalf) >> 16, 0, 255));
}

}  // namespace

YuvToRgb::YuvToRgb(YuvCoding coding) : coding_(coding) {
  const YuvWeights weights = weights_of(coding.matrix);
  const double green = 1.0 - weights.red - weights.blue;
  const double luma_gain = coding.full_range ? 1.0 : 255.0 / 219.0;
  const double chroma_gain = coding.full_range ? 1.0 : 255.0 / 224.0;
  for (int code = 0; code < 256; ++code) {
    const auto i = static_cast<std::size_t>(code);
    const double chroma = (code - 128) * chroma_gain;
    luma_[i] = fixed_of((code - (coding.full_range ? 0 : 16)) * luma_gain);
    red_[i] = fixed_of(chroma * 2.0 * (1.0 - weights.red));
    blue_[i] = fixed_of(chroma * 2.0 * (1.0 - weights.blue));
    green_u_[i] = -fixed_of(chroma * 2.0 * (1.0 - weights.blue) * weights.blue / green);
    green_v_[i] = -fixed_of(chroma * 2.0 * (1.0 - weights.red) * weights.red / green);
  }
}

void YuvToRgb::convert(const YuvView& yuv, int first, int last, drivers::Picture& rgb) const {
  const std::ptrdiff_t luma_step = yuv.steps[0];
  for (int y = first; y < last; ++y) {
    const std::uint8_t* luma = yuv.planes[0] + y * yuv.strides[0];
    const std::uint8_t* u = yuv.planes[1] + (y >> yuv.shift_y) * yuv.strides[1];
    const std::uint8_t* v = yuv.planes[2] + (y >> yuv.shift_y) * yuv.strides[2];
    std::uint8_t* out = rgb.at(0, y);
    const int run = 1 << yuv.shift_x;
    for (int x = 0; x < yuv.width; x += run, u += yuv.steps[1], v += yuv.steps[2]) {
      const std::int32_t red = red_[*v];
      const std::int32_t green = green_u_[*u] + green_v_[*v];
      const std::int32_t blue = blue_[*u];
      for (int i = 0; i < std::min(run, yuv.width - x); ++i, luma += luma_step, out += 3) {
        const std::int32_t grey = luma_[*luma];
        out[0] = rounded(grey + red);
        out[1] = rounded(grey + green);
        out[2] = rounded(grey + blue);
      }
    }
  }
}

RgbToYuv::RgbToYuv(YuvCoding coding) : luma_floor_((coding.full_range ? 0 : 16) * kFixedOne) {
  const YuvWeights weights = weights_of(coding.matrix);
  const double green = 1.0 - weights.red - weights.blue;
  const double luma_gain = coding.full_range ? 1.0 : 219.0 / 255.0;
  const double chroma_gain = coding.full_range ? 1.0 : 224.0 / 255.0;
  const auto row = [](double gain, double r, double g, double b) {
    return std::array<std::int32_t, 3>{fixed_of(gain * r), fixed_of(gain * g), fixed_of(gain * b)};
  };
  factors_[0] = row(luma_gain, weights.red, green, weights.blue);
  const double per_u = 0.5 * chroma_gain / (1.0 - weights.blue);
  factors_[1] = row(per_u, -weights.red, -green, 1.0 - weights.blue);
  const double per_v = 0.5 * chroma_gain / (1.0 - weights.red);
  factors_[2] = row(per_v, 1.0 - weights.red, -green, -weights.blue);
}

void RgbToYuv::convert(const drivers::PictureView& rgb, const YuvPlanes& yuv) const {
  const auto row_bytes = 3 * static_cast<std::size_t>(rgb.width);
  const auto luma_bytes = static_cast<std::size_t>(rgb.width);
  const auto equal_rows = [&](int a, int b) { return std::memcmp(rgb.row(a), rgb.row(b), row_bytes) == 0; };
  for (int y = 0; y < rgb.height; y += 2) {
    if (y == 0 || !equal_rows(y, y - 2) || !equal_rows(y + 1, y - 1)) {
      convert_pair(rgb, y, yuv);
      continue;
    }
    std::uint8_t* const luma = yuv.planes[0] + y * yuv.strides[0];
    std::memcpy(luma, luma - 2 * yuv.strides[0], luma_bytes);
    std::memcpy(luma + yuv.strides[0], luma - yuv.strides[0], luma_bytes);
    for (std::size_t plane = 1; plane < 3; ++plane) {
      std::uint8_t* const chroma = yuv.planes[plane] + y / 2 * yuv.strides[plane];
      std::memcpy(chroma, chroma - yuv.strides[plane], luma_bytes / 2);
    }
  }
}

void RgbToYuv::convert_pair(const drivers::PictureView& rgb, int y, const YuvPlanes& yuv) const {
  const auto sum = [](const std::array<std::int32_t, 3>& factors, int red, int green, int blue) {
    return factors[0] * red + factors[1] * green + factors[2] * blue;
  };
  for (int x = 0; x < rgb.width; x += 2) {
    int total[3] = {};
    for (const int dy : {0, 1}) {
      for (const int dx : {0, 1}) {
        const std::uint8_t* const pixel = rgb.at(x + dx, y + dy);
        for (int i = 0; i < 3; ++i) total[i] += pixel[i];
        yuv.planes[0][(y + dy) * yuv.strides[0] + x + dx] =
            rounded(luma_floor_ + sum(factors_[0], pixel[0], pixel[1], pixel[2]));
      }
    }
    for (std::size_t plane = 1; plane < 3; ++plane) {
      const std::int32_t chroma = sum(factors_[plane], total[0], total[1], total[2]) / 4;
      yuv.planes[plane][y / 2 * yuv.strides[plane] + x / 2] = rounded(128 * kFixedOne + chroma);
    }
  }
}

}  // namespace footlight::tools
