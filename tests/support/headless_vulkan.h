// The one Vulkan device of a test process. Made at first use, since that is slow; with the validation layer on.
//
//   const testing::HeadlessVulkan vulkan;
//   if (!vulkan) return;                    // reported on stderr; a failure with FOOTLIGHT_REQUIRE_VULKAN=1
//   auto frame = Frame::create(vulkan.device(), ...);
//
// When it goes out of scope, every message of the validation layer since its construction fails the test. Frames must
// be destroyed before it, so declare it first. FOOTLIGHT_TEST_DEVICE selects a device by a part of its name. Without it
// tests run on the software renderer lavapipe, whose name contains "llvmpipe", or else on the best device.
#pragma once

#include <cstddef>

#include "render/vk/device.h"

namespace footlight::testing {

class HeadlessVulkan {
 public:
  HeadlessVulkan();
  ~HeadlessVulkan();
  HeadlessVulkan(const HeadlessVulkan&) = delete;
  HeadlessVulkan& operator=(const HeadlessVulkan&) = delete;

  explicit operator bool() const { return device_ != nullptr; }
  [[nodiscard]] render::vk::Device& device() const { return *device_; }

 private:
  render::vk::Device* device_;
  std::size_t messages_before_ = 0;
};

}  // namespace footlight::testing
