#include "render/passes/lasers.h"

#include <algorithm>

#include "render/passes/compute_pass.h"
#include "shaders/hazelasers.comp.h"
#include "shaders/lasermasks.comp.h"
#include "shaders/laserrows.comp.h"
#include "shaders/lasers.comp.h"

namespace footlight::render {
namespace {

class LasersPass final : public Pass {
 public:
  LasersPass(const PassContext& context, BoundPipeline rows, BoundPipeline masks, BoundPipeline light)
      : rows_count_(context.resources.rig.laser_rows),
        tiles_x_(groups_of(static_cast<std::uint32_t>(context.settings.width), FL_TILE_PX)),
        tiles_y_(groups_of(static_cast<std::uint32_t>(context.settings.height), FL_TILE_PX)),
        bits_(context.resources.picture.laser_masks.handle),
        rows_(std::move(rows)),
        masks_(std::move(masks)),
        light_(std::move(light)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    vkCmdFillBuffer(commands, bits_, 0, VK_WHOLE_SIZE, 0);
    rows_.bind(commands);
    vkCmdDispatch(commands, groups_of(rows_count_, FL_GROUP_LASERS), 1, 1);
    vk::full_barrier(commands);
    masks_.bind(commands);
    vkCmdDispatch(commands, std::min(rows_count_, kRowsAcross), groups_of(rows_count_, kRowsAcross), 1);
    vk::full_barrier(commands);
    light_.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  static constexpr std::uint32_t kRowsAcross = 32'768;  // any device takes so many workgroups in a line

  std::uint32_t rows_count_, tiles_x_, tiles_y_;
  VkBuffer bits_;
  BoundPipeline rows_, masks_, light_;
};

}  // namespace

const PassEntry kLasersPass{
    "lasers",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      // Frames that are compared with the judge of beams, which has no lasers, are drawn without.
      return needs.fixtures && needs.laser && settings.widen_thin && settings.view != FrameView::kClasses &&
             (has_air(needs, settings) || has_solids(needs, settings));
    },
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_EXTINCTION, needs.extinction},
                                           {FL_SPEC_BOXES, needs.surfaces},
                                           {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                           {FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                           {FL_SPEC_LASER, has_air(needs, settings)},
                                           {FL_SPEC_HAZE, has_haze_field(needs, settings)},
                                           {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const vk::Spirv light = has_constant(context, FL_SPEC_HAZE) ? vk::Spirv(kHazelasersComp) : vk::Spirv(kLasersComp);
      FL_ASSIGN(auto rows, BoundPipeline::compute(context, kLaserrowsComp, context.constants));
      FL_ASSIGN(auto masks, BoundPipeline::compute(context, kLasermasksComp, context.constants));
      FL_ASSIGN(auto lights, BoundPipeline::compute(context, light, context.constants));
      return std::unique_ptr<Pass>(new LasersPass(context, std::move(rows), std::move(masks), std::move(lights)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kLaserrowsComp}, {kLasermasksComp}, {kLasersComp}, {kHazelasersComp}};
    },
    "scanned lasers"};

}  // namespace footlight::render
