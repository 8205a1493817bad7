// A picture of the stage that the GPU draws while the window's thread does other things.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "render/vk/memory.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tools/footlight/preview/stage_picture.h"
#include "tools/footlight/preview/uploaded_image.h"

namespace footlight::tools {
namespace {

namespace vk = render::vk;
using footlight::testing::HeadlessVulkan;
using footlight::testing::must;

constexpr std::array<float, 4> kColour{1, 0.2f, 0, 1};
constexpr std::array<std::uint8_t, 4> kBytes{255, 51, 0, 255};

vk::Image make_screen(vk::Device& device, std::uint32_t width, std::uint32_t height) {
  vk::Image screen = must(vk::Image::create(
      device, width, height, VK_FORMAT_R8G8B8A8_UNORM,
      VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT));
  must(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, screen, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  }));
  return screen;
}

void fill(VkCommandBuffer commands, VkImage image) {
  const VkClearColorValue colour{{kColour[0], kColour[1], kColour[2], kColour[3]}};
  const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdClearColorImage(commands, image, VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &range);
}

bool is_filled(const HostPicture& picture, int width, int height) {
  if (picture.width != width || picture.height != height) return false;
  if (picture.rgba.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4) return false;
  for (std::size_t i = 0; i < picture.rgba.size(); ++i) {
    if (picture.rgba[i] != kBytes[i % 4]) return false;
  }
  return true;
}

// The GPU of the stage waits for an event of the host, as long as the test likes.
TEST_CASE("while a picture of the stage is in flight another device of the same GPU draws") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  vk::Device& stage = vulkan.device();
  const auto window = must(vk::Device::create({.validation = true, .name_contains = stage.name()}));
  const vk::Image screen = make_screen(stage, 6, 4);
  const vk::Image other = make_screen(*window, 6, 4);
  const VkEventCreateInfo info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
  VkEvent gate = VK_NULL_HANDLE;
  must(vk::check(vkCreateEvent(stage.handle, &info, nullptr, &gate), "vkCreateEvent"));
  auto picture = must(StagePicture::make(stage));
  CHECK(!picture->in_flight());
  must(picture->begin(screen.handle, 6, 4, [&](VkCommandBuffer commands) {
    vkCmdWaitEvents(commands, 1, &gate, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, nullptr, 0,
                    nullptr, 0, nullptr);
    fill(commands, screen.handle);
  }));
  CHECK(picture->in_flight());
  for (int turn = 0; turn < 3; ++turn) {
    must(window->run_once([&](VkCommandBuffer commands) { fill(commands, other.handle); }));
    CHECK(!must(picture->done()));
  }
  must(vk::check(vkSetEvent(stage.handle, gate), "vkSetEvent"));
  CHECK(must(picture->done(StagePicture::kForeverNs)));
  CHECK(picture->in_flight());
  CHECK(is_filled(picture->take(), 6, 4));
  CHECK(!picture->in_flight());
  vkDestroyEvent(stage.handle, gate, nullptr);
  CHECK(window->validation_messages().empty());
}

TEST_CASE("a picture of another size than the one before has all of its pixels, on the other device too") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  vk::Device& device = vulkan.device();
  auto picture = must(StagePicture::make(device));
  auto copy = must(StagePicture::make(device));
  UploadedImage image;
  CHECK(image.image() == VK_NULL_HANDLE);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 3), std::pair(7, 3), std::pair(2, 5)}) {
    CAPTURE(width);
    const vk::Image screen = make_screen(device, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
    must(
        picture->begin(screen.handle, width, height, [&](VkCommandBuffer commands) { fill(commands, screen.handle); }));
    REQUIRE(must(picture->done(StagePicture::kForeverNs)));
    const HostPicture taken = picture->take();
    CHECK(is_filled(taken, width, height));
    must(image.set(device, taken));
    CHECK(image.is_fresh());
    must(copy->begin(image.image(), width, height, [&](VkCommandBuffer commands) { image.record(commands); }));
    CHECK(!image.is_fresh());
    REQUIRE(must(copy->done(StagePicture::kForeverNs)));
    CHECK(is_filled(copy->take(), width, height));
  }
}

double ms_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}

// With FOOTLIGHT_PRINT_COSTS=1 it prints what the way costs: the least of five times.
TEST_CASE("a picture of 3840 x 2160 comes through memory of the host with its first and its last pixel") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  vk::Device& device = vulkan.device();
  const char* prints = std::getenv("FOOTLIGHT_PRINT_COSTS");  // NOLINT(concurrency-mt-unsafe): one thread
  for (const auto& [width, height] : {std::pair(1280, 720), std::pair(3840, 2160)}) {
    const vk::Image screen = make_screen(device, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
    must(device.run_once([&](VkCommandBuffer commands) { fill(commands, screen.handle); }));
    auto picture = must(StagePicture::make(device));
    UploadedImage image;
    double down_ms = 1e9;
    double copy_ms = 1e9;
    double up_ms = 1e9;
    for (int i = 0; i < (prints != nullptr ? 5 : 1); ++i) {
      auto begun = std::chrono::steady_clock::now();
      must(picture->begin(screen.handle, width, height, [](VkCommandBuffer) {}));
      REQUIRE(must(picture->done(StagePicture::kForeverNs)));
      down_ms = std::min(down_ms, ms_since(begun));
      const HostPicture taken = picture->take();
      CHECK(std::equal(kBytes.begin(), kBytes.end(), taken.rgba.begin()));
      CHECK(std::equal(kBytes.begin(), kBytes.end(), taken.rgba.end() - 4));
      begun = std::chrono::steady_clock::now();
      must(image.set(device, taken));
      copy_ms = std::min(copy_ms, ms_since(begun));
      begun = std::chrono::steady_clock::now();
      must(device.run_once([&](VkCommandBuffer commands) { image.record(commands); }));
      up_ms = std::min(up_ms, ms_since(begun));
    }
    if (prints != nullptr) {
      fmt::print("{} x {}: {} bytes; to the host {:.2f} ms, copy {:.2f} ms, to the window {:.2f} ms\n", width, height,
                 4 * width * height, down_ms, copy_ms, up_ms);
    }
  }
}

TEST_CASE("a picture in flight that is dropped is waited for") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const vk::Image screen = make_screen(vulkan.device(), 64, 64);
  auto picture = must(StagePicture::make(vulkan.device()));
  must(picture->begin(screen.handle, 64, 64, [&](VkCommandBuffer commands) { fill(commands, screen.handle); }));
  picture.reset();  // the validation layer reports what is destroyed in use
}

}  // namespace
}  // namespace footlight::tools
