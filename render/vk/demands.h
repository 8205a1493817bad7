// What the renderer demands of a Vulkan device, and what it does without.
//
// A device that lacks a demand is not used; the message names the limit, its value and the value that is needed. A
// device that lacks an option is used, with one note for each.
#pragma once

#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "sim/core/result.h"

namespace footlight::render::vk {

// Storage buffers of one pipeline. The step pass has the most: 25. lavapipe (Mesa 22.3) allows 32 a stage.
inline constexpr std::uint32_t kStorageBuffersMax = 28;
// Vulkan guarantees these two.
inline constexpr std::uint32_t kStorageImagesMax = 4;
inline constexpr std::uint32_t kSamplersMax = 16;

// Everything that the demands are compared with, as the driver states it.
struct DeviceFacts {
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceSubgroupProperties subgroup{};
  VkPhysicalDeviceSubgroupSizeControlProperties subgroup_sizes{};
  VkPhysicalDeviceDriverProperties driver{};
  VkPhysicalDeviceIDProperties id{};
  VkPhysicalDeviceFeatures features{};
  VkPhysicalDeviceVulkan12Features features_12{};
  VkPhysicalDeviceVulkan13Features features_13{};
  VkFormatFeatureFlags surface_id_format = 0;  // VK_FORMAT_R32G32_UINT, optimal tiling
  VkFormatFeatureFlags depth_format = 0;       // VK_FORMAT_D32_SFLOAT
  VkFormatFeatureFlags gobo_lines_format = 0;  // VK_FORMAT_R16G16_UNORM
  VkFormatFeatureFlags haze_format = 0;        // VK_FORMAT_R32G32_SFLOAT
  std::uint32_t timestamp_bits = 0;            // of the queue family that draws and computes
};

// Threads of a subgroup of compute pipelines. Where a driver may choose between sizes, pipelines require this one
// (Pipeline::compute): the nearest to 16 that it has.
[[nodiscard]] bool can_require_subgroups(const DeviceFacts& facts);
[[nodiscard]] std::uint32_t compute_subgroup_size(const DeviceFacts& facts);

// Whether shaders may take the maximum of words of 64 bits in a buffer.
[[nodiscard]] bool has_wide_atomics(const DeviceFacts& facts);

// The device has Vulkan 1.3.
[[nodiscard]] DeviceFacts read_facts(VkPhysicalDevice device);

// kUnsupported with all that is missing.
[[nodiscard]] Status check_demands(const DeviceFacts& facts);
// One line for each option that is missing, with what the program does instead.
[[nodiscard]] std::vector<std::string> missing_options(const DeviceFacts& facts);

}  // namespace footlight::render::vk
