#include "render/passes/gobos.h"

#include <cstddef>
#include <utility>

#include "shaders/gateimages.comp.h"
#include "shaders/gates.comp.h"
#include "shaders/gobochords.comp.h"
#include "shaders/gobolines.comp.h"
#include "shaders/gobos.comp.h"

namespace footlight::render {
namespace {

struct Step {
  std::shared_ptr<const vk::Pipeline> pipeline;
  vk::BindingSet set;

  static Result<Step> create(const PassContext& context, vk::Spirv spirv) {
    Step step;
    FL_ASSIGN(step.pipeline, context.device.pipelines().compute(spirv, context.constants));
    FL_ASSIGN(step.set, vk::BindingSet::create(context.device, *step.pipeline, context.resources.bindings));
    return step;
  }
};

class GobosPass final : public Pass {
 public:
  GobosPass(Step gates, Step mark, Step images, Step whole, Step lines, const RigTables& rig, std::uint32_t builds)
      : gates_(std::move(gates)),
        mark_(std::move(mark)),
        images_(std::move(images)),
        whole_(std::move(whole)),
        lines_(std::move(lines)),
        rig_(rig),
        gate_builds_(builds) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    GoboQueue empty = rig_.gobo_queue_empty;
    empty.gate_builds = gate_builds_;
    const VkBuffer queue = rig_.gobo_queue.handle;
    vkCmdUpdateBuffer(commands, queue, 0, sizeof(empty), &empty);
    vk::full_barrier(commands);
    if (empty.gates > 0) {
      gates_.pipeline->bind(commands, gates_.set);
      vkCmdDispatch(commands, 1, 1, 1);
      vk::full_barrier(commands);
    }
    mark_.pipeline->bind(commands, mark_.set);
    vkCmdDispatch(commands, (rig_.beams_max + FL_GROUP_GOBOS - 1) / FL_GROUP_GOBOS, 1, 1);
    vk::full_barrier(commands);
    if (empty.gates > 0) {
      images_.pipeline->bind(commands, images_.set);
      vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, gate_groups));
      vk::full_barrier(commands);
    }
    whole_.pipeline->bind(commands, whole_.set);
    vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, whole_groups));
    lines_.pipeline->bind(commands, lines_.set);
    vkCmdDispatchIndirect(commands, queue, offsetof(GoboQueue, lines_groups));
  }

 private:
  Step gates_;
  Step mark_;
  Step images_;
  Step whole_;
  Step lines_;
  const RigTables& rig_;
  std::uint32_t gate_builds_;
};

}  // namespace

const PassEntry kGobosPass{"gobos",
                           has_gobo_tables,
                           [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
                           [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                             FL_ASSIGN(Step gates, Step::create(context, kGatesComp));
                             FL_ASSIGN(Step mark, Step::create(context, kGobosComp));
                             FL_ASSIGN(Step images, Step::create(context, kGateimagesComp));
                             FL_ASSIGN(Step whole, Step::create(context, kGobochordsComp));
                             FL_ASSIGN(Step lines, Step::create(context, kGobolinesComp));
                             return std::unique_ptr<Pass>(
                                 new GobosPass(std::move(gates), std::move(mark), std::move(images), std::move(whole),
                                               std::move(lines), context.resources.rig, context.settings.gate_builds));
                           },
                           [] {
                             return std::vector<std::vector<vk::Spirv>>{
                                 {kGatesComp}, {kGobosComp}, {kGateimagesComp}, {kGobochordsComp}, {kGobolinesComp}};
                           },
                           "tables of gobos in the air, which are sampled instead"};

}  // namespace footlight::render
