#include "tests/support/headless_vulkan.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include <dlfcn.h>
#include <link.h>

#include <doctest/doctest.h>

namespace footlight::testing {
namespace {

using render::vk::Device;

Result<std::unique_ptr<Device>> create_device() {
  if (const char* name = std::getenv("FOOTLIGHT_TEST_DEVICE"); name != nullptr) {
    return Device::create({.validation = true, .name_contains = name});
  }
  if (auto software = Device::create({.validation = true, .name_contains = "llvmpipe"})) return software;
  return Device::create({.validation = true});
}

// Keeps the driver mapped after its last device is gone. Mesa's tables hang on its globals until the process ends. Once
// they are unmapped, LeakSanitizer reports the tables as leaks, and cannot name real ones.
void pin_loaded_libraries() {
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void*) {
        if (info->dlpi_name[0] != '\0') (void)dlopen(info->dlpi_name, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
        return 0;
      },
      nullptr);
}

Device* shared_device() {
  static const std::unique_ptr<Device> device = []() -> std::unique_ptr<Device> {
    auto created = create_device();
    if (created) {
      std::fprintf(stderr, "on %s (%s)\n", (*created)->name().c_str(), (*created)->driver().c_str());
      pin_loaded_libraries();
      return std::move(*created);
    }
    std::fprintf(stderr, "SKIPPED: %s\n", created.error().message.c_str());
    return nullptr;
  }();
  return device.get();
}

}  // namespace

HeadlessVulkan::HeadlessVulkan() : device_(shared_device()) {
  if (device_ != nullptr) {
    messages_before_ = device_->validation_messages().size();
    return;
  }
  const char* required = std::getenv("FOOTLIGHT_REQUIRE_VULKAN");
  CHECK_MESSAGE((required == nullptr || std::strcmp(required, "1") != 0),
                "no Vulkan device, but FOOTLIGHT_REQUIRE_VULKAN=1 requires one");
}

HeadlessVulkan::~HeadlessVulkan() {
  if (device_ == nullptr) return;
  const auto messages = device_->validation_messages();
  for (std::size_t i = messages_before_; i < messages.size(); ++i) CHECK_MESSAGE(false, messages[i]);
}

}  // namespace footlight::testing
