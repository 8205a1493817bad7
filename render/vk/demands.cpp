#include "render/vk/demands.h"

#include <algorithm>

namespace footlight::render::vk {
namespace {

struct LimitDemand {
  const char* name;
  std::uint64_t (*value)(const DeviceFacts& facts);
  std::uint64_t needed;
};

constexpr LimitDemand kLimits[] = {
    {"maxPerStageDescriptorStorageBuffers",
     [](const DeviceFacts& f) -> std::uint64_t { return f.properties.limits.maxPerStageDescriptorStorageBuffers; },
     kStorageBuffersMax},
    {"maxDescriptorSetStorageBuffers",
     [](const DeviceFacts& f) -> std::uint64_t { return f.properties.limits.maxDescriptorSetStorageBuffers; },
     kStorageBuffersMax},
    {"maxStorageBufferRange",
     [](const DeviceFacts& f) -> std::uint64_t { return f.properties.limits.maxStorageBufferRange; },
     std::uint64_t{128} << 20},
    // Of the coarse and the fine pass (FL_GROUP_TILE).
    {"maxComputeWorkGroupInvocations",
     [](const DeviceFacts& f) -> std::uint64_t { return f.properties.limits.maxComputeWorkGroupInvocations; }, 256},
    {"maxComputeSharedMemorySize",
     [](const DeviceFacts& f) -> std::uint64_t { return f.properties.limits.maxComputeSharedMemorySize; }, 32768},
    // Lists of a workgroup have room for the counts of subgroups of 4 (FL_SUBGROUPS_MAX).
    {"subgroupSize", [](const DeviceFacts& f) -> std::uint64_t { return compute_subgroup_size(f); }, 4},
};

struct FlagDemand {
  const char* name;
  bool (*has)(const DeviceFacts& facts);
};

constexpr VkSubgroupFeatureFlags kSubgroups = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT |
                                              VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
                                              VK_SUBGROUP_FEATURE_SHUFFLE_BIT;
constexpr VkFormatFeatureFlags kSurfaceId =
    VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT | VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT;
constexpr VkFormatFeatureFlags kDepth =
    VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
constexpr VkFormatFeatureFlags kFilteredTable =
    VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;

constexpr FlagDemand kFlags[] = {
    {"subgroup operations basic, vote, ballot, arithmetic and shuffle in compute shaders",
     [](const DeviceFacts& f) {
       return (f.subgroup.supportedOperations & kSubgroups) == kSubgroups &&
              (f.subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
     }},
    {"feature synchronization2", [](const DeviceFacts& f) { return f.features_13.synchronization2 == VK_TRUE; }},
    {"feature dynamicRendering", [](const DeviceFacts& f) { return f.features_13.dynamicRendering == VK_TRUE; }},
    {"feature maintenance4", [](const DeviceFacts& f) { return f.features_13.maintenance4 == VK_TRUE; }},
    {"feature drawIndirectFirstInstance",
     [](const DeviceFacts& f) { return f.features.drawIndirectFirstInstance == VK_TRUE; }},
    {"format R32G32_UINT as storage image and colour attachment",
     [](const DeviceFacts& f) { return (f.surface_id_format & kSurfaceId) == kSurfaceId; }},
    {"format D32_SFLOAT as depth attachment and sampled image",
     [](const DeviceFacts& f) { return (f.depth_format & kDepth) == kDepth; }},
    {"feature shaderStorageImageExtendedFormats",
     [](const DeviceFacts& f) { return f.features.shaderStorageImageExtendedFormats == VK_TRUE; }},
    {"format R16G16_UNORM as storage image and filtered sampled image",
     [](const DeviceFacts& f) { return (f.gobo_lines_format & kFilteredTable) == kFilteredTable; }},
    {"format R32G32_SFLOAT as storage image and filtered sampled image",
     [](const DeviceFacts& f) { return (f.haze_format & kFilteredTable) == kFilteredTable; }},
};

VkFormatFeatureFlags format_features(VkPhysicalDevice device, VkFormat format) {
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(device, format, &properties);
  return properties.optimalTilingFeatures;
}

}  // namespace

bool can_require_subgroups(const DeviceFacts& facts) {
  constexpr std::uint32_t kThreadsMax = 512;  // of a workgroup of any pass
  const VkPhysicalDeviceSubgroupSizeControlProperties& sizes = facts.subgroup_sizes;
  return facts.features_13.subgroupSizeControl == VK_TRUE &&
         (sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0 && sizes.minSubgroupSize > 0 &&
         std::clamp(16u, sizes.minSubgroupSize, sizes.maxSubgroupSize) * sizes.maxComputeWorkgroupSubgroups >=
             kThreadsMax;
}

std::uint32_t compute_subgroup_size(const DeviceFacts& facts) {
  // A driver that may choose takes no smaller one.
  if (!can_require_subgroups(facts)) {
    return facts.subgroup_sizes.minSubgroupSize > 0 ? facts.subgroup_sizes.minSubgroupSize
                                                    : facts.subgroup.subgroupSize;
  }
  return std::clamp(16u, facts.subgroup_sizes.minSubgroupSize, facts.subgroup_sizes.maxSubgroupSize);
}

bool has_wide_atomics(const DeviceFacts& facts) {
  return facts.features.shaderInt64 == VK_TRUE && facts.features_12.shaderBufferInt64Atomics == VK_TRUE;
}

DeviceFacts read_facts(VkPhysicalDevice device) {
  DeviceFacts facts;
  facts.subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  facts.driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  facts.subgroup_sizes.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES;
  facts.subgroup.pNext = &facts.subgroup_sizes;
  facts.driver.pNext = &facts.subgroup;
  facts.id.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES;
  facts.id.pNext = &facts.driver;
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &facts.id, {}};
  vkGetPhysicalDeviceProperties2(device, &properties);
  facts.properties = properties.properties;
  facts.features_13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  facts.features_12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  facts.features_12.pNext = &facts.features_13;
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &facts.features_12, {}};
  vkGetPhysicalDeviceFeatures2(device, &features);
  facts.features = features.features;
  facts.id.pNext = facts.driver.pNext = facts.subgroup.pNext = facts.features_12.pNext = facts.features_13.pNext =
      nullptr;  // the facts may be copied
  facts.surface_id_format = format_features(device, VK_FORMAT_R32G32_UINT);
  facts.depth_format = format_features(device, VK_FORMAT_D32_SFLOAT);
  facts.gobo_lines_format = format_features(device, VK_FORMAT_R16G16_UNORM);
  facts.haze_format = format_features(device, VK_FORMAT_R32G32_SFLOAT);
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties& f) {
    return (f.queueFlags & kWanted) == kWanted;
  });
  if (family != families.end()) facts.timestamp_bits = family->timestampValidBits;
  return facts;
}

