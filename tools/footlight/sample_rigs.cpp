#include "tools/footlight/sample_rigs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/files/export/write_file.h"
#include "fixtures/gobos/png.h"

namespace footlight::tools {
namespace {

constexpr int kGlassWidth = 160, kGlassHeight = 400;

// A rose of twelve petals above rhombs, with lead between the pieces.
std::array<std::uint8_t, 3> glass_at(int column, int row) {
  constexpr std::array<std::array<std::uint8_t, 3>, 7> kColors = {
      {{214, 40, 40}, {36, 76, 200}, {240, 190, 40}, {40, 150, 80}, {120, 40, 150}, {40, 160, 200}, {240, 240, 225}}};
  constexpr std::array<std::uint8_t, 3> kLead = {8, 8, 8};
  const double x = (column + 0.5) / kGlassWidth - 0.5, y = (row + 0.5) / kGlassWidth - 0.5;
  const double radius = std::hypot(x, y);
  int piece = 0;
  double to_lead = std::min(0.5 - std::abs(x), std::min(y + 0.5, 2.0 - y));  // in widths of the pane
  if (radius < 0.47) {
    const double turn = 12 * (std::atan2(y, x) / (2 * std::numbers::pi) + 0.5);
    const int ring = radius < 0.12 ? 0 : radius < 0.3 ? 1 : 2;
    piece = ring == 0 ? 6 : ring + 2 * static_cast<int>(turn);
    for (const double edge : {0.12, 0.3, 0.47}) to_lead = std::min(to_lead, std::abs(radius - edge));
    if (ring > 0) to_lead = std::min(to_lead, std::abs(turn - std::round(turn)) * radius / 2);
  } else {
    const double a = 4 * (x + y / 2), b = 4 * (x - y / 2);
    piece = 3 + static_cast<int>(std::floor(a)) + 5 * static_cast<int>(std::floor(b));
    to_lead =
        std::min({to_lead, std::abs(a - std::round(a)) / 4, std::abs(b - std::round(b)) / 4, std::abs(radius - 0.47)});
  }
  if (to_lead < 0.008) return kLead;
  return kColors[static_cast<std::size_t>(((piece % 7) + 7) % 7)];
}

Status write_png(const std::string& path, int width, int height, std::array<std::uint8_t, 3> (*color_at)(int, int)) {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto color = color_at(column, row);
      pixels.insert(pixels.end(), color.begin(), color.end());
    }
  }
  const fixtures::Bytes png = fixtures::png_of(width, height, 3, pixels);
  return fixtures::write_file(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

constexpr int kWallWidth = 96, kWallHeight = 54;

// A sun over a grid of lines that run away, in the colours of a sunset.
std::array<std::uint8_t, 3> wall_at(int column, int row) {
  const double x = (column + 0.5) / kWallWidth - 0.5, y = (row + 0.5) / kWallHeight;
  const double radius = std::hypot(x * kWallWidth / kWallHeight, y - 0.42);
  glm::dvec3 color = glm::mix(glm::dvec3(30, 8, 70), glm::dvec3(235, 60, 90), std::min(y / 0.62, 1.0));
  const bool stripe = y > 0.4 && std::fmod(y * 22, 1.0) < (y - 0.4) * 3;
  if (radius < 0.27 && !stripe) color = glm::mix(glm::dvec3(255, 225, 90), glm::dvec3(255, 90, 110), y / 0.65);
  if (y > 0.62) {
    const double depth = 1 / (y - 0.58), across = x * depth;
    const bool line = std::abs(across - std::round(across)) < 0.06 || depth - std::floor(depth) < 0.16;
    color = line ? glm::dvec3(60, 220, 255) : glm::dvec3(12, 4, 34);
  }
  return {static_cast<std::uint8_t>(color.r), static_cast<std::uint8_t>(color.g), static_cast<std::uint8_t>(color.b)};
}

}  // namespace

Status write_glass_image(const std::string& path) { return write_png(path, kGlassWidth, kGlassHeight, glass_at); }

Status write_chapel_rig(const std::string& path) {
  return fixtures::write_file(path, R"(# Sunlight through stained glass; docs/shafts.md
[rig]
name = "Chapel"
ambient_lx = 20

[haze]
scattering_per_m = 0.02
anisotropy = 0.4

[sun]
direction = [0.3, -1, -0.75]   # in which its light travels
illuminance_lx = 60000
temperature_k = 5200
sky_lx = 6000                  # on the outside of the glass

[[pane]]
name = "Left"
position = [-4, 5, 4]
width_m = 1.6
height_m = 4
image = "glass.png"

[[pane]]
name = "Middle"
position = [0, 5, 4]
width_m = 1.6
height_m = 4
image = "glass.png"

[[pane]]
name = "Right"
position = [4, 5, 4]
width_m = 1.6
height_m = 4
image = "glass.png"

[[box]]
name = "Floor"
min = [-12, -12, -0.2]
max = [12, 12, 0]
albedo = [0.5, 0.48, 0.45]

[[box]]
name = "Wall below"
min = [-12, 5, 0]
max = [12, 5.3, 2]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Wall above"
min = [-12, 5, 6]
max = [12, 5.3, 9]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Wall left"
min = [-12, 5, 2]
max = [-4.8, 5.3, 6]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Pier left"
min = [-3.2, 5, 2]
max = [-0.8, 5.3, 6]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Pier right"
min = [0.8, 5, 2]
max = [3.2, 5.3, 6]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Wall right"
min = [4.8, 5, 2]
max = [12, 5.3, 6]
albedo = [0.4, 0.38, 0.35]

[[box]]
name = "Pillar"
min = [0.9, 1.5, 0]
max = [1.5, 2.1, 8]
albedo = [0.45, 0.43, 0.4]

[[camera]]
name = "nave"
position = [-7.5, -8, 2]
target = [0.5, 2, 2.6]
fov_deg = 60
exposure_ev = 8.5
)");
}

Status write_wall_image(const std::string& path) { return write_png(path, kWallWidth, kWallHeight, wall_at); }

Status write_wall_rig(const std::string& path) {
  return fixtures::write_file(path, R"(# LED walls with an image and with pixels from DMX; docs/displays.md
[rig]
name = "Wall"
ambient_lx = 0.3

[haze]
scattering_per_m = 0.02
anisotropy = 0.4

[[display]]
name = "Wall"
position = [0, 4, 2.9]
width_m = 6.4
height_m = 3.6
nits = 600
image = "wall.png"

[[display]]              # eight pixels high, along the edge of the stage
name = "Edge"
position = [0, -0.51, 0.4]
width_m = 8
height_m = 0.3
columns = 192
rows = 8
nits = 300
image = "wall.png"

[[display]]              # from DMX: dark without a log; the demo show has levels there
name = "Left column"
position = [-4.2, 3, 2.2]
rotation = [0, 0, 35]
width_m = 0.25
height_m = 3
columns = 4
rows = 40
nits = 2000
universe = 1
order = "rgb"
serpentine = true
start = "bottom-left"

[[display]]              # an even panel of light
name = "Panel"
position = [4.4, 2, 2.2]
rotation = [0, 0, -50]
width_m = 1
height_m = 1.6
nits = 900
color = [1, 0.75, 0.5]

[[box]]
name = "Stage"
min = [-5.5, -0.5, -0.2]
max = [5.5, 5, 0.6]
albedo = [0.12, 0.12, 0.13]

[[box]]
name = "Floor"
min = [-14, -14, -0.4]
max = [14, 8, 0]
albedo = [0.3, 0.29, 0.28]

[[box]]
name = "Back"
min = [-14, 7, 0]
max = [14, 7.2, 9]
albedo = [0.35, 0.35, 0.35]

[[scenery]]
kind = "person"
position = [-1.4, 1.6, 0.6]
rotation = [0, 0, 180]

[[scenery]]
kind = "riser"
position = [1.6, 2.6, 0.6]
width_m = 1.6
depth_m = 1
height_m = 0.6

[[camera]]
name = "front"
position = [-3.4, -8.5, 2.4]
target = [0.1, 2, 1.9]
fov_deg = 48
exposure_ev = 6
)");
}

}  // namespace footlight::tools
