#include "render/rivals/froxels.h"

#include <algorithm>
#include <utility>

#include "render/rivals/rival_pass.h"
#include "shaders/bounds.comp.h"
#include "shaders/froxelfill.comp.h"
#include "shaders/froxelread.comp.h"
#include "shaders/froxelsum.comp.h"

namespace footlight::render {
namespace {

constexpr std::uint64_t kFroxelBytes = 16;

template <std::uint32_t kSamples>
Result<std::unique_ptr<Pass>> create_froxels(const PassContext& context) {
  // 160 x 90 x 64 and multiples.
  const std::uint32_t across = context.settings.nodes;
  const std::uint32_t down = std::max(across * 9 / 16, 1u);
  const std::uint32_t slices = std::max(across * 2 / 5, 1u);
  const auto width = static_cast<std::uint32_t>(context.settings.width);
  const auto height = static_cast<std::uint32_t>(context.settings.height);
  auto pass = std::make_unique<RivalPass>(context, std::vector<vk::SpecConstant>{{FL_SPEC_FROXELS_X, across},
                                                                                 {FL_SPEC_FROXELS_Y, down},
                                                                                 {FL_SPEC_FROXELS_Z, slices},
                                                                                 {FL_SPEC_FROXEL_SAMPLES, kSamples}});
  const auto dispatch = [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return [=](VkCommandBuffer commands) {
      vkCmdDispatch(commands, groups_of(x, FL_GROUP_FROXELS), groups_of(y, FL_GROUP_FROXELS), z);
    };
  };
  FL_TRY(pass->add_bounds());
  FL_TRY(pass->add_buffer(FL_BINDING_FROXELS, kFroxelBytes * across * down * slices));
  FL_TRY(pass->add_compute(kFroxelfillComp, dispatch(across, down, slices)));
  FL_TRY(pass->add_compute(kFroxelsumComp, dispatch(across, down, 1)));
  FL_TRY(pass->add_compute(kFroxelreadComp, dispatch(width, height, 1)));
  return pass;
}

template <std::uint32_t kSamples>
PassEntry froxels_entry() {
  return {"froxels",
          has_air,
          rival_constants,
          create_froxels<kSamples>,
          [] {
            return std::vector<std::vector<vk::Spirv>>{
                {kBoundsComp}, {kFroxelfillComp}, {kFroxelsumComp}, {kFroxelreadComp}};
          },
          "light in the haze"};
}

Rival froxels_rival(const char* method, std::vector<double> knobs, std::vector<double> quick_knobs,
                    PassList (*passes)()) {
  return {
      method, std::move(knobs), std::move(quick_knobs), "Wronski, SIGGRAPH 2014; Hillaire, SIGGRAPH 2015", false, true,
      false,  passes,           rival_settings};
}

}  // namespace

const PassEntry kFroxelsPass = froxels_entry<1>();
const PassEntry kFroxelsSampledPass = froxels_entry<8>();

const Rival kFroxels =
    froxels_rival("froxels", {80, 160, 320}, {160, 320}, [] { return passes_with_air({&kFroxelsPass}); });
const Rival kFroxelsSampled =
    froxels_rival("froxels, 8 samples", {80, 160}, {160}, [] { return passes_with_air({&kFroxelsSampledPass}); });

}  // namespace footlight::render
