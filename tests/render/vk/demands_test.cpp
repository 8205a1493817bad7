// The requirements of a device, and the message for a device that does not meet them.
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/vk/demands.h"
#include "render/vk/memory.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render::vk {
namespace {

using footlight::testing::HeadlessVulkan;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

struct Lack {
  std::function<void(DeviceFacts&)> take;
  std::vector<std::string> words;  // parts of the message
};

TEST_CASE("the device of the tests has everything that is required") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  CHECK(check_demands(vulkan.device().facts()));
}

TEST_CASE("a device that lacks a limit or a feature is refused with its name, its value and the required value") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const std::vector<Lack> lacks = {
      {[](DeviceFacts& f) { f.properties.limits.maxPerStageDescriptorStorageBuffers = 27; },
       {"maxPerStageDescriptorStorageBuffers is 27", "needed: 28"}},
      {[](DeviceFacts& f) { f.properties.limits.maxDescriptorSetStorageBuffers = 24; },
       {"maxDescriptorSetStorageBuffers is 24", "needed: 28"}},
      {[](DeviceFacts& f) { f.properties.limits.maxStorageBufferRange = 65536; },
       {"maxStorageBufferRange is 65536", "needed: 134217728"}},
      {[](DeviceFacts& f) { f.properties.limits.maxComputeWorkGroupInvocations = 128; },
       {"maxComputeWorkGroupInvocations is 128", "needed: 256"}},
      {[](DeviceFacts& f) {
         f.subgroup.supportedOperations &= ~VkSubgroupFeatureFlags{VK_SUBGROUP_FEATURE_BALLOT_BIT};
       },
       {"ballot"}},
      {[](DeviceFacts& f) { f.subgroup.supportedStages = VK_SHADER_STAGE_FRAGMENT_BIT; }, {"compute shaders"}},
      {[](DeviceFacts& f) { f.features_13.synchronization2 = VK_FALSE; }, {"synchronization2"}},
      {[](DeviceFacts& f) { f.features_13.dynamicRendering = VK_FALSE; }, {"dynamicRendering"}},
      {[](DeviceFacts& f) { f.features_13.maintenance4 = VK_FALSE; }, {"maintenance4"}},
      {[](DeviceFacts& f) { f.features.drawIndirectFirstInstance = VK_FALSE; }, {"drawIndirectFirstInstance"}},
      {[](DeviceFacts& f) { f.surface_id_format &= ~VkFormatFeatureFlags{VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT}; },
       {"R32G32_UINT"}},
      {[](DeviceFacts& f) { f.depth_format = 0; }, {"D32_SFLOAT"}},
      {[](DeviceFacts& f) { f.haze_format = 0; }, {"R32G32_SFLOAT"}},
      {[](DeviceFacts& f) { f.gobo_lines_format = 0; }, {"R16G16_UNORM"}},
      {[](DeviceFacts& f) { f.features.shaderStorageImageExtendedFormats = VK_FALSE; }, {"ExtendedFormats is missing"}},
      {[](DeviceFacts& f) {
         f.subgroup.supportedOperations &= ~VkSubgroupFeatureFlags{VK_SUBGROUP_FEATURE_SHUFFLE_BIT};
       },
       {"shuffle in compute shaders is missing"}},
  };
  std::string all;
  DeviceFacts none = vulkan.device().facts();
  for (const Lack& lack : lacks) {
    DeviceFacts facts = vulkan.device().facts();
    lack.take(facts);
    lack.take(none);
    const Status status = check_demands(facts);
    REQUIRE(!status);
    CHECK(status.error().code == ErrorCode::kUnsupported);
    CHECK(contains(status.error().message, vulkan.device().name()));
    for (const std::string& word : lack.words) CHECK_MESSAGE(contains(status.error().message, word), word);
  }
  const Status status = check_demands(none);
  REQUIRE(!status);
  for (const Lack& lack : lacks) {
    for (const std::string& word : lack.words) CHECK_MESSAGE(contains(status.error().message, word), word);
  }
}

TEST_CASE("a device without an option is used, and a note names what is missing") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  DeviceFacts facts = vulkan.device().facts();
  facts.timestamp_bits = 64;
  facts.features.multiDrawIndirect = facts.features.shaderInt64 = VK_TRUE;
  facts.features_12.shaderBufferInt64Atomics = VK_TRUE;
  CHECK(missing_options(facts).empty());
  facts.timestamp_bits = 0;
  facts.features.multiDrawIndirect = VK_FALSE;
  facts.features_12.shaderBufferInt64Atomics = VK_FALSE;
  CHECK(check_demands(facts));
  const auto notes = missing_options(facts);
  REQUIRE(notes.size() == 3);
  CHECK(contains(notes[0], "timestampValidBits is 0"));
  CHECK(contains(notes[1], "multiDrawIndirect"));
  CHECK(contains(notes[2], "shaderBufferInt64Atomics"));
}

TEST_CASE("a table longer than the device can bind is refused before memory is taken") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const VkDeviceSize longest = vulkan.device().limits().maxStorageBufferRange;
  const auto buffer = Buffer::device_local(vulkan.device(), longest + 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  REQUIRE(!buffer);
  CHECK(buffer.error().code == ErrorCode::kUnsupported);
  CHECK(contains(buffer.error().message, "maxStorageBufferRange is " + std::to_string(longest)));
  CHECK(contains(buffer.error().message, std::to_string(longest + 4) + " bytes"));
}

}  // namespace
}  // namespace footlight::render::vk
