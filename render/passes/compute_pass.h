// What most passes are: one compute pipeline.
#pragma once

#include <memory>
#include <span>
#include <utility>

#include "render/pass.h"

namespace footlight::render {

// Groups of FL_TILE_PX pixels that cover the picture.
[[nodiscard]] inline std::uint32_t tile_groups(int size_px) {
  return (static_cast<std::uint32_t>(size_px) + FL_TILE_PX - 1) / FL_TILE_PX;
}

// Dispatch: a callable (VkCommandBuffer, const PassContext-made copies); bound pipeline first.
template <class Dispatch>
class ComputePass final : public Pass {
 public:
  ComputePass(vk::Pipeline pipeline, Dispatch dispatch)
      : pipeline_(std::move(pipeline)), dispatch_(std::move(dispatch)) {}
  void record(VkCommandBuffer commands) override {
    pipeline_.bind(commands);
    dispatch_(commands);
  }

 private:
  vk::Pipeline pipeline_;
  Dispatch dispatch_;
};

template <class Dispatch>
[[nodiscard]] Result<std::unique_ptr<Pass>> make_compute_pass(const PassContext& context,
                                                              std::span<const std::uint32_t> spirv, Dispatch dispatch) {
  FL_ASSIGN(vk::Pipeline pipeline,
            vk::Pipeline::compute(context.device, context.resources.bindings, spirv, context.constants));
  return std::unique_ptr<Pass>(new ComputePass<Dispatch>(std::move(pipeline), std::move(dispatch)));
}

}  // namespace footlight::render
