// A Vulkan 1.3 device: instance, physical device, one queue that can draw and compute, and what every call needs.
//
// Knows no word of DMX. Owns everything it makes; buffers and images made from it must die before it. Not safe to share
// between threads, but for the queue: under queue_mutex a second thread may use it, with a command pool of its own.
// Validation: with DeviceOptions::validation, or FOOTLIGHT_VALIDATION=1 in the environment, the Khronos layer is on,
// with its checks of synchronisation where the layer offers them. Every warning or error is kept in
// validation_messages(); tests require that none is.
// Loss: when the GPU stops, calls that submit or wait give kDisconnected, and lost() is true from then on. All that was
// made from the device must be destroyed and made anew from another Device.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "render/vk/demands.h"
#include "sim/core/result.h"

namespace footlight::render::vk {

class Pipelines;  // render/vk/pipeline.h

struct DeviceOptions {
  bool validation = false;
  std::vector<std::string> instance_extensions;  // of the window system; empty without a window
  bool swapchain = false;                        // VK_KHR_swapchain on the device
  std::string name_contains;                     // choose a device whose name contains this; empty: the best one
  std::string cache_folder;                      // for compiled pipelines (pipeline_cache.h); empty: none are kept
};

class Device {
 public:
  // kUnsupported where there is no usable Vulkan device; the message names the package that brings a software one.
  [[nodiscard]] static Result<std::unique_ptr<Device>> create(const DeviceOptions& options);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& driver() const { return driver_; }
  [[nodiscard]] bool is_software() const { return software_; }
  [[nodiscard]] const DeviceFacts& facts() const { return facts_; }
  [[nodiscard]] double timestamp_period_ns() const { return limits().timestampPeriod; }
  [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return facts_.properties.limits; }
  // What the program does without on this device, one line each; empty on most.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] Pipelines& pipelines() { return *pipelines_; }
  // Whether the validation layer checks barriers, too.
  [[nodiscard]] bool validates_synchronisation() const { return validates_synchronisation_; }
  // A copy: other threads may add to them.
  [[nodiscard]] std::vector<std::string> validation_messages() const {
    const std::lock_guard lock(messages_mutex_);
    return validation_messages_;
  }

  // Bytes of all buffers and images of this device, now and at most since reset_memory_peak().
  [[nodiscard]] std::uint64_t memory_bytes() const { return memory_bytes_; }
  [[nodiscard]] std::uint64_t memory_peak_bytes() const { return memory_peak_bytes_; }
  void reset_memory_peak() { memory_peak_bytes_ = memory_bytes_.load(); }
  void add_memory(std::uint64_t bytes);
  void remove_memory(std::uint64_t bytes) { memory_bytes_ -= bytes; }

  // Index of a memory type that is allowed by `type_bits` and has `flags`; kUnsupported where there is none.
  [[nodiscard]] Result<std::uint32_t> memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags flags) const;

  // Returns when the device is done with all work.
  Status wait_idle();
  // vkQueueSubmit of one batch; queue_mutex is held by the caller.
  Status submit_locked(const VkSubmitInfo& batch, VkFence done);
  // Returns when the fence is signalled.
  Status wait(VkFence fence);
  [[nodiscard]] bool lost() const { return lost_; }
  // For tests: the device is lost at the submit after so many more.
  void lose_after(std::uint64_t submits) { submits_left_ = submits; }
  // The same with FOOTLIGHT_LOSE_DEVICE=N of the environment, at the first call in a process. Programs call it when
  // they are set up.
  void lose_from_environment();
  // Records with `record` into a command buffer of its own, submits it and waits. For set-up and read-back.
  template <class Record>
  Status run_once(Record&& record) {
    FL_ASSIGN(VkCommandBuffer commands, begin_once());
    record(commands);
    return end_once(commands);
  }

  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice handle = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::mutex queue_mutex;  // held around every call that is given the queue
  std::uint32_t queue_family = 0;
  VkCommandPool command_pool = VK_NULL_HANDLE;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  // may be null
  VkSampler linear = VK_NULL_HANDLE;                // both clamp at the edges
  VkSampler nearest = VK_NULL_HANDLE;

 private:
  Device() = default;
  Result<VkCommandBuffer> begin_once();
  Status end_once(VkCommandBuffer commands);
  Status create_instance(const DeviceOptions& options);
  Status choose_physical(const DeviceOptions& options);
  Status create_logical(const DeviceOptions& options);
  Status create_samplers();
  Status create_pipeline_cache(const DeviceOptions& options);
  void save_pipeline_cache() const;
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT types,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::unique_ptr<Pipelines> pipelines_;
  DeviceFacts facts_;
  std::string name_;
  std::string driver_;
  bool software_ = false;
  bool validates_synchronisation_ = false;
  std::atomic<bool> lost_ = false;
  std::uint64_t submits_left_ = UINT64_MAX;  // under queue_mutex
  std::string cache_path_;                   // empty: pipelines are not kept
  std::vector<std::byte> cache_loaded_;
  std::vector<std::string> notes_;
  std::atomic<std::uint64_t> memory_bytes_ = 0;
  std::atomic<std::uint64_t> memory_peak_bytes_ = 0;
  mutable std::mutex messages_mutex_;
  std::vector<std::string> validation_messages_;  // under messages_mutex_
};

// Success, or the name of the failed call and of the VkResult.
[[nodiscard]] Status check(VkResult result, const char* call);

}  // namespace footlight::render::vk
