// Distances of a picture from its reference.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/image.h"

namespace footlight::render {

// Computed over the 3 width height values of a picture. A value that is not finite adds to `nonfinite` and counts as 0
// elsewhere.
struct PictureNorms {
  double rel_l2 = 0;   // sqrt(sum (x - r)^2 / sum r^2)
  double rel_mse = 0;  // mean of (x - r)^2 / (r^2 + 1e-2 mean(r)^2)
  double p50 = 0;      // percentiles and the largest of |x - r| / (r + 1e-2 mean(r))
  double p99 = 0;
  double p999 = 0;
  double max = 0;
  std::int64_t nonfinite = 0;
};

// `picture` and `reference` have equal size > 0. Values of `reference` are finite and >= 0. For a black reference a
// black picture gives 0 and any other infinity.
[[nodiscard]] PictureNorms picture_norms(std::span<const float> picture, std::span<const double> reference);
[[nodiscard]] PictureNorms picture_norms(const RadianceImage& picture, const RadianceImage& reference);

// FLIP for screens: the mean difference that a viewer sees when flipping between two pictures, 0 to 1.
//
// Source: P. Andersson et al., FLIP: A Difference Evaluator for Alternating Images, HPG 2020. Assumes an sRGB screen
// with D65 white, seen at `pixels_per_degree` (67.02: 3840 pixels on 0.7 m seen from 0.7 m, the paper's default), edges
// continued by their last pixel, and the mean as the single number. Not checked against the authors' program to the
// digit.
inline constexpr double kFlipPixelsPerDegree = 67.02064327658225;

struct FlipMap {
  int width = 0;
  int height = 0;
  std::vector<float> value;  // 0 to 1 per pixel, rows from the top
  double mean = 0;
};

// Pictures of equal size; both in 8-bit sRGB.
[[nodiscard]] FlipMap flip(const ScreenImage& a, const ScreenImage& b, double pixels_per_degree = kFlipPixelsPerDegree);
// The same on linear Rec. 709 values 0 to 1 (clamped), 3 per pixel.
[[nodiscard]] FlipMap flip_linear(int width, int height, std::span<const float> a, std::span<const float> b,
                                  double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace footlight::render
