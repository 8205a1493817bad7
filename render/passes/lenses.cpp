#include "render/passes/lenses.h"

#include "render/passes/compute_pass.h"
#include "render/passes/surfaces.h"
#include "shaders/lenses.comp.h"
#include "shaders/splats.comp.h"

namespace footlight::render {
namespace {

// Where the splats are, and then their light. Without any, the second dispatch has no group.
class LensesPass final : public Pass {
 public:
  LensesPass(const PassContext& context, BoundPipeline find, BoundPipeline add)
      : rows_(context.resources.rig.lenses.handle),
        heads_(context.resources.rig.head_count),
        rows_of_tiles_(groups_of(static_cast<std::uint32_t>(context.settings.height), FL_SPLAT_PX)),
        find_(std::move(find)),
        add_(std::move(add)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    const LensesHead none{{0, rows_of_tiles_, 1, 0}};
    vkCmdUpdateBuffer(commands, rows_, 0, sizeof(none), &none);
    vk::full_barrier(commands);
    find_.bind(commands);
    vkCmdDispatch(commands, groups_of(heads_, FL_GROUP_HEADS), 1, 1);
    vk::full_barrier(commands);
    add_.bind(commands);
    vkCmdDispatchIndirect(commands, rows_, 0);
  }

 private:
  VkBuffer rows_;
  std::uint32_t heads_;
  std::uint32_t rows_of_tiles_;
  BoundPipeline find_, add_;
};

}  // namespace

const PassEntry kLensesPass{"lenses", has_small_lenses,
                            // What a lens sends to the eye is what the surface pass shows of a larger one.
                            [](const fixtures::Needs& needs, const FrameSettings& settings) {
                              return kSurfacesPass.constants(needs, settings);
                            },
                            [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                              FL_ASSIGN(auto find, BoundPipeline::compute(context, kLensesComp, context.constants));
                              FL_ASSIGN(auto add, BoundPipeline::compute(context, kSplatsComp, context.constants));
                              return std::unique_ptr<Pass>(new LensesPass(context, std::move(find), std::move(add)));
                            },
                            [] {
                              return std::vector<std::vector<vk::Spirv>>{{kLensesComp}, {kSplatsComp}};
                            },
                            "the light of lenses of a few pixels"};

}  // namespace footlight::render
