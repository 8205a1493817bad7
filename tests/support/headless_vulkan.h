// The one Vulkan device of a test process. Made at the first use, since that is slow; with the validation layer on.
//
//   const testing::HeadlessVulkan vulkan;
//   if (!vulkan) return;                    // said on stderr; a failure where FOOTLIGHT_REQUIRE_VULKAN=1
//   auto frame = Frame::create(vulkan.device(), ...);
//
// When it goes out of scope, every message of the validation layer since then is a failure of the test. Frames must die
// before it, so declare it first. FOOTLIGHT_TEST_DEVICE chooses a device by a part of its name; else tests run on the
// software renderer lavapipe, whose name contains "llvmpipe", and without it on the best device there is.
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
