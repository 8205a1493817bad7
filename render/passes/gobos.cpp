#include "render/passes/gobos.h"

#include <cstddef>
#include <optional>
#include <utility>

#include "render/passes/compute_pass.h"
#include "shaders/gateimages.comp.h"
#include "shaders/gates.comp.h"
#include "shaders/goboblurs.comp.h"
#include "shaders/gobochords.comp.h"
#include "shaders/gobolines.comp.h"
#include "shaders/gobos.comp.h"

namespace footlight::render {
namespace {

class GobosPass final : public Pass {
 public:
  GobosPass(BoundPipeline gates, BoundPipeline mark, BoundPipeline images, BoundPipeline whole, BoundPipeline lines,
            std::optional<BoundPipeline> blurs, const RigTables& rig, std::uint32_t builds)
      : gates_(std::move(gates)),
        mark_(std::move(mark)),
        images_(std::move(images)),
        whole_(std::move(whole)),
        lines_(std::move(lines)),
        blurs_(std::move(blurs)),
        rig_(rig),
        gate_builds_(builds) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    GoboQueue empty = rig_.gobo_queue_empty;
    empty.gate_builds = gate_builds_;
    const VkBuffer queue = rig_.gobo_queue.handle;
    vkCmdUpdateBuffer(commands, queue, 0, sizeof(empty), &empty);
    vk::full_barrier(commands);
    if (empty.gates > 0) {
      gates_.bind(commands);
      vkCmdDispatch(commands, 1, 1, 1);
      vk::full_barrier(commands);
    }
    mark_.bind(commands);
    vkCmdDispatch(commands, groups_of(rig_.beams_max, FL_GROUP_GOBOS), 1, 1);
    vk::full_barrier(commands);
    if (empty.gates > 0) {
      images_.bind(commands);
      vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, gate_groups));
      vk::full_barrier(commands);
    }
    whole_.bind(commands);
    vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, whole_groups));
    lines_.bind(commands);
    vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, lines_groups));
    if (!blurs_) return;
    blurs_->bind(commands);
    vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, blur_groups));
  }

 private:
  BoundPipeline gates_;
  BoundPipeline mark_;
  BoundPipeline images_;
  BoundPipeline whole_;
  BoundPipeline lines_;
  std::optional<BoundPipeline> blurs_;  // where a mode has a focus
  const RigTables& rig_;
  std::uint32_t gate_builds_;
};

}  // namespace

const PassEntry kGobosPass{
    "gobos",
    has_gobo_tables,
    [](const fixtures::Needs& needs, const FrameSettings&) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_FOCUS, needs.focus}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(BoundPipeline gates, BoundPipeline::compute(context, kGatesComp, context.constants));
      FL_ASSIGN(BoundPipeline mark, BoundPipeline::compute(context, kGobosComp, context.constants));
      FL_ASSIGN(BoundPipeline images, BoundPipeline::compute(context, kGateimagesComp, context.constants));
      FL_ASSIGN(BoundPipeline whole, BoundPipeline::compute(context, kGobochordsComp, context.constants));
      FL_ASSIGN(BoundPipeline lines, BoundPipeline::compute(context, kGobolinesComp, context.constants));
      std::optional<BoundPipeline> blurs;
      if (has_constant(context, FL_SPEC_FOCUS)) {
        FL_ASSIGN(blurs, BoundPipeline::compute(context, kGoboblursComp, context.constants));
      }
      return std::unique_ptr<Pass>(new GobosPass(std::move(gates), std::move(mark), std::move(images), std::move(whole),
                                                 std::move(lines), std::move(blurs), context.resources.rig,
                                                 context.settings.gate_builds));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kGatesComp},      {kGobosComp},     {kGateimagesComp},
                                                 {kGobochordsComp}, {kGobolinesComp}, {kGoboblursComp}};
    },
    "tables of gobos in the air, which are sampled instead",
    nullptr,
    true};

}  // namespace footlight::render
