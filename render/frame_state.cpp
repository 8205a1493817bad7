#include "render/frame_state.h"

#include <cstring>

#include "render/frame.h"
#include "render/vk/device.h"
#include "sim/core/check.h"

namespace footlight::render {

// The buffers that the steps write, and the newest levels, which displays show. Counts are those of a picture.
std::vector<const vk::Buffer*> Frame::state_buffers() const {
  std::vector<const vk::Buffer*> states;
  if (resources_.rig.levels.handle != VK_NULL_HANDLE) states.push_back(&resources_.rig.levels);
  for (const vk::Buffer* buffer : resources_.rig.all_states()) {
    if (buffer->handle != VK_NULL_HANDLE && buffer != &resources_.rig.counts) states.push_back(buffer);
  }
  return states;
}

Result<FrameState> Frame::save_state() {
  FL_TRY(run_steps());
  FrameState state;
  state.time_ns = time_ns_;
  if (machines_) state.air = machines_->air();
  const auto buffers = state_buffers();
  VkDeviceSize bytes = 0;
  for (const vk::Buffer* buffer : buffers) bytes += buffer->size_bytes;
  if (bytes == 0) return state;
  if (state_bytes_.handle == VK_NULL_HANDLE) {
    FL_ASSIGN(state_bytes_, vk::Buffer::host_visible(device_, bytes, 0));
  }
  FL_TRY(device_.run_once([&](VkCommandBuffer commands) {
    vk::full_barrier(commands);
    VkDeviceSize at = 0;
    for (const vk::Buffer* buffer : buffers) {
      const VkBufferCopy region{0, at, buffer->size_bytes};
      vkCmdCopyBuffer(commands, buffer->handle, state_bytes_.handle, 1, &region);
      at += buffer->size_bytes;
    }
    vk::host_barrier(commands);
  }));
  state.heads.resize(bytes);
  std::memcpy(state.heads.data(), state_bytes_.mapped, bytes);
  return state;
}

Status Frame::load_state(const FrameState& state) {
  FL_TRY(run_steps());
  const auto buffers = state_buffers();
  VkDeviceSize bytes = 0;
  for (const vk::Buffer* buffer : buffers) bytes += buffer->size_bytes;
  FL_CHECK_EQ(state.heads.size(), bytes);
  time_ns_ = state.time_ns;
  if (machines_) machines_->set_air(state.air);
  if (bytes == 0) return {};
  if (state_bytes_.handle == VK_NULL_HANDLE) {
    FL_ASSIGN(state_bytes_, vk::Buffer::host_visible(device_, bytes, 0));
  }
  std::memcpy(state_bytes_.mapped, state.heads.data(), bytes);
  return device_.run_once([&](VkCommandBuffer commands) {
    vk::full_barrier(commands);
    VkDeviceSize at = 0;
    for (const vk::Buffer* buffer : buffers) {
      const VkBufferCopy region{at, 0, buffer->size_bytes};
      vkCmdCopyBuffer(commands, state_bytes_.handle, buffer->handle, 1, &region);
      at += buffer->size_bytes;
    }
    vk::full_barrier(commands);
  });
}

}  // namespace footlight::render
