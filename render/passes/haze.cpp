#include "render/passes/haze.h"

#include "render/passes/compute_pass.h"
#include "shaders/haze.comp.h"

namespace footlight::render {

const PassEntry kHazePass{"haze",
                          has_haze_field,
                          [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
                          [](const PassContext& context) {
                            return make_compute_pass(context, kHazeComp, [](VkCommandBuffer commands) {
                              constexpr std::uint32_t kRays = FL_HAZE_X * FL_HAZE_Y;
                              vkCmdDispatch(commands, groups_of(kRays, FL_GROUP_HAZE), 1, 1);
                            });
                          },
                          [] { return std::vector<std::vector<vk::Spirv>>{{kHazeComp}}; },
                          "clouds of haze that drift, and haze that thins with height"};

}  // namespace footlight::render
