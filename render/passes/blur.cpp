#include "render/passes/blur.h"

#include <array>

#include "render/passes/compute_pass.h"
#include "shaders/blur.comp.h"
#include "shaders/blurtiles.comp.h"

namespace footlight::render {
namespace {

class BlurPass final : public Pass {
 public:
  BlurPass(const FrameSettings& settings, const PictureImages& picture, BoundPipeline tiles, BoundPipeline blur)
      : picture_(picture),
        width_(settings.width),
        height_(settings.height),
        push_{static_cast<float>(settings.f_stop), static_cast<float>(settings.focus_m)},
        tiles_(std::move(tiles)),
        blur_(std::move(blur)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    for (const BoundPipeline* each : {&tiles_, &blur_}) {
      each->bind(commands);
      each->pipeline->push(commands, std::as_bytes(std::span(push_)));
      vkCmdDispatch(commands, tile_groups(width_), tile_groups(height_), 1);
      vk::full_barrier(commands);
    }
    VkImageCopy whole{};
    whole.srcSubresource = whole.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    whole.extent = {static_cast<std::uint32_t>(width_), static_cast<std::uint32_t>(height_), 1};
    vkCmdCopyImage(commands, picture_.blurred.handle, VK_IMAGE_LAYOUT_GENERAL, picture_.radiance.handle,
                   VK_IMAGE_LAYOUT_GENERAL, 1, &whole);
  }

 private:
  const PictureImages& picture_;
  int width_;
  int height_;
  std::array<float, 2> push_;
  BoundPipeline tiles_, blur_;
};

}  // namespace

const PassEntry kBlurPass{"blur",
                          has_depth_of_field,
                          [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
                          [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                            FL_ASSIGN(auto tiles, BoundPipeline::compute(context, kBlurtilesComp, {}));
                            FL_ASSIGN(auto blur, BoundPipeline::compute(context, kBlurComp, {}));
                            return std::unique_ptr<Pass>(new BlurPass(context.settings, context.resources.picture,
                                                                      std::move(tiles), std::move(blur)));
                          },
                          [] {
                            return std::vector<std::vector<vk::Spirv>>{{kBlurtilesComp}, {kBlurComp}};
                          },
                          "depth of field: what is out of focus is blurred"};

}  // namespace footlight::render
