// What most passes are: one compute pipeline.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/pass.h"

namespace footlight::render {

// Groups of FL_TILE_PX pixels that cover the picture.
[[nodiscard]] inline std::uint32_t tile_groups(int size_px) {
  return (static_cast<std::uint32_t>(size_px) + FL_TILE_PX - 1) / FL_TILE_PX;
}

// One pipeline of a pass that has several.
struct ComputeStep {
  std::shared_ptr<const vk::Pipeline> pipeline;
  vk::BindingSet set;

  [[nodiscard]] static Result<ComputeStep> create(const PassContext& context, vk::Spirv spirv,
                                                  const std::vector<vk::SpecConstant>& constants) {
    ComputeStep step;
    FL_ASSIGN(step.pipeline, context.device.pipelines().compute(spirv, constants));
    FL_ASSIGN(step.set, vk::BindingSet::create(context.device, *step.pipeline, context.resources.bindings));
    return step;
  }
  void bind(VkCommandBuffer commands) const { pipeline->bind(commands, set); }
};

// Dispatch: a callable (VkCommandBuffer); the pipeline and its descriptors are bound before.
template <class Dispatch>
class ComputePass final : public Pass {
 public:
  ComputePass(std::shared_ptr<const vk::Pipeline> pipeline, vk::BindingSet set, Dispatch dispatch)
      : pipeline_(std::move(pipeline)), set_(std::move(set)), dispatch_(std::move(dispatch)) {}
  void record(VkCommandBuffer commands, std::span<const std::byte> push) override {
    pipeline_->bind(commands, set_);
    pipeline_->push(commands, push);
    dispatch_(commands);
  }

 private:
  std::shared_ptr<const vk::Pipeline> pipeline_;
  vk::BindingSet set_;
  Dispatch dispatch_;
};

template <class Dispatch>
[[nodiscard]] Result<std::unique_ptr<Pass>> make_compute_pass(const PassContext& context, vk::Spirv spirv,
                                                              Dispatch dispatch) {
  FL_ASSIGN(auto pipeline, context.device.pipelines().compute(spirv, context.constants));
  FL_ASSIGN(vk::BindingSet set, vk::BindingSet::create(context.device, *pipeline, context.resources.bindings));
  return std::unique_ptr<Pass>(new ComputePass<Dispatch>(std::move(pipeline), std::move(set), std::move(dispatch)));
}

}  // namespace footlight::render
