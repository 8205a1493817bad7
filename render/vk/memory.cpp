#include "render/vk/memory.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace footlight::render::vk {
namespace {

// For tests: devices refuse more than FOOTLIGHT_REFUSE_MEMORY_MIB of the environment each.
std::uint64_t refused_from_bytes() {
  static const std::uint64_t kFrom = [] {
    const char* const text = std::getenv("FOOTLIGHT_REFUSE_MEMORY_MIB");
    return text == nullptr ? std::numeric_limits<std::uint64_t>::max() : std::strtoull(text, nullptr, 10) << 20;
  }();
  return kFrom;
}

double mib(std::uint64_t bytes) { return static_cast<double>(bytes) / (1024 * 1024); }

Status take_memory(const Device& device, const VkMemoryAllocateInfo& wanted, VkDeviceMemory& memory) {
  const std::uint64_t used_bytes = device.memory_bytes();
  const bool refused = used_bytes + wanted.allocationSize > refused_from_bytes();
  const VkResult result =
      refused ? VK_ERROR_OUT_OF_DEVICE_MEMORY : vkAllocateMemory(device.handle, &wanted, nullptr, &memory);
  if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY && result != VK_ERROR_OUT_OF_HOST_MEMORY) {
    return check(result, "vkAllocateMemory");
  }
  return fail(ErrorCode::kIo,
              "{} has no memory left: {:.1f} MiB more were refused beside the {:.1f} MiB that are used here; use a "
              "smaller picture or fewer fixtures, or close other programs",
              device.name(), mib(wanted.allocationSize), mib(used_bytes));
}

}  // namespace

Result<Buffer> Buffer::make(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage,
                            VkMemoryPropertyFlags flags, VkMemoryPropertyFlags fallback) {
  Buffer buffer;
  buffer.size_bytes = std::max<VkDeviceSize>(size_bytes, 16);
  const VkDeviceSize range_max = device.limits().maxStorageBufferRange;
  if ((usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) != 0 && buffer.size_bytes > range_max) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: maxStorageBufferRange is {}, needed: {} bytes for one table; use fewer fixtures or a smaller picture",
        device.name(), range_max, buffer.size_bytes);
  }
  buffer.device_ = &device;
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = buffer.size_bytes;
  info.usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  FL_TRY(check(vkCreateBuffer(device.handle, &info, nullptr, &buffer.handle), "vkCreateBuffer"));
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device.handle, buffer.handle, &requirements);
  auto type = device.memory_type(requirements.memoryTypeBits, flags);
  if (!type) type = device.memory_type(requirements.memoryTypeBits, fallback);
  if (!type) return tl::unexpected<Error>(type.error());
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = *type;
  FL_TRY(take_memory(device, allocate, buffer.memory_));
  buffer.taken_bytes_ = requirements.size;
  device.add_memory(requirements.size);
  FL_TRY(check(vkBindBufferMemory(device.handle, buffer.handle, buffer.memory_, 0), "vkBindBufferMemory"));
  return buffer;
}

Result<Buffer> Buffer::device_local(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage) {
  return make(device, size_bytes, usage, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
}

Result<Buffer> Buffer::host_visible(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage) {
  constexpr VkMemoryPropertyFlags kCoherent =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  FL_ASSIGN(Buffer buffer, make(device, size_bytes, usage, kCoherent | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, kCoherent));
  FL_TRY(check(vkMapMemory(device.handle, buffer.memory_, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory"));
  return buffer;
}

Result<Buffer> Buffer::filled(Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage) {
  FL_ASSIGN(Buffer buffer, device_local(device, bytes.size(), usage));
  if (bytes.empty()) return buffer;
  FL_ASSIGN(Buffer staging, host_visible(device, bytes.size(), 0));
  std::memcpy(staging.mapped, bytes.data(), bytes.size());
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, bytes.size()};
    vkCmdCopyBuffer(commands, staging.handle, buffer.handle, 1, &region);
  }));
  return buffer;
}

Buffer::~Buffer() {
  if (device_ == nullptr) return;
  vkDestroyBuffer(device_->handle, handle, nullptr);
  vkFreeMemory(device_->handle, memory_, nullptr);
  device_->remove_memory(taken_bytes_);
}

Result<Image> Image::create(Device& device, std::uint32_t width, std::uint32_t height, VkFormat format,
                            VkImageUsageFlags usage, std::uint32_t layers, std::uint32_t levels) {
  Image image;
  image.device_ = &device;
  image.format = format;
  image.aspect = format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {width, height, 1};
  info.mipLevels = levels;
  info.arrayLayers = std::max(layers, 1u);
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = usage;
  FL_TRY(check(vkCreateImage(device.handle, &info, nullptr, &image.handle), "vkCreateImage"));
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device.handle, image.handle, &requirements);
  image.size_bytes = requirements.size;
  FL_ASSIGN(const std::uint32_t type,
            device.memory_type(requirements.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT));
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = type;
  FL_TRY(take_memory(device, allocate, image.memory_));
  image.taken_bytes_ = requirements.size;
  device.add_memory(requirements.size);
  FL_TRY(check(vkBindImageMemory(device.handle, image.handle, image.memory_, 0), "vkBindImageMemory"));
  VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view.image = image.handle;
  view.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {image.aspect, 0, levels, 0, std::max(layers, 1u)};
  FL_TRY(check(vkCreateImageView(device.handle, &view, nullptr, &image.view), "vkCreateImageView"));
  return image;
}

Image::~Image() {
  if (device_ == nullptr) return;
  vkDestroyImageView(device_->handle, view, nullptr);
  vkDestroyImage(device_->handle, handle, nullptr);
  vkFreeMemory(device_->handle, memory_, nullptr);
  device_->remove_memory(taken_bytes_);
}

void full_barrier(VkCommandBuffer commands) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

void host_barrier(VkCommandBuffer commands) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

void change_layout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to) {
  change_layout(commands, image.handle, image.aspect, from, to);
}

void change_layout(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.imageMemoryBarrierCount = 1;
  info.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

}  // namespace footlight::render::vk
