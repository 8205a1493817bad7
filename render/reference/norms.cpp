#include "render/reference/norms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "fixtures/model/srgb.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

// The smallest sorted value with at least `share` of the values at or below it.
double percentile(const std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

// ---- FLIP ----

using Triple = std::array<double, 3>;

// One value per pixel, rows from the top; reads outside return the nearest pixel.
struct Plane {
  int width = 0;
  int height = 0;
  std::vector<double> value;

  Plane(int w, int h) : width(w), height(h), value(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  double& at(int x, int y) {
    return value[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
  double at(int x, int y) const {
    const int cx = std::clamp(x, 0, width - 1);
    const int cy = std::clamp(y, 0, height - 1);
    return value[static_cast<std::size_t>(cy) * static_cast<std::size_t>(width) + static_cast<std::size_t>(cx)];
  }
};

// A kernel of odd size, centred.
using Kernel = std::vector<double>;

Plane convolved(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
  const auto convolve = [](const Plane& from, const Kernel& kernel, int step_x, int step_y) {
    Plane out(from.width, from.height);
    const int radius = static_cast<int>(kernel.size() / 2);
    for (int y = 0; y < from.height; ++y) {
      for (int x = 0; x < from.width; ++x) {
        double sum = 0;
        for (int i = -radius; i <= radius; ++i) {
          sum += kernel[static_cast<std::size_t>(i + radius)] * from.at(x + i * step_x, y + i * step_y);
        }
        out.at(x, y) = sum;
      }
    }
    return out;
  };
  return convolve(convolve(in, along_x, 1, 0), along_y, 0, 1);
}

constexpr Triple kWhite{0.950428545, 1.0, 1.088900371};  // XYZ of linear Rec. 709 (1, 1, 1)

Triple xyz_of_linear(const Triple& c) {
  return {0.412386564 * c[0] + 0.357591490 * c[1] + 0.180450491 * c[2],
          0.212636821 * c[0] + 0.715182981 * c[1] + 0.072180196 * c[2],
          0.019330620 * c[0] + 0.119197163 * c[1] + 0.950372587 * c[2]};
}

Triple linear_of_xyz(const Triple& c) {
  return {3.241003275 * c[0] - 1.537398934 * c[1] - 0.498615861 * c[2],
          -0.969224334 * c[0] + 1.875930071 * c[1] + 0.041554224 * c[2],
          0.055639423 * c[0] - 0.204011202 * c[1] + 1.057148933 * c[2]};
}

// The opponent space in which contrast sensitivity is defined: luminance, red-green, blue-yellow.
Triple opponent_of_linear(const Triple& c) {
  const Triple xyz = xyz_of_linear(c);
  const double x = xyz[0] / kWhite[0];
  const double y = xyz[1] / kWhite[1];
  const double z = xyz[2] / kWhite[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Triple linear_of_opponent(const Triple& c) {
  const double y = (c[0] + 16) / 116;
  return linear_of_xyz({(y + c[1] / 500) * kWhite[0], y * kWhite[1], (y - c[2] / 200) * kWhite[2]});
}

// CIELAB with the chroma scaled by the lightness (Hunt effect).
Triple hunt_lab_of_linear(const Triple& c) {
  const Triple xyz = xyz_of_linear(c);
  const auto f = [](double t) {
    constexpr double kKnee = 6.0 / 29;
    return t > kKnee * kKnee * kKnee ? std::cbrt(t) : t / (3 * kKnee * kKnee) + 4.0 / 29;
  };
  const double fx = f(xyz[0] / kWhite[0]);
  const double fy = f(xyz[1] / kWhite[1]);
  const double fz = f(xyz[2] / kWhite[2]);
  const double lightness = 116 * fy - 16;
  return {lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)};
}

double hyab(const Triple& a, const Triple& b) { return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]); }

// A term a sqrt(pi / b) exp(-pi^2 x^2 / b) of a channel's contrast sensitivity, x in degrees.
struct Sensitivity {
  double a;
  double b;
};

// Filters a channel by the contrast sensitivity of the eye. The kernel is a sum of two round Gaussians, scaled to sum
// 1.
Plane resolved(const Plane& in, std::array<Sensitivity, 2> terms, double pixels_per_degree) {
  constexpr double kWidestB = 0.04;
  constexpr double kPi = std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(kWidestB / (2 * kPi * kPi)) * pixels_per_degree));
  Plane out(in.width, in.height);
  double total = 0;
  for (const Sensitivity& term : terms) {
    if (term.a == 0) continue;
    Kernel kernel;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
      const double x = i / pixels_per_degree;
      kernel.push_back(std::exp(-kPi * kPi * x * x / term.b));
      sum += kernel.back();
    }
    const double height = term.a * std::sqrt(kPi / term.b);
    total += height * sum * sum;
    const Plane blurred = convolved(in, kernel, kernel);
    for (std::size_t i = 0; i < out.value.size(); ++i) out.value[i] += height * blurred.value[i];
  }
  for (double& v : out.value) v /= total;
  return out;
}

