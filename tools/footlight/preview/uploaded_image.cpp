#include "tools/footlight/preview/uploaded_image.h"

#include <cstring>

namespace footlight::tools {
namespace {

namespace vk = render::vk;

}  // namespace

Status UploadedImage::set(vk::Device& device, const HostPicture& picture) {
  if (picture.width != width_ || picture.height != height_) {
    bytes_ = {};  // freed first
    image_ = {};
    width_ = height_ = 0;
    FL_ASSIGN(bytes_, vk::Buffer::host_visible(device, picture.rgba.size(), 0));
    FL_ASSIGN(image_, vk::Image::create(device, static_cast<std::uint32_t>(picture.width),
                                        static_cast<std::uint32_t>(picture.height), VK_FORMAT_R8G8B8A8_UNORM,
                                        VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                            VK_IMAGE_USAGE_SAMPLED_BIT));
    width_ = picture.width;
    height_ = picture.height;
  }
  std::memcpy(bytes_.mapped, picture.rgba.data(), picture.rgba.size());
  fresh_ = true;
  return {};
}

HostPicture UploadedImage::picture() const {
  if (bytes_.mapped == nullptr) return {};
  const std::size_t bytes = std::size_t{4} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  return {{static_cast<const std::uint8_t*>(bytes_.mapped), bytes}, width_, height_};
}

void UploadedImage::record(VkCommandBuffer commands) {
  if (!fresh_) return;
  fresh_ = false;
  vk::change_layout(commands, image_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {static_cast<std::uint32_t>(width_), static_cast<std::uint32_t>(height_), 1};
  vkCmdCopyBufferToImage(commands, bytes_.handle, image_.handle, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
  vk::full_barrier(commands);
}

}  // namespace footlight::tools