Status check_demands(const DeviceFacts& facts) {
  std::string missing;
  const auto add = [&](const std::string& line) { missing += (missing.empty() ? "" : "; ") + line; };
  for (const LimitDemand& limit : kLimits) {
    const std::uint64_t value = limit.value(facts);
    if (value < limit.needed) add(fmt::format("{} is {}, needed: {}", limit.name, value, limit.needed));
  }
  for (const FlagDemand& flag : kFlags) {
    if (!flag.has(facts)) add(fmt::format("{} is missing", flag.name));
  }
  if (missing.empty()) return {};
  return fail(ErrorCode::kUnsupported, "{} cannot be used: {}", facts.properties.deviceName, missing);
}

std::vector<std::string> missing_options(const DeviceFacts& facts) {
  std::vector<std::string> notes;
  if (facts.timestamp_bits == 0) {
    notes.push_back(fmt::format("{}: timestampValidBits is 0, needed: 1 or more; the times of passes are not measured",
                                facts.properties.deviceName));
  }
  if (facts.features.multiDrawIndirect != VK_TRUE) {
    notes.push_back(fmt::format("{}: feature multiDrawIndirect is missing; bodies are drawn with one command a type",
                                facts.properties.deviceName));
  }
  if (!has_wide_atomics(facts)) {
    notes.push_back(fmt::format("{}: feature shaderInt64 or shaderBufferInt64Atomics is missing; compute shaders draw "
                                "triangles in two rounds",
                                facts.properties.deviceName));
  }
  return notes;
}

}  // namespace footlight::render::vk
