#include "render/passes/gloss.h"

#include <utility>

#include "render/mirror.h"
#include "render/passes/compute_pass.h"
#include "shaders/eyes.comp.h"
#include "shaders/gloss.comp.h"
#include "shaders/mirrordown.comp.h"

namespace footlight::render {
namespace {

// The push constants of gloss.comp.
struct GlossPush {
  std::int32_t width;
  std::int32_t height;
  std::int32_t levels;
  std::uint32_t count;
};

class GlossPass final : public Pass {
 public:
  GlossPass(const PassContext& context, BoundPipeline step)
      : tiles_x_(tile_groups(context.settings.width)),
        tiles_y_(tile_groups(context.settings.height)),
        step_(std::move(step)) {
    const MirrorShape shape = mirror_shape(context.settings);
    push_ = {shape.levels.front().x, shape.levels.front().y, static_cast<std::int32_t>(shape.levels.size()),
             context.resources.rig.gloss_count};
  }

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    step_.bind(commands);
    step_.pipeline->push(commands, std::as_bytes(std::span(&push_, 1)));
    vkCmdDispatch(commands, tiles_x_, tiles_y_, 1);
  }

 private:
  std::uint32_t tiles_x_, tiles_y_;
  GlossPush push_{};
  BoundPipeline step_;
};

}  // namespace

const PassEntry kGlossPass{"gloss", has_gloss,
                           [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
                           [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                             FL_ASSIGN(auto step, BoundPipeline::compute(context, kGlossComp, {}));
                             return std::unique_ptr<Pass>(new GlossPass(context, std::move(step)));
                           },
                           // The first two are those of render/mirror.cpp.
                           [] {
                             return std::vector<std::vector<vk::Spirv>>{{kEyesComp}, {kMirrordownComp}, {kGlossComp}};
                           },
                           "what floors mirror"};

}  // namespace footlight::render