struct Features {
  Plane edges;
  Plane points;
};

// Strengths of edges and points, from luminance 0 to 1: first and second derivatives of a Gaussian.
Features features_of(const Plane& luminance, double pixels_per_degree) {
  constexpr double kFeatureDegrees = 0.082;
  const double sigma = 0.5 * kFeatureDegrees * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  Kernel smooth, first, second;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-i * i / (2 * sigma * sigma));
    smooth.push_back(g);
    first.push_back(-i * g);
    second.push_back((i * i / (sigma * sigma) - 1) * g);
  }
  // Scales the positive weights of the two-dimensional kernel to sum 1 and the negative ones to sum -1.
  const auto balance = [&](Kernel& kernel) {
    double positive = 0;
    double negative = 0;
    double across = 0;
    for (const double k : kernel) (k > 0 ? positive : negative) += k;
    for (const double g : smooth) across += g;
    for (double& k : kernel) k /= k > 0 ? positive * across : -negative * across;
  };
  balance(first);
  balance(second);
  const auto strength = [&](const Kernel& kernel) {
    Plane along_x = convolved(luminance, kernel, smooth);
    const Plane along_y = convolved(luminance, smooth, kernel);
    for (std::size_t i = 0; i < along_x.value.size(); ++i) {
      along_x.value[i] = std::hypot(along_x.value[i], along_y.value[i]);
    }
    return along_x;
  };
  return {strength(first), strength(second)};
}

struct Seen {
  std::vector<Triple> lab;
  Features features;
};

Seen seen(int width, int height, std::span<const float> linear, double pixels_per_degree) {
  std::array<Plane, 3> opponent{Plane(width, height), Plane(width, height), Plane(width, height)};
  Plane luminance(width, height);
  for (std::size_t i = 0; i < luminance.value.size(); ++i) {
    Triple c;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<double>(linear[3 * i + k]);
      c[k] = v > 0 ? std::min(v, 1.0) : 0.0;  // NaN is black
    }
    const Triple o = opponent_of_linear(c);
    for (std::size_t k = 0; k < 3; ++k) opponent[k].value[i] = o[k];
    luminance.value[i] = (o[0] + 16) / 116;
  }
  Features features = features_of(luminance, pixels_per_degree);
  opponent[0] = resolved(opponent[0], {{{1, 0.0047}, {0, 1e-5}}}, pixels_per_degree);
  opponent[1] = resolved(opponent[1], {{{1, 0.0053}, {0, 1e-5}}}, pixels_per_degree);
  opponent[2] = resolved(opponent[2], {{{34.1, 0.04}, {13.5, 0.025}}}, pixels_per_degree);
  std::vector<Triple> lab(luminance.value.size());
  for (std::size_t i = 0; i < lab.size(); ++i) {
    Triple c = linear_of_opponent({opponent[0].value[i], opponent[1].value[i], opponent[2].value[i]});
    for (double& v : c) v = std::clamp(v, 0.0, 1.0);
    lab[i] = hunt_lab_of_linear(c);
  }
  return {std::move(lab), std::move(features)};
}

}  // namespace

