#include "render/passes/probes.h"

#include <algorithm>
#include <utility>

#include "render/passes/compute_pass.h"
#include "render/passes/display_cells.h"
#include "shaders/displaycells.comp.h"
#include "shaders/probelevels.comp.h"
#include "shaders/probelight.comp.h"

namespace footlight::render {
namespace {

// Push constants of probelight.comp.
struct ProbePush {
  std::uint32_t first;  // in the order of texels
  std::uint32_t count;
};

class ProbesPass final : public Pass {
 public:
  ProbesPass(BoundPipeline light, BoundPipeline levels, DisplayCells cells, RigTables& rig,
             std::uint32_t texels)
      : light_(std::move(light)), levels_(std::move(levels)), cells_(std::move(cells)), rig_(rig), texels_(texels) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    if (rig_.probe_count == 0) return;
    cells_.record(commands);
    ProbePush push{rig_.probe_next, texels_};
    if (!rig_.has_probe_light || texels_ == FL_PROBE_TEXELS) push = {0, FL_PROBE_TEXELS};
    rig_.has_probe_light = true;
    rig_.probe_next = (push.first + push.count) % FL_PROBE_TEXELS;
    light_.bind(commands);
    light_.pipeline->push(commands, std::as_bytes(std::span(&push, 1)));
    vkCmdDispatch(commands, groups_of(push.count, FL_GROUP_PROBES), rig_.probe_count, 1);
    vk::full_barrier(commands);
    levels_.bind(commands);
    vkCmdDispatch(commands, groups_of(FL_PROBE_ALL - FL_PROBE_TEXELS, FL_GROUP_PROBES), rig_.probe_count, 1);
  }

 private:
  BoundPipeline light_, levels_;
  DisplayCells cells_;  // nothing to do without displays
  RigTables& rig_;
  std::uint32_t texels_;
};

}  // namespace

const PassEntry kProbesPass{
    "probes",
    has_probes,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      std::vector<vk::SpecConstant> constants = beam_light_constants(needs);
      constants.insert(constants.end(), {{FL_SPEC_SHADOWS, has_shadows(needs, settings)},
                                         {FL_SPEC_MAP_PX, shadow_map_px(needs, settings)},
                                         {FL_SPEC_PENUMBRA, lens_points(needs, settings)},
                                         {FL_SPEC_AIR, has_air(needs, settings)}});
      return constants;
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(BoundPipeline light, BoundPipeline::compute(context, kProbelightComp, context.constants));
      FL_ASSIGN(BoundPipeline levels, BoundPipeline::compute(context, kProbelevelsComp, {}));
      FL_ASSIGN(DisplayCells cells, DisplayCells::create(context));
      return std::unique_ptr<Pass>(new ProbesPass(std::move(light), std::move(levels), std::move(cells),
                                                  context.resources.rig, context.settings.probe_texels));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kProbelightComp}, {kProbelevelsComp}, {kDisplaycellsComp}};
    },
    "what shiny floors, trusses and metals mirror",
    nullptr,
    true};

}  // namespace footlight::render
