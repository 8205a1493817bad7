// What most passes are: one compute pipeline.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/pass.h"

namespace footlight::render {

// Workgroups that cover `count` threads, pixels and so on.
[[nodiscard]] constexpr std::uint32_t groups_of(std::uint32_t count, std::uint32_t of_a_group) {
  return (count + of_a_group - 1) / of_a_group;
}
// Groups of FL_TILE_PX pixels that cover the picture.
[[nodiscard]] inline std::uint32_t tile_groups(int size_px) {
  return groups_of(static_cast<std::uint32_t>(size_px), FL_TILE_PX);
}

// Whether threads share what all of a subgroup read (shaders/lib/alike.glsl).
[[nodiscard]] inline bool reads_alike(const vk::Device& device) {
  return device.is_software() && vk::compute_subgroup_size(device.facts()) == 8;
}

// A pipeline with its descriptors. It may be bound after Pipelines::finish(), with which Frame::change() ends.
struct BoundPipeline {
  std::shared_ptr<const vk::Pipeline> pipeline;  // null: none
  vk::BindingSet set;

  [[nodiscard]] static Result<BoundPipeline> create(const PassContext& context,
                                                    std::shared_ptr<const vk::Pipeline> pipeline) {
    if (context.only_pipelines) return BoundPipeline{std::move(pipeline), {}};
    FL_ASSIGN(vk::BindingSet set, vk::BindingSet::create(context.device, *pipeline, context.resources.bindings));
    return BoundPipeline{std::move(pipeline), std::move(set)};
  }
  [[nodiscard]] static Result<BoundPipeline> compute(const PassContext& context, vk::Spirv spirv,
                                                     const std::vector<vk::SpecConstant>& constants) {
    std::vector<vk::SpecConstant> all = constants;
    all.push_back({FL_SPEC_ALIKE_READS, reads_alike(context.device)});
    FL_ASSIGN(auto pipeline, context.device.pipelines().begin_compute(spirv, all));
    return create(context, std::move(pipeline));
  }
  void bind(VkCommandBuffer commands) const { pipeline->bind(commands, set); }
};

// Dispatch: a callable (VkCommandBuffer); the pipeline and its descriptors are bound before.
template <class Dispatch>
class ComputePass final : public Pass {
 public:
  ComputePass(BoundPipeline bound, Dispatch dispatch) : bound_(std::move(bound)), dispatch_(std::move(dispatch)) {}
  void record(VkCommandBuffer commands, std::span<const std::byte> push) override {
    bound_.bind(commands);
    bound_.pipeline->push(commands, push);
    dispatch_(commands);
  }

 private:
  BoundPipeline bound_;
  Dispatch dispatch_;
};

template <class Dispatch>
[[nodiscard]] Result<std::unique_ptr<Pass>> make_compute_pass(const PassContext& context, vk::Spirv spirv,
                                                              Dispatch dispatch) {
  FL_ASSIGN(BoundPipeline bound, BoundPipeline::compute(context, spirv, context.constants));
  return std::unique_ptr<Pass>(new ComputePass<Dispatch>(std::move(bound), std::move(dispatch)));
}

}  // namespace footlight::render
