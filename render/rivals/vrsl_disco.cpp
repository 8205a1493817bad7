#include "render/rivals/vrsl_disco.h"

#include <memory>
#include <span>
#include <utility>

#include "render/passes/compute_pass.h"
#include "render/passes/surfaces.h"
#include "render/rivals/rival_pass.h"
#include "shaders/vrsldisco.comp.h"
#include "shaders/vrslhide.comp.h"

namespace footlight::render {
namespace {

// For each ball its beams lose their light, and the picture gets that of its cube map.
class VrslDisco final : public Pass {
 public:
  VrslDisco(const PassContext& context, BoundPipeline hide, BoundPipeline light)
      : rig_(context.resources.rig),
        tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        hide_(std::move(hide)),
        light_(std::move(light)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    for (const DiscoBall& ball : rig_.disco_balls) {
      const auto push = std::as_bytes(std::span(&ball, 1));
      hide_.bind(commands);
      hide_.pipeline->push(commands, push);
      vkCmdDispatch(commands, 1, 1, 1);
      light_.bind(commands);
      light_.pipeline->push(commands, push);
      vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
      vk::full_barrier(commands);
    }
  }

 private:
  const RigTables& rig_;
  std::uint32_t tiles_x_, tiles_y_;
  BoundPipeline hide_, light_;
};

}  // namespace

const PassEntry kVrslDiscoPass{
    "VRSL's disco balls",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return needs.fixtures && kSurfacesPass.needed(needs, settings);
    },
    rival_constants,
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(BoundPipeline hide, BoundPipeline::compute(context, kVrslhideComp, context.constants));
      FL_ASSIGN(BoundPipeline light, BoundPipeline::compute(context, kVrsldiscoComp, context.constants));
      return std::make_unique<VrslDisco>(context, std::move(hide), std::move(light));
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kVrslhideComp}, {kVrsldiscoComp}}; },
    "light on surfaces"};

}  // namespace footlight::render
