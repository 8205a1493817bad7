#include "render/passes/glare.h"

#include "render/glare.h"
#include "render/passes/compute_pass.h"
#include "shaders/glaredown.comp.h"
#include "shaders/glareup.comp.h"

namespace footlight::render {
namespace {

// The push constants of both shaders (render/shaders/lib/glare.glsl).
struct GlarePush {
  GlareLevel fine;
  GlareLevel coarse;
  std::int32_t level;
  std::uint32_t is_last;
  float share;
};
static_assert(sizeof(GlarePush) == 44);

// Pixels a side of a workgroup: down of the coarse level, up of the fine one, of which a thread has 2 x 2.
constexpr int kDownPx = FL_GROUP_GLARE_DOWN;
constexpr int kUpPx = 2 * FL_GROUP_GLARE;
static_assert(kDownPx == kUpPx);

std::uint32_t glare_groups(int size_px) {
  return static_cast<std::uint32_t>((size_px + 2 * FL_GLARE_MARGIN + kUpPx - 1) / kUpPx);
}

// Down the pyramid, then up again: each level becomes its own share of the scattered light and that of all above it.
class GlarePass final : public Pass {
 public:
  GlarePass(GlareShape shape, double share, BoundPipeline first, BoundPipeline down, BoundPipeline up)
      : shape_(std::move(shape)),
        share_(static_cast<float>(share)),
        first_(std::move(first)),
        down_(std::move(down)),
        up_(std::move(up)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    const std::size_t last = shape_.levels.size() - 1;
    first_.bind(commands);
    step(commands, first_, 1, shape_.levels[1]);
    down_.bind(commands);
    for (std::size_t level = 2; level <= last; ++level) {
      step(commands, down_, level, shape_.levels[level]);
    }
    up_.bind(commands);
    for (std::size_t level = last; level >= 2; --level) {
      step(commands, up_, level, shape_.levels[level - 1]);
    }
  }

 private:
  // Between a level and the one before it; `written` is one of them.
  void step(VkCommandBuffer commands, const BoundPipeline& shader, std::size_t level, const GlareLevel& written) const {
    const GlarePush push{shape_.levels[level - 1], shape_.levels[level], static_cast<std::int32_t>(level),
                         level + 1 == shape_.levels.size(), share_};
    shader.pipeline->push(commands, std::as_bytes(std::span(&push, 1)));
    vkCmdDispatch(commands, glare_groups(written.width), glare_groups(written.height), 1);
    vk::full_barrier(commands);
  }

  GlareShape shape_;
  float share_;
  BoundPipeline first_, down_, up_;
};

}  // namespace

const PassEntry kGlarePass{
    "glare",
    has_glare,
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(auto first, BoundPipeline::compute(context, kGlaredownComp, {{FL_SPEC_GLARE_FIRST, 1}}));
      FL_ASSIGN(auto down, BoundPipeline::compute(context, kGlaredownComp, {{FL_SPEC_GLARE_FIRST, 0}}));
      FL_ASSIGN(auto up, BoundPipeline::compute(context, kGlareupComp, {}));
      return std::unique_ptr<Pass>(new GlarePass(glare_shape(context.settings), context.settings.glare,
                                                 std::move(first), std::move(down), std::move(up)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kGlaredownComp}, {kGlareupComp}};
    },
    "light that the camera's lens scatters"};

}  // namespace footlight::render
