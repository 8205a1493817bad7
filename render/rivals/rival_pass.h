// What the passes of rivals are made of: buffers and images of their own, and steps that are recorded in order with
// full barriers between them.
//
//   auto pass = std::make_unique<RivalPass>(context);
//   FL_TRY(pass->add_buffer(FL_BINDING_BOUNDS, sizeof(BoundsRow)));
//   FL_TRY(pass->add_compute(kBoundsComp, [](VkCommandBuffer commands) { vkCmdDispatch(commands, 1, 1, 1); }));
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "render/pass.h"
#include "render/passes/compute_pass.h"

namespace footlight::render {
#include "render/rivals/shared/rival_io.h"

static_assert(sizeof(BoundsRow) == 32);

class RivalPass final : public Pass {
 public:
  using Commands = std::function<void(VkCommandBuffer)>;

  // `more`: constants of the rival, besides those of the context.
  explicit RivalPass(const PassContext& context, const std::vector<vk::SpecConstant>& more = {});

  Status add_buffer(std::uint32_t binding, VkDeviceSize bytes);
  // A step; `dispatch` finds the pipeline and its descriptors bound.
  Status add_compute(vk::Spirv spirv, Commands dispatch);
  // The box of all live beams, at FL_BINDING_BOUNDS.
  Status add_bounds();
  // One triangle mesh of `vertices` for each live beam, whose colours add up, and that sum added to the radiance.
  Status add_meshes(vk::Spirv vertex, vk::Spirv fragment, std::uint32_t vertices);

  void record(VkCommandBuffer commands, std::span<const std::byte> push) override;
  [[nodiscard]] std::uint64_t own_bytes() const override;

 private:
  struct Step {
    std::shared_ptr<const vk::Pipeline> pipeline;
    vk::BindingSet set;
    Commands dispatch;
  };
  vk::Device& device_;
  const Resources& resources_;
  std::vector<vk::SpecConstant> constants_;
  std::uint32_t width_;
  std::uint32_t height_;
  std::vector<vk::Buffer> buffers_;
  std::vector<vk::Image> images_;
  vk::BindingTable bindings_;
  std::vector<Step> steps_;
};

// A dispatch over the tiles of a picture in which something is lit, as the beam pass has.
[[nodiscard]] RivalPass::Commands tiles_of_beams(const PassContext& context);

// Frames of rivals in the air have the constants of the beam pass, and no part of the product's methods.
[[nodiscard]] std::vector<vk::SpecConstant> rival_constants(const fixtures::Needs& needs,
                                                            const FrameSettings& settings);
// Every beam by itself; the knob is FrameSettings::nodes.
[[nodiscard]] FrameSettings rival_settings(FrameSettings judged, double knob);

}  // namespace footlight::render
