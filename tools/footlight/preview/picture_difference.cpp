#include "tools/footlight/preview/picture_difference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sim/core/check.h"

namespace footlight::tools {
namespace {

struct Stop {
  double at;  // square root of the difference
  DifferenceColour colour;
};
constexpr std::array<Stop, 6> kStops{{{0, {0, 0, 0}},
                                      {0.2, {0.13f, 0.1f, 0.55f}},
                                      {0.45, {0.6f, 0.1f, 0.55f}},
                                      {0.65, {0.9f, 0.3f, 0.2f}},
                                      {0.85, {1, 0.8f, 0.15f}},
                                      {1, {1, 1, 1}}}};

std::array<std::array<std::uint8_t, 4>, 256> make_colours() {
  std::array<std::array<std::uint8_t, 4>, 256> colours{};
  const auto byte_of = [](float value) { return static_cast<std::uint8_t>(std::lround(value * 255)); };
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const DifferenceColour colour = colour_of_difference(static_cast<double>(i) / 255);
    colours[i] = {byte_of(colour.r), byte_of(colour.g), byte_of(colour.b), 255};
  }
  return colours;
}

}  // namespace

DifferenceColour colour_of_difference(double difference) {
  const double at = std::sqrt(std::clamp(difference, 0.0, 1.0));
  std::size_t next = 1;
  while (next + 1 < kStops.size() && kStops[next].at < at) ++next;
  const Stop& low = kStops[next - 1];
  const Stop& high = kStops[next];
  const auto share = static_cast<float>((at - low.at) / (high.at - low.at));
  const auto between = [share](float from, float to) { return from + (to - from) * share; };
  return {between(low.colour.r, high.colour.r), between(low.colour.g, high.colour.g),
          between(low.colour.b, high.colour.b)};
}

PictureDifference difference_of(const HostPicture& a, const HostPicture& b, std::vector<std::uint8_t>& rgba) {
  static const auto kColours = make_colours();
  FL_CHECK(a.width == b.width && a.height == b.height);
  const std::size_t pixels = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height);
  rgba.resize(pixels * 4);
  int largest = 0;
  std::uint64_t sum = 0;
  const std::uint8_t* const from = a.rgba.data();
  const std::uint8_t* const to = b.rgba.data();
  for (std::size_t i = 0; i < pixels * 4; i += 4) {
    const int red = std::abs(from[i] - to[i]);
    const int green = std::abs(from[i + 1] - to[i + 1]);
    const int blue = std::abs(from[i + 2] - to[i + 2]);
    const int most = std::max({red, green, blue});
    largest = std::max(largest, most);
    sum += static_cast<std::uint64_t>(most);
    std::copy_n(kColours[static_cast<std::size_t>(most)].data(), 4, rgba.data() + i);
  }
  return {largest / 255.0, pixels > 0 ? static_cast<double>(sum) / 255 / static_cast<double>(pixels) : 0};
}

}  // namespace footlight::tools
