#include "render/passes/beams.h"

#include <cstddef>

#include "render/passes/compute_pass.h"
#include "shaders/beams.comp.h"
#include "shaders/cutbeams.comp.h"
#include "shaders/gobobeams.comp.h"
#include "shaders/hazebeams.comp.h"
#include "shaders/hazegobobeams.comp.h"
#include "shaders/hazerowgobobeams.comp.h"
#include "shaders/plainbeams.comp.h"
#include "shaders/rowgobobeams.comp.h"

namespace footlight::render {

namespace {

// Dispatched indirectly: a frame in which nothing is lit does no work here.
class BeamsPass final : public Pass {
 public:
  BeamsPass(BoundPipeline plain, BoundPipeline all, VkBuffer counts)
      : plain_(std::move(plain)), all_(std::move(all)), counts_(counts) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    if (plain_.pipeline) {
      dispatch(commands, plain_);
      vk::full_barrier(commands);
    }
    dispatch(commands, all_);
  }

 private:
  void dispatch(VkCommandBuffer commands, const BoundPipeline& pipeline) {
    pipeline.bind(commands);
    vkCmdDispatchIndirect(commands, counts_, offsetof(CountsRow, beams_groups));
  }

  BoundPipeline plain_;  // may be none
  BoundPipeline all_;    // of what that has left
  VkBuffer counts_;
};

}  // namespace

const PassEntry kBeamsPass{
    "beams",
    has_air,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return with_plumes(needs.plumes, {{FL_SPEC_GOBO, needs.gobo},
                                        {FL_SPEC_EXTINCTION, needs.extinction},
                                        {FL_SPEC_PROFILE, needs.profile},
                                        {FL_SPEC_METHOD, static_cast<uint>(settings.method)},
                                        {FL_SPEC_NODES, settings.nodes},
                                        {FL_SPEC_GOBO_TAPS, settings.gobo_taps},
                                        {FL_SPEC_BOXES, needs.surfaces},
                                        {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                        {FL_SPEC_BLADES, needs.blades},
                                        {FL_SPEC_FOCUS, needs.focus},
                                        {FL_SPEC_ANIMATION, needs.animation},
                                        {FL_SPEC_MEASURED, needs.measured},
                                        {FL_SPEC_RECTANGLE, needs.rectangle},
                                        {FL_SPEC_TILES, has_tile_classes(needs, settings)},
                                        {FL_SPEC_WIDE, needs.wide},
                                        {FL_SPEC_IRIS, needs.iris},
                                        {FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                        {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                        {FL_SPEC_PENUMBRA, lens_points(needs, settings)},
                                        {FL_SPEC_HAZE, uneven_haze(needs)},
                                        {FL_SPEC_GLOSS, has_gloss(needs, settings)},
                                        {FL_SPEC_PLAIN_BEAMS, has_plain_beams(needs, settings)},
                                        {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)},
                                        {FL_SPEC_GOBO_METHOD, settings.gobo_method == GoboMethod::kSuited
                                                                  ? FL_GOBO_TABLES
                                                                  : static_cast<uint>(settings.gobo_method)}});
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool haze = has_constant(context, FL_SPEC_HAZE);
      vk::Spirv spirv = haze ? vk::Spirv(kHazebeamsComp) : vk::Spirv(kBeamsComp);
      if (has_constant(context, FL_SPEC_GOBO)) {
        spirv = haze ? vk::Spirv(kHazegobobeamsComp) : vk::Spirv(kGobobeamsComp);
        // GPUs have tables, and are quicker with one pixel a thread (beams.comp).
        if (context.settings.gobo_method == GoboMethod::kTables) {
          spirv = haze ? vk::Spirv(kHazerowgobobeamsComp) : vk::Spirv(kRowgobobeamsComp);
        }
      }
      BoundPipeline plain;
      if (has_constant(context, FL_SPEC_PLAIN_BEAMS)) {
        const bool cut = has_constant(context, FL_SPEC_SHADOWS) && !has_constant(context, FL_SPEC_MAP_PX);
        const vk::Spirv own = cut ? vk::Spirv(kCutbeamsComp) : vk::Spirv(kPlainbeamsComp);
        FL_ASSIGN(plain, BoundPipeline::compute(context, own, context.constants));
      }
      FL_ASSIGN(BoundPipeline all, BoundPipeline::compute(context, spirv, context.constants));
      return std::unique_ptr<Pass>(
          new BeamsPass(std::move(plain), std::move(all), context.resources.rig.counts.handle));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{
          {kBeamsComp},     {kGobobeamsComp},     {kRowgobobeamsComp},
          {kHazebeamsComp}, {kHazegobobeamsComp}, {kHazerowgobobeamsComp},
          {kPlainbeamsComp}, {kCutbeamsComp}};
    },
    "beams in the air"};

}  // namespace footlight::render
