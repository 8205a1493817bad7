#include "render/glare.h"

#include <algorithm>

namespace footlight::render {

std::uint64_t GlareShape::bytes() const {
  return std::uint64_t{16} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

// So many levels that the last one's Gaussian is wider than the picture: of a wider one, little stays in the picture.
GlareShape glare_shape(const FrameSettings& settings) {
  constexpr int kMargins = 2 * FL_GLARE_MARGIN;
  GlareShape shape;
  GlareLevel level{0, 0, settings.width / settings.supersample, settings.height / settings.supersample};
  shape.levels.push_back(level);
  const int largest = std::max(level.width, level.height);
  int right = 0;
  for (int side = 1; side < 2 * largest || shape.levels.size() < 3; side *= 2) {
    level.width = (level.width + 1) / 2;
    level.height = (level.height + 1) / 2;
    const bool first = shape.levels.size() == 1;
    level.x = first ? FL_GLARE_MARGIN : right + FL_GLARE_MARGIN;
    level.y = first ? 1 + FL_GLARE_MARGIN : 1 + shape.levels[1].height + kMargins + FL_GLARE_MARGIN;
    if (!first) right += level.width + kMargins;
    shape.width = std::max({shape.width, right, level.width + kMargins, FL_GLARE_WEIGHTS});
    shape.height = std::max(shape.height, level.y + level.height + FL_GLARE_MARGIN);
    shape.levels.push_back(level);
  }
  return shape;
}

Result<vk::Image> make_glare_image(vk::Device& device, const GlareShape& shape) {
  FL_ASSIGN(vk::Image image, vk::Image::create(device, static_cast<std::uint32_t>(shape.width),
                                               static_cast<std::uint32_t>(shape.height), VK_FORMAT_R32G32B32A32_SFLOAT,
                                               VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  }));
  return image;
}

RadianceImage with_glare(const RadianceImage& light, const GlareShape& shape, std::span<const float> rgba) {
  const auto at = [&](int x, int y, int c) {
    const auto texel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(shape.width) + static_cast<std::size_t>(x);
    return rgba[4 * texel + static_cast<std::size_t>(c)];
  };
  const GlareLevel& first = shape.levels[1];
  RadianceImage seen = light;
  std::size_t i = 0;
  for (int y = 0; y < light.height; ++y) {
    const int own_y = first.y + y / 2;
    const int near_y = own_y + 2 * (y % 2) - 1;
    for (int x = 0; x < light.width; ++x) {
      const int own_x = first.x + x / 2;
      const int near_x = own_x + 2 * (x % 2) - 1;
      for (int c = 0; c < 3; ++c, ++i) {
        const float row = 0.75f * at(own_x, own_y, c) + 0.25f * at(near_x, own_y, c);
        const float next = 0.75f * at(own_x, near_y, c) + 0.25f * at(near_x, near_y, c);
        seen.rgb[i] = at(0, 0, 0) * light.rgb[i] + 0.75f * row + 0.25f * next;
      }
    }
  }
  return seen;
}

}  // namespace footlight::render
