#include "render/passes/shadows.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "render/passes/compute_pass.h"
#include "shaders/occluders.comp.h"
#include "shaders/places.comp.h"
#include "shaders/prune.comp.h"
#include "shaders/shadows.comp.h"

namespace footlight::render {
namespace {

class ShadowsPass final : public Pass {
 public:
  ShadowsPass(std::optional<BoundPipeline> bodies, BoundPipeline count, BoundPipeline places, BoundPipeline write,
              BoundPipeline prune, const RigTables& rig)
      : bodies_(std::move(bodies)),
        count_(std::move(count)),
        places_(std::move(places)),
        write_(std::move(write)),
        prune_(std::move(prune)),
        rig_(rig) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    if (bodies_ && rig_.slot_count > 0) {
      bodies_->bind(commands);
      const std::uint32_t boxes = rig_.slot_count * FL_BODY_BOXES;
      vkCmdDispatch(commands, groups_of(boxes, FL_GROUP_HEADS), 1, 1);
      vk::full_barrier(commands);
    }
    each_beam(commands, count_);
    vk::full_barrier(commands);
    places_.bind(commands);
    vkCmdDispatch(commands, 1, 1, 1);
    vk::full_barrier(commands);
    each_beam(commands, write_);
    vk::full_barrier(commands);
    each_beam(commands, prune_);
  }

 private:
  void each_beam(VkCommandBuffer commands, const BoundPipeline& step) const {
    step.bind(commands);
    vkCmdDispatchIndirect(commands, rig_.counts.handle, offsetof(CountsRow, shadow_groups));
  }

  std::optional<BoundPipeline> bodies_;
  BoundPipeline count_;
  BoundPipeline places_;
  BoundPipeline write_;
  BoundPipeline prune_;
  const RigTables& rig_;
};

}  // namespace

const PassEntry kShadowsPass{
    "shadows",
    has_shadows,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_RECTANGLE, needs.rectangle},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      std::optional<BoundPipeline> bodies;
      if (context.resources.rig.has_bodies && context.settings.bodies) {
        FL_ASSIGN(bodies, BoundPipeline::compute(context, kOccludersComp, {}));
      }
      std::vector<vk::SpecConstant> writes = context.constants;
      writes.push_back({FL_SPEC_WRITE, 1});
      FL_ASSIGN(BoundPipeline count, BoundPipeline::compute(context, kShadowsComp, context.constants));
      FL_ASSIGN(BoundPipeline places, BoundPipeline::compute(context, kPlacesComp, {}));
      FL_ASSIGN(BoundPipeline write, BoundPipeline::compute(context, kShadowsComp, writes));
      FL_ASSIGN(BoundPipeline prune, BoundPipeline::compute(context, kPruneComp, context.constants));
      return std::unique_ptr<Pass>(new ShadowsPass(std::move(bodies), std::move(count), std::move(places),
                                                   std::move(write), std::move(prune), context.resources.rig));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kOccludersComp}, {kShadowsComp}, {kPlacesComp}, {kPruneComp}};
    },
    "shadows of boxes and fixtures"};

}  // namespace footlight::render
