// Pictures and the point of view they are taken from.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "render/display.h"
#include "render/frame_io.h"

namespace footlight::render {

// Scene-linear radiance in cd/m^2 per channel, Rec. 709 primaries. Rows from the top, pixels from the left, 3 floats
// each.
struct RadianceImage {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;
};

// What a screen shows: 8 bits a channel, sRGB, 4 bytes a pixel (alpha 255), rows from the top.
struct ScreenImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

// The ray of pixel (x, y), counted from 0 at the top left, goes through its centre:
//   d = normalize(forward + right * ((2 (x + 0.5) / width - 1) * tan(fov / 2) * width / height)
//                         + up * ((1 - 2 (y + 0.5) / height) * tan(fov / 2)))
struct View {
  glm::dvec3 position_m{0};
  glm::dvec3 right{1, 0, 0};    // unit
  glm::dvec3 up{0, 0, 1};       // unit
  glm::dvec3 forward{0, 1, 0};  // unit
  double tan_half_fov = 0.5;    // vertical
};

// The picture on a screen, as the tone map pass makes it; on the CPU, in float.
[[nodiscard]] ScreenImage screen_of(const RadianceImage& image, double exposure_ev, const Display& display = {});
// One pixel for each side x side pixels: their mean, as the tone map pass takes it. side >= 1 divides width and height.
[[nodiscard]] RadianceImage averaged(const RadianceImage& image, int side);
// What the radiance is multiplied by before the tone map: the brightest luminance is 1.2 x 2^EV cd/m^2 (EV at ISO 100).
[[nodiscard]] double exposure_factor(double exposure_ev);

// Z up; a camera that looks straight up or down has +y as the top of its picture.
[[nodiscard]] View view_of(const fixtures::Camera& camera);

// Air is seen as far as this from the camera: there is no end before the light's.
inline constexpr double kAirRangeM = FL_FAR_M;

// A box in stage space; nothing where low > high.
struct Extent {
  glm::dvec3 low_m{1e30};
  glm::dvec3 high_m{-1e30};
};

// Light ends this far from its lens: Haze::reach_m, or the diagonal of everything in the rig plus 20 m. `objects`: what
// the scene's objects fill, where they are drawn. What it cuts off is light in the haze beyond the rig.
[[nodiscard]] double light_range_m(const fixtures::Rig& rig, const Extent& objects = {});

}  // namespace footlight::render
