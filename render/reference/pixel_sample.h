// A random sample of a picture's pixels, and the error of the whole picture that follows from it.
//
// The judge takes milliseconds a pixel, so large pictures are judged at some thousand pixels of theirs. The sample is
// stratified by a picture of the same scene: pixels are classed by brightness and by contrast to their neighbours, and
// every class is drawn from, dim and flat ones as well as edges. Edges and bright pixels are drawn more often. Each
// pixel stands for (pixels of its stratum) / (drawn of it), so no estimate is biased by that.
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
  std::vector<std::uint32_t> pixels;  // y * width + x; in random order, so that each part of the list is like the rest
  std::vector<std::uint8_t> stratum;  // of each of `pixels`
  bool whole = false;                 // every pixel is drawn; then `pixels` is in the picture's order

  // How many pixels of the picture pixels[i] stands for.
  [[nodiscard]] double weight(std::size_t i) const {
    const Stratum& of = strata[stratum[i]];
    return static_cast<double>(of.pixels) / static_cast<double>(of.drawn);
  }
};

// Draws about `count` > 0 pixels of a picture like `pilot`, all where it has no more. Equal for equal input. Each pixel
// has a random number of its own, made from its index and the seed, and a stratum gives its smallest ones: a pilot that
// differs in a few pixels changes a few of the sample (permanent random numbers: Ohlsson 1995).
[[nodiscard]] PixelSample sample_pixels(const RadianceImage& pilot, int count, std::uint64_t seed);

// The values of a picture at the sample's pixels, `per_pixel` a pixel.
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
  // Of the whole picture, as estimated. `max` and `nonfinite` are of the sample: the largest of what was judged, and
  // how many of its values are not finite.
  PictureNorms norms;
  // A 95 % confidence interval of norms.rel_l2; both equal to it where every pixel is judged.
  double rel_l2_low = 0;
  double rel_l2_high = 0;
};

// `picture`, `reference`: 3 values for each pixel of the sample, in its order; otherwise as picture_norms() takes them.
//
// relL2 squared is a ratio of two totals, sum of squared errors over sum of squares. Both are estimated by stratum; the
// variance of their ratio is that of the linearised residuals e^2 - R r^2 (Cochran, Sampling Techniques, 1977, section
// 6.11), with the finite population correction. The interval is even in the logarithm of the ratio, and takes
// Student's t with Satterthwaite's degrees of freedom. An error in so few pixels that none of them is drawn is not in
// it. How often it covers the truth: docs/numerics.md and tests/render/reference/pixel_sample_test.cpp.
[[nodiscard]] SampledNorms sampled_norms(const PixelSample& sample, std::span<const float> picture,
                                         std::span<const double> reference);

}  // namespace footlight::render
