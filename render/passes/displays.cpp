#include "render/passes/displays.h"

#include <utility>

#include "render/passes/compute_pass.h"
#include "render/passes/display_cells.h"
#include "shaders/displaycells.comp.h"
#include "shaders/displaylists.comp.h"
#include "shaders/displaynodes.comp.h"
#include "shaders/displaypixels.comp.h"
#include "shaders/displayposes.comp.h"
#include "shaders/displays.comp.h"
#include "shaders/displaytiles.comp.h"
#include "shaders/hazedisplaynodes.comp.h"
#include "shaders/hazedisplaypixels.comp.h"

namespace footlight::render {
namespace {

class DisplaysPass final : public Pass {
 public:
  // Without records each pixel is computed by itself: tiles, lists and nodes are null. Without displays that move poses
  // is null.
  struct Steps {
    DisplayCells cells;
    BoundPipeline poses, tiles, lists, nodes, light, pixels;
  };
  DisplaysPass(const PassContext& context, Steps steps, bool has_records)
      : rig_(context.resources.rig),
        supertiles_x_(context.resources.picture.supertiles_x),
        supertiles_y_(context.resources.picture.supertiles_y),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        has_records_(has_records),
        records_(context.resources.picture.display_records.handle),
        steps_(std::move(steps)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    record_moves(commands);
    steps_.cells.record(commands);
    if (has_records_) record_nodes(commands);
    steps_.light.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
    vk::full_barrier(commands);
    steps_.pixels.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  // Records of what tiles show, then their values, level by level: a level makes those of the next one.
  void record_nodes(VkCommandBuffer commands) {
    DisplayListsHead none{};
    for (std::uint32_t level = 0; level < FL_DISPLAY_RECORD_LEVELS; ++level) {
      none.groups[4 * level + 1] = none.groups[4 * level + 2] = 1;
    }
    vkCmdUpdateBuffer(commands, records_, 0, sizeof(none), &none);
    steps_.tiles.bind(commands);
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
    vk::full_barrier(commands);
    steps_.lists.bind(commands);
    vkCmdDispatch(commands, supertiles_x_, supertiles_y_, 1);
    vk::full_barrier(commands);
    for (std::uint32_t level = 0; level < FL_DISPLAY_RECORD_LEVELS; ++level) {
      steps_.nodes.bind(commands);
      steps_.nodes.pipeline->push(commands, std::as_bytes(std::span(&level, 1)));
      vkCmdDispatchIndirect(commands, records_, sizeof(std::uint32_t) * 4 * level);
      vk::full_barrier(commands);
    }
  }
  // The places of displays that move with heads.
  void record_moves(VkCommandBuffer commands) {
    for (const DisplayMove& move : rig_.display_moves) {
      steps_.poses.bind(commands);
      steps_.poses.pipeline->push(commands, std::as_bytes(std::span(&move, 1)));
      vkCmdDispatch(commands, 1, 1, 1);
    }
    if (!rig_.display_moves.empty()) vk::full_barrier(commands);
  }

  const RigTables& rig_;
  std::uint32_t supertiles_x_, supertiles_y_, tiles_x_, tiles_y_;
  bool has_records_;
  VkBuffer records_;
  Steps steps_;
};

}  // namespace

const PassEntry kDisplaysPass{
    "displays",
    has_displays,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return with_plumes(needs.plumes && has_displays_in_air(needs, settings),
                         {{FL_SPEC_EXTINCTION, needs.extinction},
                          {FL_SPEC_BOXES, needs.surfaces},
                          {FL_SPEC_BODIES, has_bodies(needs, settings)},
                          {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                          {FL_SPEC_AIR, has_displays_in_air(needs, settings)},
                          // Frames that are compared with the judge, which takes rays and no pixels, have whole images.
                          {FL_SPEC_DETAIL, settings.widen_thin},
                          {FL_SPEC_GLOSS, has_gloss(needs, settings)},
                          {FL_SPEC_TILES, has_display_records(needs, settings)},
                          {FL_SPEC_HAZE, has_displays_in_air(needs, settings) && has_haze_field(needs, settings)},
                          {FL_SPEC_VIEW, static_cast<std::uint32_t>(settings.view)}});
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool haze = has_constant(context, FL_SPEC_HAZE), records = has_constant(context, FL_SPEC_TILES);
      const auto begin = [&](vk::Spirv spirv) { return BoundPipeline::compute(context, spirv, context.constants); };
      FL_ASSIGN(DisplayCells cells, DisplayCells::create(context));
      DisplaysPass::Steps steps{.cells = std::move(cells)};
      if (!context.resources.rig.display_moves.empty()) {
        FL_ASSIGN(steps.poses, BoundPipeline::compute(context, kDisplayposesComp, {}));
      }
      if (records) {
        FL_ASSIGN(steps.tiles, begin(kDisplaytilesComp));
        FL_ASSIGN(steps.lists, begin(kDisplaylistsComp));
        FL_ASSIGN(steps.nodes, begin(haze ? vk::Spirv(kHazedisplaynodesComp) : vk::Spirv(kDisplaynodesComp)));
      }
      FL_ASSIGN(steps.light, begin(kDisplaysComp));
      FL_ASSIGN(steps.pixels, begin(haze ? vk::Spirv(kHazedisplaypixelsComp) : vk::Spirv(kDisplaypixelsComp)));
      return std::unique_ptr<Pass>(new DisplaysPass(context, std::move(steps), records));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kDisplayposesComp}, {kDisplaycellsComp},  {kDisplaytilesComp},
                                                 {kDisplaylistsComp}, {kDisplaynodesComp},  {kHazedisplaynodesComp},
                                                 {kDisplaysComp},     {kDisplaypixelsComp}, {kHazedisplaypixelsComp}};
    },
    "displays, and their light in the air and on surfaces"};

}  // namespace footlight::render
