// Where the levels of the glare's pyramid are in their image, and the light of a picture with them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/image.h"
#include "render/settings.h"
#include "render/vk/memory.h"

namespace footlight::render {

struct GlareLevel {
  int x = 0;  // of its first pixel in the image; FL_GLARE_MARGIN pixels before it are the level's as well
  int y = 0;
  int width = 0;  // without margins
  int height = 0;
};

// Level 0 is the screen, which is not in the image; each level has half the pixels a side of the one before, rounded
// up. The first row of the image has the share of the light that stays in place, and then the weights of the levels.
// Below are the first level, and below that all others side by side.
struct GlareShape {
  std::vector<GlareLevel> levels;
  int width = 0;  // of the image
  int height = 0;
  [[nodiscard]] std::uint64_t bytes() const;  // of the image
};
[[nodiscard]] GlareShape glare_shape(const FrameSettings& settings);

[[nodiscard]] Result<vk::Image> make_glare_image(vk::Device& device, const GlareShape& shape);

// What the tone map gets for a picture of the screen's size. rgba: the image of the pyramid, when it is finished.
[[nodiscard]] RadianceImage with_glare(const RadianceImage& light, const GlareShape& shape,
                                       std::span<const float> rgba);

}  // namespace footlight::render
