// Buffers and images with their memory. Move-only owners; the device must outlive them, and the GPU must be done with
// them when they die.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/vk/device.h"

namespace footlight::render::vk {

class Buffer {
 public:
  Buffer() = default;
  // In device memory; readable and writable by copies.
  [[nodiscard]] static Result<Buffer> device_local(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage);
  // Mapped, cached where possible: for read-back and staging.
  [[nodiscard]] static Result<Buffer> host_visible(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage);
  // device_local() filled with `bytes`; at least 16 bytes long, so that an empty table is a valid binding.
  [[nodiscard]] static Result<Buffer> filled(Device& device, std::span<const std::byte> bytes,
                                             VkBufferUsageFlags usage);
  // A storage buffer of these rows.
  template <class Row>
  [[nodiscard]] static Result<Buffer> table(Device& device, const std::vector<Row>& rows,
                                            VkBufferUsageFlags usage = 0) {
    return filled(device, std::as_bytes(std::span(rows)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage);
  }
  ~Buffer();
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceSize size_bytes = 0;
  void* mapped = nullptr;  // host_visible() only

 private:
  static Result<Buffer> make(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage,
                             VkMemoryPropertyFlags flags, VkMemoryPropertyFlags fallback);
  void swap(Buffer& other) {
    std::swap(handle, other.handle);
    std::swap(size_bytes, other.size_bytes);
    std::swap(mapped, other.mapped);
    std::swap(device_, other.device_);
    std::swap(memory_, other.memory_);
    std::swap(taken_bytes_, other.taken_bytes_);
  }
  Device* device_ = nullptr;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize taken_bytes_ = 0;  // of the device's memory
};

class Image {
 public:
  Image() = default;
  // 2D, one level; `layers` > 0 makes an array view of that many layers.
  [[nodiscard]] static Result<Image> create(Device& device, std::uint32_t width, std::uint32_t height, VkFormat format,
                                            VkImageUsageFlags usage, std::uint32_t layers = 0,
                                            std::uint32_t levels = 1);
  ~Image();
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }

  VkImage handle = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
  VkDeviceSize size_bytes = 0;

 private:
  void swap(Image& other) {
    std::swap(handle, other.handle);
    std::swap(view, other.view);
    std::swap(format, other.format);
    std::swap(aspect, other.aspect);
    std::swap(size_bytes, other.size_bytes);
    std::swap(device_, other.device_);
    std::swap(memory_, other.memory_);
    std::swap(taken_bytes_, other.taken_bytes_);
  }
  Device* device_ = nullptr;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize taken_bytes_ = 0;  // of the device's memory
};

// Everything written before is visible to everything after. Frames are a chain of dependent passes, so finer barriers
// would buy nothing here.
void full_barrier(VkCommandBuffer commands);
// What copies before it have written may be read by the host when the commands are done.
void host_barrier(VkCommandBuffer commands);
// Moves an image from one layout to another, with a full barrier around it.
void change_layout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to);
// Of an image that is not ours, a window's.
void change_layout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to);

}  // namespace footlight::render::vk
