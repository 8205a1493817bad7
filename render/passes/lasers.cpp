#include "render/passes/lasers.h"

#include <algorithm>

#include "render/passes/compute_pass.h"
#include "shaders/hazelasers.comp.h"
#include "shaders/laserair.comp.h"
#include "shaders/lasermasks.comp.h"
#include "shaders/laserrows.comp.h"
#include "shaders/lasers.comp.h"
#include "shaders/laserstrips.comp.h"

namespace footlight::render {
namespace {

class LasersPass final : public Pass {
 public:
  struct Steps {
    BoundPipeline rows, masks, strips, air, light;
  };
  LasersPass(const PassContext& context, Steps steps, bool has_air)
      : rows_count_(context.resources.rig.laser_rows),
        supertiles_x_(context.resources.picture.supertiles_x),
        supertiles_y_(context.resources.picture.supertiles_y),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        has_air_(has_air),
        bits_(context.resources.picture.laser_masks.handle),
        lists_(context.resources.picture.laser_lists.handle),
        steps_(std::move(steps)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    vkCmdFillBuffer(commands, bits_, 0, VK_WHOLE_SIZE, 0);
    vkCmdFillBuffer(commands, lists_, 0, VK_WHOLE_SIZE, 0);
    steps_.rows.bind(commands);
    vkCmdDispatch(commands, groups_of(rows_count_, FL_GROUP_LASERS), 1, 1);
    vk::full_barrier(commands);
    steps_.masks.bind(commands);
    vkCmdDispatch(commands, std::min(rows_count_, kRowsAcross), groups_of(rows_count_, kRowsAcross), 1);
    vk::full_barrier(commands);
    if (has_air_) {
      steps_.strips.bind(commands);
      vkCmdDispatch(commands, supertiles_x_, supertiles_y_, 1);
      vk::full_barrier(commands);
      steps_.air.bind(commands);
      vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
      vk::full_barrier(commands);
    }
    steps_.light.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  static constexpr std::uint32_t kRowsAcross = 32'768;  // any device takes so many workgroups in a line

  std::uint32_t rows_count_, supertiles_x_, supertiles_y_, tiles_x_, tiles_y_;
  bool has_air_;
  VkBuffer bits_, lists_;
  Steps steps_;
};

}  // namespace

const PassEntry kLasersPass{
    "lasers",
    has_lasers,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return with_plumes(needs.plumes, {{FL_SPEC_EXTINCTION, needs.extinction},
                                        {FL_SPEC_BOXES, needs.surfaces},
                                        {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                        {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                                        {FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                        {FL_SPEC_LASER, has_air(needs, settings)},
                                        {FL_SPEC_TILES, settings.tile_error > 0},
                                        {FL_SPEC_HAZE, has_haze_field(needs, settings)},
                                        {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}});
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool haze = has_constant(context, FL_SPEC_HAZE);
      LasersPass::Steps steps;
      FL_ASSIGN(steps.rows, BoundPipeline::compute(context, kLaserrowsComp, context.constants));
      FL_ASSIGN(steps.masks, BoundPipeline::compute(context, kLasermasksComp, context.constants));
      const bool air = has_constant(context, FL_SPEC_LASER) && has_constant(context, FL_SPEC_TILES) && !haze &&
                       context.settings.view == FrameView::kPicture;  // as has_laser_strips()
      if (air) {
        FL_ASSIGN(steps.strips, BoundPipeline::compute(context, kLaserstripsComp, context.constants));
        FL_ASSIGN(steps.air, BoundPipeline::compute(context, kLaserairComp, context.constants));
      }
      const vk::Spirv light = haze ? vk::Spirv(kHazelasersComp) : vk::Spirv(kLasersComp);
      FL_ASSIGN(steps.light, BoundPipeline::compute(context, light, context.constants));
      return std::unique_ptr<Pass>(new LasersPass(context, std::move(steps), air));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kLaserrowsComp}, {kLasermasksComp}, {kLaserstripsComp},
                                                 {kLaserairComp},  {kLasersComp},     {kHazelasersComp}};
    },
    "scanned lasers"};

}  // namespace footlight::render
