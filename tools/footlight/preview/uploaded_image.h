// An image whose pixels come from the host.
//
// Threads: one. The device must outlive it.
#pragma once

#include "render/vk/memory.h"
#include "tools/footlight/preview/stage_picture.h"

namespace footlight::tools {

class UploadedImage {
 public:
  // Copies the pixels. The commands of the record() before must be finished.
  Status set(render::vk::Device& device, const HostPicture& picture);
  // Once after each set(): then image() has its pixels, in VK_IMAGE_LAYOUT_GENERAL. Else records nothing.
  void record(VkCommandBuffer commands);
  [[nodiscard]] bool is_fresh() const { return fresh_; }
  // Those of the last set(), also after the loss of the device; valid until the next one. Empty before the first.
  [[nodiscard]] HostPicture picture() const;

  [[nodiscard]] VkImage image() const { return image_.handle; }  // null before the first set()
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

 private:
  render::vk::Buffer bytes_;
  render::vk::Image image_;
  int width_ = 0;
  int height_ = 0;
  bool fresh_ = false;  // bytes_ are not yet in the image
};

}  // namespace footlight::tools
