#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "render/reference/norms.h"
#include "tests/render/reference/kernel_cases.h"

namespace {

using namespace footlight::render;

// A picture of random soft blobs, linear 0 to 1.
std::vector<float> blobs(std::uint64_t seed, int width, int height) {
  cases::Random random(seed);
  std::vector<float> rgb(static_cast<std::size_t>(width * height * 3), 0.05f);
  for (int i = 0; i < 12; ++i) {
    const double x = random.uniform(0, width);
    const double y = random.uniform(0, height);
    const double size = random.uniform(2, 10);
    const glm::dvec3 colour(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    for (int py = 0; py < height; ++py) {
      for (int px = 0; px < width; ++px) {
        const double share = std::exp(-((px - x) * (px - x) + (py - y) * (py - y)) / (size * size));
        for (int c = 0; c < 3; ++c) {
          float& v = rgb[static_cast<std::size_t>((py * width + px) * 3 + c)];
          v = static_cast<float>(std::min(1.0, static_cast<double>(v) + share * colour[c]));
        }
      }
    }
  }
  return rgb;
}

std::vector<float> flat(int pixels, float r, float g, float b) {
  std::vector<float> rgb;
  for (int i = 0; i < pixels; ++i) rgb.insert(rgb.end(), {r, g, b});
  return rgb;
}

}  // namespace

TEST_CASE("equal pictures have no error in any norm") {
  const std::vector<float> picture{0, 1, 2, 3, 4, 5};
  const std::vector<double> reference{0, 1, 2, 3, 4, 5};
  const PictureNorms norms = picture_norms(picture, reference);
  CHECK(norms.rel_l2 == 0);
  CHECK(norms.rel_mse == 0);
  CHECK(norms.max == 0);
  CHECK(norms.nonfinite == 0);
}

TEST_CASE("a picture that is a hundredth too bright has a relative L2 error of a hundredth") {
  std::vector<float> picture;
  std::vector<double> reference;
  for (int i = 0; i < 3000; ++i) {
    reference.push_back(1 + i % 7);
    picture.push_back(static_cast<float>(reference.back() * 1.01));
  }
  const PictureNorms norms = picture_norms(picture, reference);
  CHECK(norms.rel_l2 == doctest::Approx(0.01).epsilon(1e-4));
  CHECK(norms.max < 0.01);
  CHECK(norms.max > 0.0099);
  CHECK(norms.rel_mse == doctest::Approx(1e-4).epsilon(0.02));
}

TEST_CASE("percentiles distinguish a rare error from a common one") {
  std::vector<double> reference(2000, 1.0);
  std::vector<float> picture(2000, 1.0f);
  picture[7] = 2.0f;  // one in 2000
  const PictureNorms rare = picture_norms(picture, reference);
  CHECK(rare.p50 == 0);
  CHECK(rare.p99 == 0);
  CHECK(rare.p999 == 0);
  CHECK(rare.max == doctest::Approx(1 / 1.01));
  for (std::size_t i = 0; i < 30; ++i) picture[i] = 2.0f;  // 15 in 1000
  const PictureNorms common = picture_norms(picture, reference);
  CHECK(common.p50 == 0);
  CHECK(common.p99 == doctest::Approx(1 / 1.01));
  CHECK(common.p999 == doctest::Approx(1 / 1.01));
}

TEST_CASE("values that are not finite are counted and do not affect the other norms") {
  const std::vector<double> reference{1, 1, 1, 1};
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> picture{std::numeric_limits<float>::quiet_NaN(), infinity, 1, 1};
  const PictureNorms norms = picture_norms(picture, reference);
  CHECK(norms.nonfinite == 2);
  CHECK(norms.rel_l2 == doctest::Approx(std::sqrt(0.5)));
  CHECK(std::isfinite(norms.max));
}

TEST_CASE("against a black reference the error of black is 0 and that of light infinite") {
  const std::vector<double> black(6, 0.0);
  CHECK(picture_norms(std::vector<float>(6, 0.0f), black).rel_l2 == 0);
  CHECK(picture_norms(std::vector<float>(6, 0.0f), black).max == 0);
  CHECK(std::isinf(picture_norms(std::vector<float>(6, 0.1f), black).rel_l2));
}

TEST_CASE("FLIP of equal pictures is 0, of others between 0 and 1, and it is symmetric") {
  const std::vector<float> a = blobs(1, 48, 32);
  const std::vector<float> b = blobs(2, 48, 32);
  CHECK(flip_linear(48, 32, a, a).mean == 0);
  const FlipMap ab = flip_linear(48, 32, a, b);
  const FlipMap ba = flip_linear(48, 32, b, a);
  CHECK(ab.mean == doctest::Approx(ba.mean).epsilon(1e-12));
  CHECK(ab.mean > 0.05);
  for (const float v : ab.value) {
    CHECK(v >= 0.0f);
    CHECK(v <= 1.0f);
  }
}

TEST_CASE("FLIP of black against white is near 1, and of two similar greys near 0") {
  const double far = flip_linear(16, 16, flat(256, 0, 0, 0), flat(256, 1, 1, 1)).mean;
  CHECK(far > 0.9);
  CHECK(far <= 1);
  const double near = flip_linear(16, 16, flat(256, 0.2f, 0.2f, 0.2f), flat(256, 0.202f, 0.202f, 0.202f)).mean;
  CHECK(near > 0);
  CHECK(near < 0.05);
}

TEST_CASE("FLIP of green against blue is the largest colour difference") {
  CHECK(flip_linear(16, 16, flat(256, 0, 1, 0), flat(256, 0, 0, 1)).mean == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("FLIP grows with the error and falls with the distance of the viewer") {
  const std::vector<float> a = flat(32 * 32, 0.5f, 0.5f, 0.5f);
  double last = 0;
  for (const float noise : {0.02f, 0.1f, 0.4f}) {
    std::vector<float> b = a;
    for (std::size_t i = 0; i < b.size(); ++i) b[i] += i / 3 % 2 == 0 ? noise : -noise;
    const double near = flip_linear(32, 32, a, b, 15).mean;
    CHECK(near > last);
    last = near;
    // From far away the eye does not resolve stripes of one pixel.
    CHECK(flip_linear(32, 32, a, b, 60).mean < near / 2);
  }
}

TEST_CASE("FLIP of screen pictures decodes sRGB") {
  ScreenImage a{8, 8, std::vector<std::uint8_t>(8 * 8 * 4, 255)};
  ScreenImage b = a;
  for (std::size_t i = 0; i < b.rgba.size(); ++i) {
    if (i % 4 != 3) b.rgba[i] = 188;  // 0.5029 linear
  }
  const double screen = flip(a, b).mean;
  CHECK(screen == doctest::Approx(flip_linear(8, 8, flat(64, 1, 1, 1), flat(64, 0.502886f, 0.502886f, 0.502886f)).mean)
                      .epsilon(1e-4));
  b = a;
  for (std::size_t i = 3; i < b.rgba.size(); i += 4) b.rgba[i] = 0;  // alpha has no effect
  CHECK(flip(a, b).mean == 0);
}
