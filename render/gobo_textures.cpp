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

// Four bytes a texel. Most gobos are grey, and the power of srgb_of() takes most of the time.
void add_texels(const std::vector<float>& image, std::vector<std::uint8_t>& texels) {
  const std::size_t first = texels.size();
  texels.resize(first + image.size() / 3 * 4);
  std::uint8_t* out = texels.data() + first;
  for (std::size_t i = 0; i < image.size(); i += 3, out += 4) {
    out[0] = srgb_of(image[i]);
    out[1] = image[i + 1] == image[i] ? out[0] : srgb_of(image[i + 1]);
    out[2] = image[i + 2] == image[i] ? out[0] : srgb_of(image[i + 2]);
    out[3] = 255;
  }
}

}  // namespace

GoboTexels read_gobos(const std::vector<fixtures::ImageSource>& images, int size_px) {
  GoboTexels read;
  read.size_px = images.empty() ? 1 : size_px;
  read.layers = static_cast<std::uint32_t>(std::max<std::size_t>(images.size(), 1));
  while (read.size_px >> read.levels > 0) ++read.levels;
  fixtures::ImageBudget budget;
  for (std::uint32_t layer = 0; layer < read.layers; ++layer) {
    std::vector<float> image(3, 1.0f);
    if (!images.empty() && images[layer].changes) {
      image.assign(static_cast<std::size_t>(3) * static_cast<std::size_t>(read.size_px * read.size_px), 0.0f);
    } else if (!images.empty()) {
      auto texels = fixtures::gobo_texels(images[layer], read.size_px, kGoboEdge, &budget);
      if (texels) {
        image = std::move(*texels);
      } else {
        image = fixtures::stand_in_texels(layer, read.size_px, kGoboEdge);
        read.troubles.push_back(fixtures::image_trouble(texels.error()));
      }
    }
    int level_size = read.size_px;
    for (std::uint32_t level = 0; level < read.levels; ++level) {
      VkBufferImageCopy region{};
      region.bufferOffset = read.texels.size();
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, layer, 1};
      region.imageExtent = {static_cast<std::uint32_t>(level_size), static_cast<std::uint32_t>(level_size), 1};
      read.regions.push_back(region);
      const std::size_t first = read.texels.size();
      add_texels(image, read.texels);
      if (level == 0) {
        read.planes.push_back(1);
        for (std::size_t i = first; i < read.texels.size(); i += 4) {
          const std::uint8_t* texel = read.texels.data() + i;
          if (texel[1] != texel[0] || texel[2] != texel[0]) read.planes.back() = 3;
        }
      }
      if (level_size > 1) image = halved(image, level_size);
      level_size /= 2;
    }
  }
  return read;
}

Status check_gobos(const vk::Device& device, std::size_t images) {
  const std::uint32_t layers_max = device.limits().maxImageArrayLayers;
  if (images <= layers_max) return {};
  return fail(ErrorCode::kBadInput, "{} gobo images: expected at most {} on {}", images, layers_max, device.name());
}

Result<vk::Image> make_gobos(vk::Device& device, const GoboTexels& read) {
  const auto size = static_cast<std::uint32_t>(read.size_px);
  FL_ASSIGN(vk::Image image,
            vk::Image::create(device, size, size, VK_FORMAT_R8G8B8A8_SRGB,
                              VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, read.layers, read.levels));
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device, read.texels.size(), 0));
  std::memcpy(staging.mapped, read.texels.data(), read.texels.size());
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(read.regions.size()), read.regions.data());
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }));
  return image;
}

}  // namespace footlight::render
