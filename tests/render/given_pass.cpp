#include "tests/render/given_pass.h"

#include <cstring>
#include <vector>

#include "sim/core/check.h"

namespace footlight::render::testing {
namespace {

std::vector<float> given_rgba;

class GivenPass final : public Pass {
 public:
  GivenPass(vk::Buffer buffer, const vk::Image& image, int width, int height)
      : buffer_(std::move(buffer)),
        image_(image),
        extent_{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1} {}
  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    FL_CHECK_EQ(given_rgba.size() * sizeof(float), buffer_.size_bytes);
    std::memcpy(buffer_.mapped, given_rgba.data(), given_rgba.size() * sizeof(float));
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = extent_;
    vkCmdCopyBufferToImage(commands, buffer_.handle, image_.handle, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    vk::full_barrier(commands);
  }

 private:
  vk::Buffer buffer_;
  const vk::Image& image_;
  VkExtent3D extent_;
};

}  // namespace

const PassEntry kGivenPass{
    "given",
    [](const fixtures::Needs&, const FrameSettings&) { return true; },
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const FrameSettings& settings = context.settings;
      const std::size_t bytes =
          std::size_t{16} * static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height);
      FL_ASSIGN(vk::Buffer buffer, vk::Buffer::host_visible(context.device, bytes, 0));
      return std::unique_ptr<Pass>(
          new GivenPass(std::move(buffer), context.resources.picture.radiance, settings.width, settings.height));
    },
    [] { return std::vector<std::vector<vk::Spirv>>{}; },
    "the test"};

void give(const RadianceImage& light) {
  given_rgba.clear();
  for (std::size_t i = 0; i < light.rgb.size(); i += 3) {
    given_rgba.insert(given_rgba.end(), {light.rgb[i], light.rgb[i + 1], light.rgb[i + 2], 1e30f});
  }
}

}  // namespace footlight::render::testing
