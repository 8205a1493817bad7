#include "render/passes/haze.h"

#include "render/passes/compute_pass.h"
#include "shaders/haze.comp.h"
#include "shaders/hazeplumes.comp.h"
#include "shaders/plumeveil.comp.h"

namespace footlight::render {
namespace {

// The table; with plumes what is seen through them gets darker, too.
class HazePass final : public Pass {
 public:
  HazePass(const FrameSettings& settings, BoundPipeline table, BoundPipeline veil)
      : width_(settings.width), height_(settings.height), table_(std::move(table)), veil_(std::move(veil)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> /*push*/) override {
    constexpr std::uint32_t kRays = FL_HAZE_X * FL_HAZE_Y;
    table_.bind(commands);
    vkCmdDispatch(commands, groups_of(kRays, FL_GROUP_HAZE), 1, 1);
    if (!veil_.pipeline) return;
    veil_.bind(commands);
    vkCmdDispatch(commands, tile_groups(width_), tile_groups(height_), 1);
  }

 private:
  int width_;
  int height_;
  BoundPipeline table_, veil_;
};

}  // namespace

const PassEntry kHazePass{
    "haze",
    has_haze_field,
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      std::vector<vk::SpecConstant> constants;
      if (needs.plumes) constants.push_back({FL_SPEC_PLUMES, 1});
      if (needs.plumes && has_gloss(needs, settings)) constants.push_back({FL_SPEC_GLOSS, 1});
      return constants;
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool plumes = has_constant(context, FL_SPEC_PLUMES);
      const vk::Spirv spirv = plumes ? vk::Spirv(kHazeplumesComp) : vk::Spirv(kHazeComp);
      FL_ASSIGN(auto table, BoundPipeline::compute(context, spirv, context.constants));
      BoundPipeline veil;
      if (plumes) {
        FL_ASSIGN(veil, BoundPipeline::compute(context, kPlumeveilComp, context.constants));
      }
      return std::unique_ptr<Pass>(new HazePass(context.settings, std::move(table), std::move(veil)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kHazeComp}, {kHazeplumesComp}, {kPlumeveilComp}};
    },
    "clouds of haze that drift, plumes of machines, and haze that thins with height"};

}  // namespace footlight::render
