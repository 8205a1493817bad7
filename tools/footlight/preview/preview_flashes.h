// The flash limit of the preview's window. Reads each picture at a small size, and decides whether it must not be shown
// yet. The limits are in sim/photosensitive.h.
//
// It costs a blit to 64 x 36 pixels per picture, which are read when the picture is done, before it is shown. Without
// --flashes this object does not exist.
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
  // Flashes that were shown before count.
  void set_limits(bool limit);
  // Adds the reading of a picture, in VK_IMAGE_LAYOUT_GENERAL, to commands that have drawn it.
  void record_read(VkCommandBuffer commands, VkImage picture, int width, int height);
  // Call when those commands are done. True: a period of harmful flashes begins with this picture.
  bool take(DurationNs at_ns);

  // Limiting: true if the picture that was read must not be shown yet; the one before stays.
  bool must_wait(DurationNs at_ns);

  [[nodiscard]] const FlashWatch& watch() const { return watch_; }

 private:
  explicit PreviewFlashes(bool limit) : limit_(limit), watch_(false) {}
  [[nodiscard]] render::ScreenImage small() const;

  bool limit_;
  FlashWatch watch_;
  render::vk::Image small_;
  render::vk::Buffer pixels_;
};

}  // namespace footlight::tools
