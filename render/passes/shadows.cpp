#include "render/passes/shadows.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "render/passes/compute_pass.h"
#include "render/shadow_tables.h"
#include "shaders/occludergroups.comp.h"
#include "shaders/occluders.comp.h"
#include "shaders/mapshadows.comp.h"
#include "shaders/places.comp.h"
#include "shaders/prune.comp.h"
#include "shaders/shadows.comp.h"

namespace footlight::render {
namespace {

// The steps in their order; those that are not needed are not there.
struct ShadowSteps {
  std::optional<BoundPipeline> bodies;
  std::optional<BoundPipeline> groups;
  std::optional<BoundPipeline> maps;  // or count, write and prune
  std::optional<BoundPipeline> count;
  std::optional<BoundPipeline> places;
  std::optional<BoundPipeline> write;
  std::optional<BoundPipeline> prune;
};

class ShadowsPass final : public Pass {
 public:
  ShadowsPass(ShadowSteps steps, const RigTables& rig) : steps_(std::move(steps)), rig_(rig) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    if (steps_.bodies && rig_.slot_count > 0) {
      steps_.bodies->bind(commands);
      const std::uint32_t boxes = rig_.slot_count * FL_BODY_BOXES;
      vkCmdDispatch(commands, groups_of(boxes, FL_GROUP_HEADS), 1, 1);
      vk::full_barrier(commands);
    }
    if (steps_.groups) {
      steps_.groups->bind(commands);
      const std::uint64_t bodies = rig_.occluders.size_bytes / sizeof(OccluderRow);
      vkCmdDispatch(commands, groups_of(static_cast<std::uint32_t>(occluder_groups(bodies)), FL_GROUP_HEADS), 1, 1);
      vk::full_barrier(commands);
    }
    each_beam(commands, steps_.maps ? *steps_.maps : *steps_.count);
    vk::full_barrier(commands);
    steps_.places->bind(commands);
    vkCmdDispatch(commands, 1, 1, 1);
    if (steps_.maps) return;
    vk::full_barrier(commands);
    each_beam(commands, *steps_.write);
    vk::full_barrier(commands);
    each_beam(commands, *steps_.prune);
  }

 private:
  void each_beam(VkCommandBuffer commands, const BoundPipeline& step) const {
    step.bind(commands);
    vkCmdDispatchIndirect(commands, rig_.counts.handle, offsetof(CountsRow, shadow_groups));
  }

  ShadowSteps steps_;
  const RigTables& rig_;
};

}  // namespace

const PassEntry kShadowsPass{
    "shadows",
    has_shadows,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_RECTANGLE, needs.rectangle},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                           {FL_SPEC_PENUMBRA, lens_points(needs, settings)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      ShadowSteps steps;
      if (context.resources.rig.has_bodies && context.settings.bodies) {
        FL_ASSIGN(steps.bodies, BoundPipeline::compute(context, kOccludersComp, {}));
      }
      FL_ASSIGN(steps.places, BoundPipeline::compute(context, kPlacesComp, context.constants));
      if (context.resources.rig.shadow_map_px > 0) {
        FL_ASSIGN(steps.groups, BoundPipeline::compute(context, kOccludergroupsComp, {}));
        FL_ASSIGN(steps.maps, BoundPipeline::compute(context, kMapshadowsComp, context.constants));
      } else {
        std::vector<vk::SpecConstant> writes = context.constants;
        writes.push_back({FL_SPEC_WRITE, 1});
        FL_ASSIGN(steps.count, BoundPipeline::compute(context, kShadowsComp, context.constants));
        FL_ASSIGN(steps.write, BoundPipeline::compute(context, kShadowsComp, writes));
        FL_ASSIGN(steps.prune, BoundPipeline::compute(context, kPruneComp, context.constants));
      }
      return std::unique_ptr<Pass>(new ShadowsPass(std::move(steps), context.resources.rig));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{
          {kOccludersComp},  {kShadowsComp}, {kPlacesComp},         {kPruneComp},
          {kMapshadowsComp}, {kOccludergroupsComp}};
    },
    "shadows of boxes and fixtures",
    nullptr,
    true};

}  // namespace footlight::render
