// A picture of the stage that the GPU draws while the window's thread does other things (decision 0150).
//
//   FL_ASSIGN(auto picture, StagePicture::make(device));
//   FL_TRY(picture->begin(screen, width, height, [&](VkCommandBuffer commands) { ... }));  // does not wait
//   ... picture->in_flight(): nothing that these commands use may change ...
//   FL_ASSIGN(const bool done, picture->done());
//   if (done) show(picture->take());
//
// The commands end with a copy of the screen into memory of the host, so that another device can show it.
//
// Threads: one, the window's. It has a command pool of its own, so another thread may use that of the device. The
// device must outlive it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "render/vk/device.h"
#include "render/vk/memory.h"

namespace footlight::tools {

// 8-bit RGBA, rows from the top.
struct HostPicture {
  std::span<const std::uint8_t> rgba;  // width x height x 4
  int width = 0;
  int height = 0;
};

class StagePicture {
 public:
  static constexpr std::uint64_t kForeverNs = UINT64_MAX;

  [[nodiscard]] static Result<std::unique_ptr<StagePicture>> make(render::vk::Device& device);
  // Waits for a picture in flight.
  ~StagePicture();
  StagePicture(const StagePicture&) = delete;
  StagePicture& operator=(const StagePicture&) = delete;

  // Records with `record`, which draws into `screen`: VK_FORMAT_R8G8B8A8_UNORM in VK_IMAGE_LAYOUT_GENERAL. Submits, and
  // returns without waiting. None may be in flight.
  Status begin(VkImage screen, int width, int height, const std::function<void(VkCommandBuffer)>& record);
  // From begin() to take().
  [[nodiscard]] bool in_flight() const { return in_flight_; }
  // Whether the picture in flight is drawn. Waits at most patience_ns for that.
  [[nodiscard]] Result<bool> done(std::uint64_t patience_ns = 0);
  // The picture in flight, which must be done. Valid until the next begin().
  [[nodiscard]] HostPicture take();

 private:
  explicit StagePicture(render::vk::Device& device) : device_(device) {}

  render::vk::Device& device_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence done_ = VK_NULL_HANDLE;
  render::vk::Buffer bytes_;
  int width_ = 0;
  int height_ = 0;
  bool in_flight_ = false;
};

}  // namespace footlight::tools
