// The flash limit of the preview's window. Reads each picture at a small size, and can hold the last harmless picture
// while later ones must not be shown. The limits are in sim/photosensitive.h.
//
// Warning costs a blit to 64 x 36 pixels per picture, which are read when the picture is done, one picture late.
// Limiting waits for each picture before it is shown. Without --flashes this object does not exist.
//
// Threads: the window's.
#pragma once

#include <memory>

#include "render/vk/device.h"
#include "render/vk/memory.h"
#include "tools/footlight/pictures/flash_watch.h"

namespace footlight::tools {

class PreviewFlashes {
 public:
  [[nodiscard]] static Result<std::unique_ptr<PreviewFlashes>> make(render::vk::Device& device, bool limit);

  [[nodiscard]] bool limits() const { return limit_; }
  // Adds the reading of a picture, in VK_IMAGE_LAYOUT_GENERAL, to commands that have drawn it.
  void record_read(VkCommandBuffer commands, VkImage picture, int width, int height);
  // Call when those commands are done. True: a period of harmful flashes begins with this picture.
  bool take(DurationNs at_ns);

  // Limiting: true if the picture that was read must not be shown yet; show standing() instead.
  bool must_wait(DurationNs at_ns);
  // Keeps a picture that is about to be shown. Call with the size of every frame before it is recorded.
  [[nodiscard]] Status resize(int width, int height);
  void record_keep(VkCommandBuffer commands, VkImage picture);
  [[nodiscard]] VkImage standing() const { return standing_.handle; }

  [[nodiscard]] const FlashWatch& watch() const { return watch_; }

 private:
  PreviewFlashes(render::vk::Device& device, bool limit) : device_(device), limit_(limit), watch_(false) {}
  [[nodiscard]] render::ScreenImage small() const;

  render::vk::Device& device_;
  bool limit_;
  FlashWatch watch_;
  render::vk::Image small_;
  render::vk::Buffer pixels_;
  render::vk::Image standing_;
  int width_ = 0;  // of standing_
  int height_ = 0;
};

}  // namespace footlight::tools
