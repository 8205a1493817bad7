#include "tools/footlight/preview/preview_flashes.h"

#include <cstddef>
#include <cstring>

namespace footlight::tools {
namespace {

constexpr VkDeviceSize kSmallBytes = VkDeviceSize{kFlashWidth} * kFlashHeight * 4;

}  // namespace

Result<std::unique_ptr<PreviewFlashes>> PreviewFlashes::make(render::vk::Device& device, bool limit) {
  std::unique_ptr<PreviewFlashes> made(new PreviewFlashes(limit));
  FL_ASSIGN(made->small_, render::vk::Image::create(device, kFlashWidth, kFlashHeight, VK_FORMAT_R8G8B8A8_UNORM,
                                                    VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                                        VK_IMAGE_USAGE_SAMPLED_BIT));
  FL_ASSIGN(made->pixels_, render::vk::Buffer::host_visible(device, kSmallBytes, 0));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    render::vk::change_layout(commands, made->small_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  }));
  return made;
}

void PreviewFlashes::record_read(VkCommandBuffer commands, VkImage picture, int width, int height) {
  render::vk::full_barrier(commands);
  VkImageBlit blit{};
  blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  blit.srcOffsets[1] = {width, height, 1};
  blit.dstSubresource = blit.srcSubresource;
  blit.dstOffsets[1] = {kFlashWidth, kFlashHeight, 1};
  vkCmdBlitImage(commands, picture, VK_IMAGE_LAYOUT_GENERAL, small_.handle, VK_IMAGE_LAYOUT_GENERAL, 1, &blit,
                 VK_FILTER_LINEAR);
  render::vk::full_barrier(commands);
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = {kFlashWidth, kFlashHeight, 1};
  vkCmdCopyImageToBuffer(commands, small_.handle, VK_IMAGE_LAYOUT_GENERAL, pixels_.handle, 1, &copy);
  render::vk::host_barrier(commands);
}

void PreviewFlashes::set_limits(bool limit) {
  if (limit && !limit_) watch_.hold_from_here();
  limit_ = limit;
}

render::ScreenImage PreviewFlashes::small() const {
  render::ScreenImage image{kFlashWidth, kFlashHeight, {}};
  image.rgba.resize(static_cast<std::size_t>(kSmallBytes));
  std::memcpy(image.rgba.data(), pixels_.mapped, image.rgba.size());
  return image;
}

bool PreviewFlashes::take(DurationNs at_ns) {
  render::ScreenImage image = small();
  return watch_.check(at_ns, image);
}

bool PreviewFlashes::must_wait(DurationNs at_ns) { return watch_.must_wait(at_ns, small()); }

}  // namespace footlight::tools
