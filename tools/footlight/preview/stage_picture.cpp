#include "tools/footlight/preview/stage_picture.h"

#include <mutex>
#include <utility>

#include "sim/core/check.h"

namespace footlight::tools {
namespace {

namespace vk = render::vk;

}  // namespace

Result<std::unique_ptr<StagePicture>> StagePicture::make(vk::Device& device) {
  std::unique_ptr<StagePicture> made(new StagePicture(device));
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device.queue_family;
  FL_TRY(vk::check(vkCreateCommandPool(device.handle, &pool, nullptr, &made->pool_), "vkCreateCommandPool"));
  VkCommandBufferAllocateInfo commands{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  commands.commandPool = made->pool_;
  commands.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  commands.commandBufferCount = 1;
  FL_TRY(vk::check(vkAllocateCommandBuffers(device.handle, &commands, &made->commands_), "vkAllocateCommandBuffers"));
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  FL_TRY(vk::check(vkCreateFence(device.handle, &fence, nullptr, &made->done_), "vkCreateFence"));
  return made;
}

StagePicture::~StagePicture() {
  if (in_flight_) (void)device_.wait_idle();  // also of a device that counts as lost
  vkDestroyFence(device_.handle, done_, nullptr);
  vkDestroyCommandPool(device_.handle, pool_, nullptr);
}

Status StagePicture::begin(VkImage screen, int width, int height, const std::function<void(VkCommandBuffer)>& record) {
  FL_CHECK(!in_flight_);
  if (width != width_ || height != height_) {
    bytes_ = {};  // freed first
    width_ = height_ = 0;
    const VkDeviceSize pixels = static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height);
    FL_ASSIGN(bytes_, vk::Buffer::host_visible(device_, 4 * pixels, 0));
    width_ = width;
    height_ = height;
  }
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FL_TRY(vk::check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer"));
  record(commands_);
  vk::full_barrier(commands_);
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
  vkCmdCopyImageToBuffer(commands_, screen, VK_IMAGE_LAYOUT_GENERAL, bytes_.handle, 1, &region);
  vk::host_barrier(commands_);
  FL_TRY(vk::check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer"));
  FL_TRY(vk::check(vkResetFences(device_.handle, 1, &done_), "vkResetFences"));
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  const std::lock_guard lock(device_.queue_mutex);
  FL_TRY(device_.submit_locked(submit, done_));
  in_flight_ = true;
  return {};
}

Result<bool> StagePicture::done(std::uint64_t patience_ns) {
  FL_CHECK(in_flight_);
  if (!device_.lost()) {
    const VkResult result = vkWaitForFences(device_.handle, 1, &done_, VK_TRUE, patience_ns);
    if (result == VK_TIMEOUT) return false;
  }
  FL_TRY(device_.wait(done_));  // at once, also with an error
  return true;
}

HostPicture StagePicture::take() {
  FL_CHECK(in_flight_);
  in_flight_ = false;
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  return {{static_cast<const std::uint8_t*>(bytes_.mapped), 4 * pixels}, width_, height_};
}

}  // namespace footlight::tools
