#include "render/passes/shafts.h"

#include <optional>
#include <utility>

#include "fixtures/glass/pane.h"
#include "render/passes/compute_pass.h"
#include "shaders/hazeshafts.comp.h"
#include "shaders/shaftmasks.comp.h"
#include "shaders/shafts.comp.h"

namespace footlight::render {
namespace {

static_assert(FL_PANES_MAX == fixtures::kPanesMax);

class ShaftsPass final : public Pass {
 public:
  ShaftsPass(const PassContext& context, std::optional<BoundPipeline> masks, BoundPipeline light)
      : words_(context.resources.rig.occluder_words),
        panes_(context.resources.rig.pane_count),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        masks_(std::move(masks)),
        light_(std::move(light)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    if (masks_) {
      masks_->bind(commands);
      vkCmdDispatch(commands, groups_of(words_, FL_GROUP_SHAFTS), panes_, 1);
      vk::full_barrier(commands);
    }
    light_.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  std::uint32_t words_, panes_, tiles_x_, tiles_y_;
  std::optional<BoundPipeline> masks_;
  BoundPipeline light_;
};

}  // namespace

const PassEntry kShaftsPass{
    "shafts",
    has_shafts,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{
          {FL_SPEC_EXTINCTION, needs.extinction},
          {FL_SPEC_BOXES, needs.surfaces},
          {FL_SPEC_BODIES, has_bodies(needs, settings)},
          {FL_SPEC_SHEEN, has_sheen(needs, settings)},
          {FL_SPEC_SHADOWS, has_shafts_shadowed(needs, settings)},
          {FL_SPEC_AIR, has_shafts_in_air(needs, settings)},
          // Frames that are compared with the judge, which takes rays and no pixels, have whole images.
          {FL_SPEC_DETAIL, settings.widen_thin},
          {FL_SPEC_HAZE, has_shafts_in_air(needs, settings) && has_haze_field(needs, settings)},
          {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const vk::Spirv spirv = has_constant(context, FL_SPEC_HAZE) ? vk::Spirv(kHazeshaftsComp) : vk::Spirv(kShaftsComp);
      std::optional<BoundPipeline> masks;
      if (has_constant(context, FL_SPEC_SHADOWS)) {
        FL_ASSIGN(masks, BoundPipeline::compute(context, kShaftmasksComp, context.constants));
      }
      FL_ASSIGN(auto light, BoundPipeline::compute(context, spirv, context.constants));
      return std::unique_ptr<Pass>(new ShaftsPass(context, std::move(masks), std::move(light)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kShaftmasksComp}, {kShaftsComp}, {kHazeshaftsComp}};
    },
    "shafts of sunlight behind panes, and the panes"};

}  // namespace footlight::render
