#include "render/passes/shafts.h"

#include <optional>
#include <utility>

#include "fixtures/glass/pane.h"
#include "render/passes/compute_pass.h"
#include "shaders/hazeshafts.comp.h"
#include "shaders/shaftfans.comp.h"
#include "shaders/shaftlight.comp.h"
#include "shaders/shaftlines.comp.h"
#include "shaders/shaftmasks.comp.h"
#include "shaders/shafts.comp.h"

namespace footlight::render {
namespace {

static_assert(FL_PANES_MAX == fixtures::kPanesMax);

class ShaftsPass final : public Pass {
 public:
  struct Steps {
    std::optional<BoundPipeline> masks, fans, lines;
    BoundPipeline light;
  };
  ShaftsPass(const PassContext& context, Steps steps, bool has_tables)
      : words_(context.resources.rig.occluder_words),
        masked_(has_tables ? context.resources.rig.pane_group_count : context.resources.rig.pane_count),
        groups_(context.resources.rig.pane_group_count),
        lines_(context.resources.rig.pane_lines_most),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(has_tables ? groups_of(static_cast<std::uint32_t>(context.settings.height), FL_SHAFT_ROWS)
                            : tile_groups(context.settings.height)),
        steps_(std::move(steps)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    if (steps_.masks) {
      steps_.masks->bind(commands);
      vkCmdDispatch(commands, groups_of(words_, FL_GROUP_SHAFTS), masked_, 1);
    }
    if (steps_.lines) {
      steps_.fans->bind(commands);
      vkCmdDispatch(commands, groups_of(groups_, FL_GROUP_PANE_FANS), 1, 1);
      vk::full_barrier(commands);
      steps_.lines->bind(commands);
      vkCmdDispatch(commands, lines_, groups_, 1);
    }
    if (steps_.masks || steps_.lines) vk::full_barrier(commands);
    steps_.light.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  std::uint32_t words_, masked_, groups_, lines_, tiles_x_, tiles_y_;
  Steps steps_;
};

}  // namespace

const PassEntry kShaftsPass{
    "shafts",
    has_shafts,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return with_plumes(needs.plumes && has_shafts_in_air(needs, settings),
                         {{FL_SPEC_EXTINCTION, needs.extinction},
                          {FL_SPEC_BOXES, needs.surfaces},
                          {FL_SPEC_BODIES, has_bodies(needs, settings)},
                          {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                          {FL_SPEC_SHADOWS, has_shafts_shadowed(needs, settings)},
                          {FL_SPEC_AIR, has_shafts_in_air(needs, settings)},
                          // Frames that are compared with the judge, which takes rays and no pixels, have whole images.
                          {FL_SPEC_DETAIL, settings.widen_thin},
                          {FL_SPEC_TILES, settings.tile_error > 0 && settings.view == FrameView::kPicture},
                          {FL_SPEC_HAZE, has_shafts_in_air(needs, settings) && has_haze_field(needs, settings)},
                          {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}});
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool haze = has_constant(context, FL_SPEC_HAZE);
      const bool tables = has_constant(context, FL_SPEC_TILES) && !haze;
      ShaftsPass::Steps steps;
      if (has_constant(context, FL_SPEC_SHADOWS)) {
        FL_ASSIGN(steps.masks, BoundPipeline::compute(context, kShaftmasksComp, context.constants));
      }
      if (tables && has_constant(context, FL_SPEC_AIR)) {
        FL_ASSIGN(steps.fans, BoundPipeline::compute(context, kShaftfansComp, context.constants));
        FL_ASSIGN(steps.lines, BoundPipeline::compute(context, kShaftlinesComp, context.constants));
      }
      const vk::Spirv light = tables ? vk::Spirv(kShaftlightComp)
                              : haze ? vk::Spirv(kHazeshaftsComp)
                                     : vk::Spirv(kShaftsComp);
      FL_ASSIGN(steps.light, BoundPipeline::compute(context, light, context.constants));
      return std::unique_ptr<Pass>(new ShaftsPass(context, std::move(steps), tables));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kShaftmasksComp}, {kShaftfansComp}, {kShaftlinesComp},
                                                 {kShaftlightComp}, {kShaftsComp},    {kHazeshaftsComp}};
    },
    "shafts of sunlight behind panes, and the panes"};

}  // namespace footlight::render
