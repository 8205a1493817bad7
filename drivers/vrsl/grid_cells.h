// The colour of cells of a grid in a picture: shared by the codec, the search for a grid and VRSL's own reading.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "drivers/vrsl/picture.h"

namespace footlight::drivers {

// Weights of luminance in VRSL's shaders.
inline constexpr std::array<double, 3> kVrslLuma = {0.2126729, 0.7151522, 0.072175};

// The pixels of the middle half of each cell, at least one: pairs of the first and one past the last.
[[nodiscard]] std::vector<int> inner_parts(double first, double pitch, int cells, int size);

struct CellColor {
  std::array<double, 3> mean{};  // codes
  double variance = 0;           // the largest of the three
};
// Of a part of a picture that is not empty and inside it; at most 4,096 x 16 pixels.
[[nodiscard]] CellColor color_of(const PictureView& picture, int left, int right, int top, int bottom);

// The code of a grey cell, weighted as VRSL does.
[[nodiscard]] inline double luminance_of(const CellColor& color) {
  return (kVrslLuma[0] * color.mean[0] + kVrslLuma[1] * color.mean[1] + kVrslLuma[2] * color.mean[2]) /
         (kVrslLuma[0] + kVrslLuma[1] + kVrslLuma[2]);
}
// 1 up to `good`, 0 from `bad` on, straight between them.
[[nodiscard]] inline double share_of(double value, double good, double bad) {
  return std::clamp((bad - value) / (bad - good), 0.0, 1.0);
}
// How far a cell is of one colour, 0 to 1. grey: and of no tint.
[[nodiscard]] double quality_of(const CellColor& color, bool grey);
// Codes that padding may be away from black: none, and as good as another picture.
inline constexpr double kPaddingGood = 4, kPaddingBad = 24;
// A cell is lit if a colour of it is further away from black than this.
inline constexpr double kLitCodes = 8;

// What the cells of one universe, or of one picture, show.
struct CellEvidence {
  double quality = 0;  // sum over lit cells
  int lit = 0;
  int good = 0;        // lit cells of a quality of one half or more
  int bad = 0;         // cells of a quality below one half
  double padding = 0;  // sum of distances from black
  int padding_cells = 0;

  void add(double cell_quality, double code_from_black, bool is_padding);
  // 0 to 1. One cell in 200 may be bad without a loss; with one in 20 the picture is not used: a text or a logo over
  // the grid spoils few cells. cells: those that were added.
  [[nodiscard]] double confidence(int cells) const;
  // The part of it that follows from the padding.
  [[nodiscard]] double blackness() const {
    return padding_cells > 0 ? share_of(padding / padding_cells, kPaddingGood, kPaddingBad) : 1.0;
  }
};

}  // namespace footlight::drivers
