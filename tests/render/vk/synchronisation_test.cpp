// The validation layer of the tests checks barriers.
#include <algorithm>
#include <string>

#include <doctest/doctest.h>

#include "render/vk/memory.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"

namespace footlight::render::vk {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::must;

// Writes the same bytes twice, with or without a barrier between the writes. Returns the messages of the layer.
std::vector<std::string> messages_of_two_writes(const HeadlessVulkan& vulkan, bool barrier) {
  const auto device = must(Device::create({.validation = true, .name_contains = vulkan.device().name()}));
  const Buffer buffer = must(Buffer::device_local(*device, 256, 0));
  must(device->run_once([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 1);
    if (barrier) full_barrier(commands);
    vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 2);
  }));
  return device->validation_messages();
}

TEST_CASE("a missing barrier is reported") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  if (!vulkan.device().validates_synchronisation()) {
    MESSAGE("skipped: the validation layer has no VK_EXT_validation_features");
    return;
  }
  CHECK(messages_of_two_writes(vulkan, true).empty());
  const auto messages = messages_of_two_writes(vulkan, false);
  REQUIRE(messages.size() == 1);
  CHECK((messages[0].find("SYNC-HAZARD-WRITE-AFTER-WRITE") != std::string::npos));
}

}  // namespace
}  // namespace footlight::render::vk
