// A random sample of a picture's pixels, and an estimate of the error of the whole picture from it.
//
// The judge takes milliseconds per pixel, so large pictures are judged at some thousand of their pixels. The sample is
// stratified by a picture of the same scene: pixels are classed by brightness and by contrast to their neighbours, and
// some are drawn from every class, also from dim and flat ones. Edges and bright pixels are drawn more often. Each
// drawn pixel has the weight (pixels of its stratum) / (drawn pixels of it), so the estimates are not biased.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/image.h"
#include "render/reference/norms.h"

namespace footlight::render {

struct PixelSample {
  struct Stratum {
    std::int64_t pixels = 0;
    std::int64_t drawn = 0;  // at least 2, or all
  };
  std::vector<Stratum> strata;
  // y * width + x; in random order, so that each part of the list is a random sample, too
  std::vector<std::uint32_t> pixels;
  std::vector<std::uint8_t> stratum;  // of each of `pixels`
  bool whole = false;                 // every pixel is drawn; then `pixels` is in the picture's order

  // The number of pixels of the picture that pixels[i] represents.
  [[nodiscard]] double weight(std::size_t i) const {
    const Stratum& of = strata[stratum[i]];
    return static_cast<double>(of.pixels) / static_cast<double>(of.drawn);
  }
};

// Draws about `count` > 0 pixels of a picture like `pilot`, or all if it has no more. Equal input gives equal output.
// Each pixel has a random number that is made from its index and the seed, and a stratum draws its smallest ones. A
// pilot that differs in a few pixels therefore changes only a few pixels of the sample (permanent random numbers:
// Ohlsson 1995).
[[nodiscard]] PixelSample sample_pixels(const RadianceImage& pilot, int count, std::uint64_t seed);

// Returns the values of a picture at the sample's pixels, `per_pixel` values per pixel.
template <class T>
[[nodiscard]] std::vector<T> at_sample(const PixelSample& sample, std::span<const T> values, std::size_t per_pixel) {
  std::vector<T> out;
  out.reserve(sample.pixels.size() * per_pixel);
  for (const std::uint32_t pixel : sample.pixels) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(pixel * per_pixel);
    out.insert(out.end(), first, first + static_cast<std::ptrdiff_t>(per_pixel));
  }
  return out;
}

struct SampledNorms {
  // Estimates for the whole picture. `max` and `nonfinite` are of the sample only: the largest error, and how many
  // values are not finite.
  PictureNorms norms;
  // 95 % confidence interval of norms.rel_l2; both ends equal it if every pixel is judged.
  double rel_l2_low = 0;
  double rel_l2_high = 0;
};

// `picture`, `reference`: 3 values for each pixel of the sample, in its order; else as in picture_norms().
//
// relL2 squared is a ratio of two totals, the sum of squared errors over the sum of squares. Both are estimated by
// stratum. The variance of their ratio is that of the linearised residuals e^2 - R r^2 (Cochran, Sampling Techniques,
// 1977, section 6.11), with the finite population correction. The interval is symmetric in the logarithm of the ratio.
// It uses Student's t with Satterthwaite's degrees of freedom. The interval does not include an error in so few pixels
// that none of them is drawn. Its measured coverage: docs/numerics.md and tests/render/reference/pixel_sample_test.cpp.
[[nodiscard]] SampledNorms sampled_norms(const PixelSample& sample, std::span<const float> picture,
                                         std::span<const double> reference);

}  // namespace footlight::render
