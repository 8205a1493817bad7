#include <algorithm>
#include <cmath>

#include "render/beam.h"
#include "render/image.h"

namespace footlight::render {

View view_of(const fixtures::Camera& camera) {
  View view;
  view.position_m = camera.position_m;
  const glm::dvec3 way = camera.target_m - camera.position_m;
  view.forward = glm::length(way) > 1e-9 ? glm::normalize(way) : glm::dvec3(0, 1, 0);
  const glm::dvec3 world_up = std::abs(view.forward.z) > 0.999999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  view.right = glm::normalize(glm::cross(view.forward, world_up));
  view.up = glm::cross(view.right, view.forward);
  view.tan_half_fov = std::tan(glm::radians(camera.fov_deg) / 2);
  return view;
}

double exposure_factor(double exposure_ev) { return 1.0 / (1.2 * std::exp2(exposure_ev)); }

ScreenImage screen_of(const RadianceImage& image, double exposure_ev, const Display& display) {
  ScreenImage screen{image.width, image.height, {}};
  screen.rgba.reserve(image.rgb.size() / 3 * 4);
  const auto factor = static_cast<float>(exposure_factor(exposure_ev));
  const glm::mat3 white(white_balance(display.white_k));
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const auto pixel = static_cast<std::uint32_t>(i / 3);
    const auto width = static_cast<std::uint32_t>(image.width);
    glm::vec3 exposed = glm::vec3(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]) * factor;
    if (display.white_k > 0) exposed = f32::rgb_into_gamut(white * exposed);
    const glm::vec3 shown =
        f32::dithered(f32::tone_shown(static_cast<std::uint32_t>(display.tone), exposed), pixel % width, pixel / width);
    for (int c = 0; c < 3; ++c) screen.rgba.push_back(static_cast<std::uint8_t>(std::lround(shown[c] * 255.0f)));
    screen.rgba.push_back(255);
  }
  return screen;
}

RadianceImage averaged(const RadianceImage& image, int side) {
  if (side == 1) return image;
  const int width = image.width / side;
  const int height = image.height / side;
  RadianceImage means{width, height, {}};
  means.rgb.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  const float share = 1.0f / static_cast<float>(side * side);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      glm::vec3 sum(0);
      for (int row = y * side; row < (y + 1) * side; ++row) {
        for (int column = x * side; column < (x + 1) * side; ++column) {
          const auto at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(column));
          sum += glm::vec3(image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]);
        }
      }
      for (int c = 0; c < 3; ++c) means.rgb.push_back(sum[c] * share);
    }
  }
  return means;
}

double light_range_m(const fixtures::Rig& rig, const Extent& objects) {
  if (rig.haze.reach_m > 0) return rig.haze.reach_m;
  glm::dvec3 low = objects.low_m;
  glm::dvec3 high = objects.high_m;
  for (const auto& fixture : rig.fixtures) {
    low = glm::min(low, fixture.position_m);
    high = glm::max(high, fixture.position_m);
  }
  for (const auto& box : rig.boxes) {
    low = glm::min(low, box.min_m);
    high = glm::max(high, box.max_m);
  }
  for (const auto& pane : rig.panes) {
    low = glm::min(low, pane.position_m);
    high = glm::max(high, pane.position_m);
  }
  for (const auto& display : rig.displays) {
    low = glm::min(low, display.position_m);
    high = glm::max(high, display.position_m);
  }
  const double diagonal_m = low.x <= high.x ? glm::length(high - low) : 0.0;
  return diagonal_m + 20.0;
}

}  // namespace footlight::render
