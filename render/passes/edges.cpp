#include "render/passes/edges.h"

#include "render/passes/compute_pass.h"
#include "shaders/blend.comp.h"
#include "shaders/edges.comp.h"

namespace footlight::render {
namespace {

// Finds and samples, then writes: a pixel's colour is made of those that its neighbours had before.
class EdgesPass final : public Pass {
 public:
  EdgesPass(std::unique_ptr<Pass> find, std::unique_ptr<Pass> blend)
      : find_(std::move(find)), blend_(std::move(blend)) {}
  void record(VkCommandBuffer commands, std::span<const std::byte> push) override {
    find_->record(commands, push);
    vk::full_barrier(commands);
    blend_->record(commands, push);
  }

 private:
  std::unique_ptr<Pass> find_, blend_;
};

}  // namespace

const PassEntry kEdgesPass{"edges",
                           has_smooth_edges,
                           [](const fixtures::Needs& needs, const FrameSettings& settings) {
                             return std::vector<vk::SpecConstant>{{FL_SPEC_BOXES, needs.surfaces},
                                                                  {FL_SPEC_BODIES, has_bodies(needs, settings)},
                                                                  {FL_SPEC_SHEEN, has_sheen(needs, settings)},
                                                                  {FL_SPEC_EDGE_SAMPLES, settings.edge_samples}};
                           },
                           [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                             const auto tiles = [x = tile_groups(context.settings.width),
                                                 y = tile_groups(context.settings.height)](VkCommandBuffer commands) {
                               vkCmdDispatch(commands, x, y, 1);
                             };
                             FL_ASSIGN(auto find, make_compute_pass(context, kEdgesComp, tiles));
                             PassContext plain = context;
                             plain.constants.clear();
                             FL_ASSIGN(auto blend, make_compute_pass(plain, kBlendComp, tiles));
                             return std::unique_ptr<Pass>(new EdgesPass(std::move(find), std::move(blend)));
                           },
                           [] {
                             return std::vector<std::vector<vk::Spirv>>{{kEdgesComp}, {kBlendComp}};
                           },
                           "smooth edges of solid things"};

}  // namespace footlight::render
