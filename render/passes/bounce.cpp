#include "render/passes/bounce.h"

#include <cstddef>
#include <utility>

#include "render/bounce_tables.h"
#include "render/passes/compute_pass.h"
#include "shaders/bounceforms.comp.h"
#include "shaders/bouncelight.comp.h"
#include "shaders/bouncerays.comp.h"

namespace footlight::render {
namespace {

// Push constants of bounceforms.comp and bouncelight.comp.
struct BouncePush {
  std::uint32_t patches;
  std::uint32_t probes;
  std::uint32_t patch_row;  // bounce_row()
  std::uint32_t probe_row;
  std::uint32_t step;  // FL_BOUNCE_...
  std::uint32_t from;  // the list of light that is read: 0 or 1
};

// So often patches reflect light to each other. In a closed room whose walls have an albedo of 0.5, 0.4 % of the
// reflected light is missing after 8 times.
constexpr std::uint32_t kTimes = 8;

class BouncePass final : public Pass {
 public:
  BouncePass(BoundPipeline forms, BoundPipeline rays, BoundPipeline light, RigTables& rig)
      : forms_(std::move(forms)), rays_(std::move(rays)), light_(std::move(light)), rig_(rig) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    const std::uint32_t patches = rig_.bounce_patches;
    if (patches == 0) {
      vkCmdFillBuffer(commands, rig_.bounce_light.handle, 0, VK_WHOLE_SIZE, 0);
      return;
    }
    if (!rig_.has_bounce_forms) {
      forms_.bind(commands);
      for (const std::uint32_t step : {FL_BOUNCE_TO_PATCHES, FL_BOUNCE_TO_PROBES}) {
        push(commands, forms_, step, 0);
        const std::uint32_t receivers = step == FL_BOUNCE_TO_PATCHES ? patches : rig_.bounce_probes;
        vkCmdDispatch(commands, groups_of(receivers, FL_GROUP_FORMS), patches, 1);
      }
      rig_.has_bounce_forms = true;
    }
    vkCmdFillBuffer(commands, rig_.bounce_flux.handle, 0, VK_WHOLE_SIZE, 0);
    vk::full_barrier(commands);
    rays_.bind(commands);
    vkCmdDispatchIndirect(commands, rig_.counts.handle, offsetof(CountsRow, shadow_groups));
    vk::full_barrier(commands);
    light_.bind(commands);
    step(commands, FL_BOUNCE_DIRECT, 0, patches);
    for (std::uint32_t time = 0; time < kTimes; ++time) {
      step(commands, FL_BOUNCE_TO_PATCHES, time % 2, patches);
    }
    step(commands, FL_BOUNCE_TO_PROBES, kTimes % 2, 6 * rig_.bounce_probes);
  }

 private:
  void push(VkCommandBuffer commands, const BoundPipeline& shader, std::uint32_t step, std::uint32_t from) const {
    const BouncePush push{rig_.bounce_patches,
                          rig_.bounce_probes,
                          bounce_row(rig_.bounce_patches),
                          bounce_row(6 * rig_.bounce_probes),
                          step,
                          from};
    shader.pipeline->push(commands, std::as_bytes(std::span(&push, 1)));
  }
  void step(VkCommandBuffer commands, std::uint32_t step, std::uint32_t from, std::uint32_t receivers) const {
    push(commands, light_, step, from);
    vkCmdDispatch(commands, groups_of(receivers, 4 * FL_GROUP_BOUNCE), 1, 1);
    vk::full_barrier(commands);
  }

  BoundPipeline forms_, rays_, light_;
  RigTables& rig_;
};

}  // namespace

const PassEntry kBouncePass{
    "bounce",
    has_bounce,
    [](const fixtures::Needs& needs, const FrameSettings&) { return beam_light_constants(needs); },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(BoundPipeline forms, BoundPipeline::compute(context, kBounceformsComp, {}));
      FL_ASSIGN(BoundPipeline rays, BoundPipeline::compute(context, kBounceraysComp, context.constants));
      FL_ASSIGN(BoundPipeline light, BoundPipeline::compute(context, kBouncelightComp, {}));
      return std::unique_ptr<Pass>(
          new BouncePass(std::move(forms), std::move(rays), std::move(light), context.resources.rig));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kBounceformsComp}, {kBounceraysComp}, {kBouncelightComp}};
    },
    "light that boxes and scenery reflect to others",
    nullptr,
    true};

}  // namespace footlight::render
