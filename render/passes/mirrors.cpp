#include "render/passes/mirrors.h"

#include <utility>

#include "render/passes/compute_pass.h"
#include "shaders/mirrors.comp.h"

namespace footlight::render {
namespace {

class MirrorsPass final : public Pass {
 public:
  MirrorsPass(BoundPipeline find, BoundPipeline write, const RigTables& rig)
      : find_(std::move(find)), write_(std::move(write)), rig_(rig) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    find_.bind(commands);
    vkCmdDispatch(commands, rig_.mirror_pair_count, 1, 1);
    vk::full_barrier(commands);
    write_.bind(commands);
    vkCmdDispatch(commands, rig_.mirror_pair_count, 1, 1);
  }

 private:
  BoundPipeline find_;
  BoundPipeline write_;
  const RigTables& rig_;
};

}  // namespace

const PassEntry kMirrorsPass{
    "mirrors",
    [](const fixtures::Needs& needs, const FrameSettings&) { return needs.fixtures && needs.mirrors; },
    [](const fixtures::Needs& needs, const FrameSettings&) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_GOBO, needs.gobo},          {FL_SPEC_PROFILE, needs.profile},
                                           {FL_SPEC_WIDE, needs.wide},          {FL_SPEC_IRIS, needs.iris},
                                           {FL_SPEC_FOCUS, needs.focus},        {FL_SPEC_BLADES, needs.blades},
                                           {FL_SPEC_MEASURED, needs.measured},  {FL_SPEC_RECTANGLE, needs.rectangle},
                                           {FL_SPEC_ANIMATION, needs.animation}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      std::vector<vk::SpecConstant> writes = context.constants;
      writes.push_back({FL_SPEC_WRITE, 1});
      FL_ASSIGN(BoundPipeline find, BoundPipeline::compute(context, kMirrorsComp, context.constants));
      FL_ASSIGN(BoundPipeline write, BoundPipeline::compute(context, kMirrorsComp, writes));
      return std::unique_ptr<Pass>(new MirrorsPass(std::move(find), std::move(write), context.resources.rig));
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kMirrorsComp}}; },
    "spots of mirror balls",
    nullptr,
    true};

}  // namespace footlight::render
