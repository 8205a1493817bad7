#include "render/reference/pixel_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <boost/math/distributions/students_t.hpp>

#include "sim/core/check.h"
#include "sim/core/random.h"

namespace footlight::render {
namespace {

// Bounds of the strata, chosen: brightness, and the largest difference from a neighbour, over the root mean square of
// the picture.
constexpr std::array<double, 3> kBrightness{0.03, 0.3, 1.0};
constexpr std::array<double, 3> kContrast{0.01, 0.1, 0.5};
constexpr std::size_t kStrata = (kBrightness.size() + 1) * (kContrast.size() + 1);
constexpr std::int64_t kDrawnLeast = 24;  // of each stratum that has as many pixels

// The number that SeededNumbers has in this place.
std::uint64_t random_of(std::uint64_t seed, std::uint64_t index) { return mixed_bits(seed + (index + 1) * kMixStep); }

struct Class {
  std::uint8_t stratum = 0;
  double light = 0;  // squares of brightness and of the largest difference from a neighbour
  double step = 0;
};

// Brightness of each pixel: the mean of its channels, or 0 if that is not finite.
std::vector<double> brightness_of(const RadianceImage& image) {
  std::vector<double> values(image.rgb.size() / 3);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double mean = (static_cast<double>(image.rgb[3 * i]) + static_cast<double>(image.rgb[3 * i + 1]) +
                         static_cast<double>(image.rgb[3 * i + 2])) /
                        3;
    values[i] = std::isfinite(mean) ? std::max(mean, 0.0) : 0.0;
  }
  return values;
}

std::vector<Class> classes_of(const RadianceImage& image) {
  const std::vector<double> bright = brightness_of(image);
  const double square = std::inner_product(bright.begin(), bright.end(), bright.begin(), 0.0);
  const double rms = std::sqrt(square / static_cast<double>(bright.size()));
  std::vector<Class> classes(bright.size());
  const auto at = [&](int x, int y) {
    x = std::clamp(x, 0, image.width - 1);
    y = std::clamp(y, 0, image.height - 1);
    return bright[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)];
  };
  std::size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i) {
      const double here = bright[i];
      double step = 0;
      for (const double beside : {at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)}) {
        step = std::max(step, std::abs(beside - here));
      }
      const auto level = [](const auto& edges, double value) {
        return static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), value) - edges.begin());
      };
      const double contrast = rms > 0 ? step / rms : 0;
      classes[i].stratum = static_cast<std::uint8_t>(level(kContrast, contrast) * (kBrightness.size() + 1) +
                                                     level(kBrightness, rms > 0 ? here / rms : 0));
      classes[i].light = here * here;
      classes[i].step = step * step;
    }
  }
  return classes;
}

// Returns how many pixels to draw from each stratum: kDrawnLeast, plus the rest in thirds by numbers of pixels, by
// light and by steps, because the squared error is probably proportional to one of them. At most all pixels of a
// stratum are drawn.
std::vector<std::int64_t> allocation(const std::vector<std::int64_t>& pixels, const std::vector<double>& light,
                                     const std::vector<double>& step, std::int64_t count) {
  std::vector<std::int64_t> drawn(pixels.size());
  std::int64_t left = count;
  for (std::size_t h = 0; h < pixels.size(); ++h) left -= drawn[h] = std::min(pixels[h], kDrawnLeast);
  const double all_pixels = static_cast<double>(std::accumulate(pixels.begin(), pixels.end(), std::int64_t{0}));
  const double all_light = std::accumulate(light.begin(), light.end(), 0.0);
  const double all_step = std::accumulate(step.begin(), step.end(), 0.0);
  std::vector<double> share(pixels.size());
  for (std::size_t h = 0; h < pixels.size(); ++h) {
    share[h] = static_cast<double>(pixels[h]) / all_pixels + (all_light > 0 ? light[h] / all_light : 0) +
               (all_step > 0 ? step[h] / all_step : 0);
  }
  // Shares that exceed a stratum go to the others.
  for (std::size_t round = 0; left > 0 && round < pixels.size(); ++round) {
    double open = 0;
    for (std::size_t h = 0; h < pixels.size(); ++h) open += drawn[h] < pixels[h] ? share[h] : 0;
    if (!(open > 0)) break;
    const auto to_give = static_cast<double>(left);
    for (std::size_t h = 0; h < pixels.size(); ++h) {
      if (drawn[h] == pixels[h]) continue;
      const auto wanted = static_cast<std::int64_t>(to_give * share[h] / open);
      const std::int64_t more = std::min(wanted, pixels[h] - drawn[h]);
      drawn[h] += more;
      left -= more;
    }
  }
  return drawn;
}

double square(double x) { return x * x; }

}  // namespace

