#include "render/gobo_textures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "fixtures/gobos/gobo_images.h"
#include "fixtures/model/srgb.h"

namespace footlight::render {
namespace {

// Halves an image of three values a texel a side: the mean of four texels.
std::vector<float> halved(const std::vector<float>& image, int size) {
  const auto at = [&](int row, int column, std::size_t c) {
    return image[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                      static_cast<std::size_t>(column)) +
                 c];
  };
  std::vector<float> half;
  half.reserve(image.size() / 4);
  for (int row = 0; row < size / 2; ++row) {
    for (int column = 0; column < size / 2; ++column) {
      for (std::size_t c = 0; c < 3; ++c) {
        half.push_back((at(2 * row, 2 * column, c) + at(2 * row, 2 * column + 1, c) + at(2 * row + 1, 2 * column, c) +
                        at(2 * row + 1, 2 * column + 1, c)) /
                       4);
      }
    }
  }
  return half;
}

std::uint8_t srgb_of(float linear) {
  return static_cast<std::uint8_t>(std::lround(255.0f * fixtures::srgb_of_linear(std::clamp(linear, 0.0f, 1.0f))));
}

}  // namespace

Result<vk::Image> make_gobos(vk::Device& device, const std::vector<fixtures::ImageSource>& images, int size_px,
                             fixtures::Diagnostics& diagnostics, std::vector<std::uint32_t>& planes) {
  const int size = images.empty() ? 1 : size_px;
  const auto layers = static_cast<uint>(std::max<std::size_t>(images.size(), 1));
  const std::uint32_t layers_max = device.limits().maxImageArrayLayers;
  if (layers > layers_max) {
    return fail(ErrorCode::kBadInput, "{} gobo images: expected at most {} on {}", layers, layers_max, device.name());
  }
  uint levels = 1;
  while (size >> levels > 0) ++levels;
  std::vector<std::uint8_t> texels;
  std::vector<VkBufferImageCopy> regions;
  fixtures::ImageBudget budget;
  for (uint layer = 0; layer < layers; ++layer) {
    std::vector<float> image(3, 1.0f);
    if (!images.empty()) {
      auto read = fixtures::gobo_texels(images[layer], size, kGoboEdge, &budget);
      if (read) {
        image = std::move(*read);
      } else {
        image = fixtures::stand_in_texels(layer, size, kGoboEdge);
        diagnostics.add(fixtures::image_trouble(read.error()));
      }
    }
    planes.push_back(1);
    for (std::size_t i = 0; i < image.size(); i += 3) {
      const std::uint8_t red = srgb_of(image[i]);
      if (srgb_of(image[i + 1]) != red || srgb_of(image[i + 2]) != red) planes.back() = 3;
    }
    int level_size = size;
    for (uint level = 0; level < levels; ++level) {
      VkBufferImageCopy region{};
      region.bufferOffset = texels.size();
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, layer, 1};
      region.imageExtent = {static_cast<uint>(level_size), static_cast<uint>(level_size), 1};
      regions.push_back(region);
      for (std::size_t i = 0; i < image.size(); ++i) {
        texels.push_back(srgb_of(image[i]));
        if (i % 3 == 2) texels.push_back(255);
      }
      if (level_size > 1) image = halved(image, level_size);
      level_size /= 2;
    }
  }
  FL_ASSIGN(vk::Image image,
            vk::Image::create(device, static_cast<uint>(size), static_cast<uint>(size), VK_FORMAT_R8G8B8A8_SRGB,
                              VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, layers, levels));
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device, texels.size(), 0));
  std::memcpy(staging.mapped, texels.data(), texels.size());
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<uint>(regions.size()), regions.data());
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }));
  return image;
}

}  // namespace footlight::render
