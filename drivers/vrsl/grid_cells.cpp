#include "drivers/vrsl/grid_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace footlight::drivers {
namespace {

// Codes: the spread inside a cell, and between the colours of a grey cell.
constexpr double kSpreadGood = 2, kSpreadBad = 14;
constexpr double kTintGood = 8, kTintBad = 40;
constexpr double kBadGood = 0.005, kBadBad = 0.05;  // share of cells

}  // namespace

std::vector<int> inner_parts(double first, double pitch, int cells, int size) {
  std::vector<int> at;
  for (int i = 0; i < cells; ++i) {
    const double begin = first + i * pitch;
    const int from = std::clamp(static_cast<int>(std::lround(begin + pitch / 4)), 0, size - 1);
    at.push_back(from);
    at.push_back(std::clamp(static_cast<int>(std::lround(begin + 3 * pitch / 4)), from + 1, size));
  }
  return at;
}

CellColor color_of(const PictureView& picture, int left, int right, int top, int bottom) {
  std::array<std::uint32_t, 3> sum{}, squares{};
  for (int y = top; y < bottom; ++y) {
    const std::uint8_t* pixel = picture.at(left, y);
    for (int x = left; x < right; ++x, pixel += 3) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += pixel[c];
        squares[c] += static_cast<std::uint32_t>(pixel[c]) * pixel[c];
      }
    }
  }
  CellColor color;
  const double count = (right - left) * (bottom - top);
  for (std::size_t c = 0; c < 3; ++c) {
    color.mean[c] = sum[c] / count;
    color.variance = std::max(color.variance, squares[c] / count - color.mean[c] * color.mean[c]);
  }
  return color;
}

double quality_of(const CellColor& color, bool grey) {
  double quality = share_of(std::sqrt(std::max(color.variance, 0.0)), kSpreadGood, kSpreadBad);
  if (grey) {
    const auto [low, high] = std::minmax_element(color.mean.begin(), color.mean.end());
    quality *= share_of(*high - *low, kTintGood, kTintBad);
  }
  return quality;
}

void CellEvidence::add(double cell_quality, double code_from_black, bool is_padding) {
  if (is_padding) {
    padding += code_from_black;
    ++padding_cells;
  }
  bad += cell_quality < 0.5 ? 1 : 0;
  if (code_from_black <= kLitCodes && cell_quality >= 0.5) return;
  quality += cell_quality;
  ++lit;
  good += cell_quality >= 0.5 ? 1 : 0;
}

double CellEvidence::confidence(int cells) const {
  double result = lit > 0 ? quality / lit : 1.0;
  if (cells > 0) result *= share_of(static_cast<double>(bad) / cells, kBadGood, kBadBad);
  return result * blackness();
}

}  // namespace footlight::drivers