PixelSample sample_pixels(const RadianceImage& pilot, int count, std::uint64_t seed) {
  const std::size_t all = pilot.rgb.size() / 3;
  FL_CHECK_GT(count, 0);
  FL_CHECK_GT(all, std::size_t{0});
  PixelSample sample;
  if (static_cast<std::size_t>(count) >= all) {
    sample.whole = true;
    sample.strata = {{static_cast<std::int64_t>(all), static_cast<std::int64_t>(all)}};
    sample.pixels.resize(all);
    std::iota(sample.pixels.begin(), sample.pixels.end(), 0u);
    sample.stratum.resize(all);
    return sample;
  }
  const std::vector<Class> classes = classes_of(pilot);
  using Drawn = std::pair<std::uint64_t, std::uint32_t>;  // random number, pixel
  std::array<std::vector<Drawn>, kStrata> members;
  std::vector<double> light(kStrata), step(kStrata);
  for (std::size_t i = 0; i < all; ++i) {
    members[classes[i].stratum].emplace_back(random_of(seed, i), static_cast<std::uint32_t>(i));
    light[classes[i].stratum] += classes[i].light;
    step[classes[i].stratum] += classes[i].step;
  }
  std::vector<std::int64_t> pixels(kStrata);
  for (std::size_t h = 0; h < kStrata; ++h) pixels[h] = static_cast<std::int64_t>(members[h].size());
  const std::vector<std::int64_t> drawn = allocation(pixels, light, step, count);
  std::vector<std::pair<Drawn, std::uint8_t>> chosen;
  for (std::size_t h = 0; h < kStrata; ++h) {
    if (pixels[h] == 0) continue;
    const auto end = members[h].begin() + drawn[h];
    if (end != members[h].end()) std::nth_element(members[h].begin(), end, members[h].end());
    for (auto one = members[h].begin(); one != end; ++one) {
      chosen.emplace_back(*one, static_cast<std::uint8_t>(sample.strata.size()));
    }
    sample.strata.push_back({pixels[h], drawn[h]});
  }
  std::sort(chosen.begin(), chosen.end());
  for (const auto& [one, stratum] : chosen) {
    sample.pixels.push_back(one.second);
    sample.stratum.push_back(stratum);
  }
  return sample;
}

SampledNorms sampled_norms(const PixelSample& sample, std::span<const float> picture,
                           std::span<const double> reference) {
  FL_CHECK_EQ(picture.size(), 3 * sample.pixels.size());
  FL_CHECK_EQ(reference.size(), picture.size());
  SampledNorms result;
  if (sample.whole) {
    result.norms = picture_norms(picture, reference);
    result.rel_l2_low = result.rel_l2_high = result.norms.rel_l2;
    return result;
  }
  const std::size_t count = sample.pixels.size();
  PictureNorms& norms = result.norms;
  double values = 0;  // of the picture, 3 per pixel
  for (const auto& stratum : sample.strata) values += 3 * static_cast<double>(stratum.pixels);
  double mean = 0;
  for (std::size_t v = 0; v < reference.size(); ++v) mean += sample.weight(v / 3) * reference[v] / values;

  std::vector<double> errors(count), squares(count);  // per pixel, over its channels
  std::vector<std::pair<double, double>> relative;    // error, weight
  relative.reserve(reference.size());
  double error_total = 0;
  double square_total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double weight = sample.weight(i);
    for (std::size_t v = 3 * i; v < 3 * i + 3; ++v) {
      const double r = reference[v];
      double x = static_cast<double>(picture[v]);
      if (!std::isfinite(x)) {
        ++norms.nonfinite;
        x = 0;
      }
      const double difference = x - r;
      const auto over = [&](double scale) {
        return difference == 0 ? 0.0
               : scale > 0     ? std::abs(difference) / scale
                               : std::numeric_limits<double>::infinity();
      };
      errors[i] += square(difference);
      squares[i] += square(r);
      norms.rel_mse += weight * square(over(std::sqrt(r * r + 1e-2 * mean * mean))) / values;
      relative.emplace_back(over(r + 1e-2 * mean), weight);
    }
    error_total += weight * errors[i];
    square_total += weight * squares[i];
  }
  std::sort(relative.begin(), relative.end());
  // The smallest error with at least `share` of the picture's values at or below it.
  const auto percentile = [&](double share) {
    double below = 0;
    for (const auto& [error, weight] : relative) {
      below += weight;
      if (below >= share * values * (1 - 1e-12)) return error;
    }
    return relative.back().first;
  };
  norms.p50 = percentile(0.5);
  norms.p99 = percentile(0.99);
  norms.p999 = percentile(0.999);
  norms.max = relative.back().first;
  if (error_total == 0) return result;
  if (!(square_total > 0)) {
    norms.rel_l2 = result.rel_l2_low = result.rel_l2_high = std::numeric_limits<double>::infinity();
    return result;
  }
  const double ratio = error_total / square_total;
  norms.rel_l2 = std::sqrt(ratio);

  // Relative to the ratio.
  std::vector<double> residual_mean(sample.strata.size()), residual_square(sample.strata.size());
  const auto residual = [&](std::size_t i) { return (errors[i] - ratio * squares[i]) / error_total; };
  for (std::size_t i = 0; i < count; ++i) {
    residual_mean[sample.stratum[i]] += residual(i) / static_cast<double>(sample.strata[sample.stratum[i]].drawn);
  }
  for (std::size_t i = 0; i < count; ++i) {
    residual_square[sample.stratum[i]] += square(residual(i) - residual_mean[sample.stratum[i]]);
  }
  double variance = 0;
  double freedom = 0;
  for (std::size_t h = 0; h < sample.strata.size(); ++h) {
    const auto [all, drawn] =
        std::pair(static_cast<double>(sample.strata[h].pixels), static_cast<double>(sample.strata[h].drawn));
    if (!(drawn < all)) continue;
    const double of_stratum = all * all * (1 - drawn / all) * residual_square[h] / ((drawn - 1) * drawn);
    variance += of_stratum;
    freedom += square(of_stratum) / (drawn - 1);
  }
  if (!(variance > 0)) {
    result.rel_l2_low = result.rel_l2_high = norms.rel_l2;
    return result;
  }
  const boost::math::students_t student(std::max(square(variance) / freedom, 1.0));
  const double half = boost::math::quantile(student, 0.975) * std::sqrt(variance);
  result.rel_l2_low = norms.rel_l2 * std::exp(-half / 2);
  result.rel_l2_high = norms.rel_l2 * std::exp(half / 2);
  return result;
}

}  // namespace footlight::render