PictureNorms picture_norms(std::span<const float> picture, std::span<const double> reference) {
  FL_CHECK_EQ(picture.size(), reference.size());
  FL_CHECK(!picture.empty());
  const auto count = static_cast<double>(picture.size());
  PictureNorms norms;
  double mean = 0;
  for (const double r : reference) mean += r / count;
  std::vector<double> relative(picture.size());
  double error_square = 0;
  double reference_square = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double r = reference[i];
    double x = static_cast<double>(picture[i]);
    if (!std::isfinite(x)) {
      ++norms.nonfinite;
      x = 0;
    }
    const double difference = x - r;
    // 0 over 0 counts as equal, also in a reference that is all black.
    const auto over = [&](double scale) {
      return difference == 0 ? 0.0 : scale > 0 ? std::abs(difference) / scale : std::numeric_limits<double>::infinity();
    };
    error_square += difference * difference;
    reference_square += r * r;
    const double share = over(std::sqrt(r * r + 1e-2 * mean * mean));
    norms.rel_mse += share * share / count;
    relative[i] = over(r + 1e-2 * mean);
  }
  norms.rel_l2 = error_square == 0      ? 0
                 : reference_square > 0 ? std::sqrt(error_square / reference_square)
                                        : std::numeric_limits<double>::infinity();
  std::sort(relative.begin(), relative.end());
  norms.p50 = percentile(relative, 0.5);
  norms.p99 = percentile(relative, 0.99);
  norms.p999 = percentile(relative, 0.999);
  norms.max = relative.back();
  return norms;
}

PictureNorms picture_norms(const RadianceImage& picture, const RadianceImage& reference) {
  FL_CHECK_EQ(picture.width, reference.width);
  FL_CHECK_EQ(picture.height, reference.height);
  const std::vector<double> wide(reference.rgb.begin(), reference.rgb.end());
  return picture_norms(picture.rgb, wide);
}

FlipMap flip_linear(int width, int height, std::span<const float> a, std::span<const float> b,
                    double pixels_per_degree) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  FL_CHECK_GT(pixels, std::size_t{0});
  FL_CHECK_EQ(a.size(), 3 * pixels);
  FL_CHECK_EQ(b.size(), 3 * pixels);
  FL_CHECK_GT(pixels_per_degree, 0.0);
  const Seen first = seen(width, height, a, pixels_per_degree);
  const Seen second = seen(width, height, b, pixels_per_degree);

  // Exponents and knees of the paper. The largest colour distance on a screen is green against blue.
  constexpr double kColourPower = 0.7;
  constexpr double kFeaturePower = 0.5;
  constexpr double kKneeAt = 0.4;
  constexpr double kKneeValue = 0.95;
  const double largest = std::pow(hyab(hunt_lab_of_linear({0, 1, 0}), hunt_lab_of_linear({0, 0, 1})), kColourPower);
  const double knee = kKneeAt * largest;

  FlipMap map{width, height, std::vector<float>(pixels), 0};
  for (std::size_t i = 0; i < pixels; ++i) {
    const double distance = std::pow(hyab(first.lab[i], second.lab[i]), kColourPower);
    const double colour = distance < knee ? kKneeValue / knee * distance
                                          : kKneeValue + (distance - knee) / (largest - knee) * (1 - kKneeValue);
    const double edge = std::abs(first.features.edges.value[i] - second.features.edges.value[i]);
    const double point = std::abs(first.features.points.value[i] - second.features.points.value[i]);
    const double feature = std::pow(std::max(edge, point) / std::numbers::sqrt2, kFeaturePower);
    const double value = std::pow(std::clamp(colour, 0.0, 1.0), 1 - std::clamp(feature, 0.0, 1.0));
    map.value[i] = static_cast<float>(value);
    map.mean += value / static_cast<double>(pixels);
  }
  return map;
}

FlipMap flip(const ScreenImage& a, const ScreenImage& b, double pixels_per_degree) {
  FL_CHECK_EQ(a.width, b.width);
  FL_CHECK_EQ(a.height, b.height);
  const auto linear = [](const ScreenImage& image) {
    std::vector<float> values;
    values.reserve(image.rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < image.rgba.size(); ++i) {
      if (i % 4 == 3) continue;
      values.push_back(static_cast<float>(fixtures::linear_of_srgb(image.rgba[i] / 255.0)));
    }
    return values;
  };
  return flip_linear(a.width, a.height, linear(a), linear(b), pixels_per_degree);
}

}  // namespace footlight::render
