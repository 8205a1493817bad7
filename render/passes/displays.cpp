#include "render/passes/displays.h"

#include <utility>

#include "render/passes/compute_pass.h"
#include "shaders/displaycells.comp.h"
#include "shaders/displays.comp.h"
#include "shaders/hazedisplays.comp.h"

namespace footlight::render {
namespace {

class DisplaysPass final : public Pass {
 public:
  DisplaysPass(const PassContext& context, BoundPipeline cells, BoundPipeline light)
      : rig_(context.resources.rig),
        still_(rig_.display_still),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        cells_(std::move(cells)),
        light_(std::move(light)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    if (!std::exchange(rig_.display_cells_fresh, true)) {
      record_jobs(commands, still_);
      still_.clear();  // images stay
      if (std::exchange(rig_.display_films_new, false)) record_jobs(commands, rig_.display_film);
      record_jobs(commands, rig_.display_live);
    }
    light_.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  // Each level is made of the one below.
  void record_jobs(VkCommandBuffer commands, const DisplayJobs& jobs) {
    for (const DisplayJobRange& range : jobs) {
      cells_.bind(commands);
      cells_.pipeline->push(commands, std::as_bytes(std::span(&range.first, 1)));
      vkCmdDispatch(commands, range.count, 1, 1);
      vk::full_barrier(commands);
    }
  }

  RigTables& rig_;
  DisplayJobs still_;
  std::uint32_t tiles_x_, tiles_y_;
  BoundPipeline cells_, light_;
};

}  // namespace

const PassEntry kDisplaysPass{
    "displays",
    has_displays,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{
          {FL_SPEC_EXTINCTION, needs.extinction},
          {FL_SPEC_BOXES, needs.surfaces},
          {FL_SPEC_BODIES, has_bodies(needs, settings)},
          {FL_SPEC_SHEEN, has_sheen(needs, settings)},
          {FL_SPEC_AIR, has_displays_in_air(needs, settings)},
          // Frames that are compared with the judge, which takes rays and no pixels, have whole images.
          {FL_SPEC_DETAIL, settings.widen_thin},
          {FL_SPEC_GLOSS, has_gloss(needs, settings)},
          {FL_SPEC_HAZE, has_displays_in_air(needs, settings) && has_haze_field(needs, settings)},
          {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const vk::Spirv spirv =
          has_constant(context, FL_SPEC_HAZE) ? vk::Spirv(kHazedisplaysComp) : vk::Spirv(kDisplaysComp);
      FL_ASSIGN(auto cells, BoundPipeline::compute(context, kDisplaycellsComp, {}));
      FL_ASSIGN(auto light, BoundPipeline::compute(context, spirv, context.constants));
      return std::unique_ptr<Pass>(new DisplaysPass(context, std::move(cells), std::move(light)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kDisplaycellsComp}, {kDisplaysComp}, {kHazedisplaysComp}};
    },
    "displays, and their light in the air and on surfaces"};

}  // namespace footlight::render
