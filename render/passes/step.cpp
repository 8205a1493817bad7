#include "render/passes/step.h"

#include <algorithm>

#include "fixtures/compile/tables.h"
#include "render/passes/compute_pass.h"
#include "shaders/step.comp.h"

namespace footlight::render {
namespace {

// The number of decoded parameters that the rig's tables and branches use. They are selected by number, so on a GPU
// they lie in memory: fewer are faster.
std::uint32_t decoded_count(const fixtures::Needs& needs) {
  std::uint32_t count = std::max(needs.params_end, fixtures::kParamBasicEnd);
#define FL_KIND_END(kind, before, values, NEED, need) \
  if (needs.need) count = std::max(count, fixtures::kParam##kind##End);
  FL_PARAM_KINDS(FL_KIND_END)
#undef FL_KIND_END
  return count;
}

#define FL_LAMP_CONSTANT(number, Kind, need, State, per_head) {FL_SPEC_LAMP(number), needs.need},

}  // namespace

const PassEntry kStepPass{
    "step",
    [](const fixtures::Needs& needs, const FrameSettings&) { return needs.fixtures; },
    [](const fixtures::Needs& needs, const FrameSettings&) {
      return std::vector<vk::SpecConstant>{
          {FL_SPEC_MOTION, needs.motion},         {FL_SPEC_SPIN, needs.spin},
          {FL_SPEC_STROBE, needs.strobe},         {FL_SPEC_COLOR, needs.color},
          {FL_SPEC_OPTICS, needs.optics},         {FL_SPEC_BLADES, needs.blades},
          {FL_SPEC_SHAKE, needs.shake},           {FL_SPEC_ANIMATION, needs.animation},
          {FL_SPEC_STACKED, needs.stacked},       {FL_SPEC_FLEX, needs.flex},
          {FL_SPEC_SMOOTH, needs.smooth},         FL_LAMPS(FL_LAMP_CONSTANT){FL_SPEC_DOWSER, needs.dowser},
          {FL_SPEC_PULSES, needs.pulses},         {FL_SPEC_MACRO, needs.macro},
          {FL_SPEC_LASER, needs.laser},           {FL_SPEC_DECODED_COUNT, decoded_count(needs)}};
    },
    [](const PassContext& context) {
      return make_compute_pass(context, kStepComp,
                               [groups = context.resources.rig.head_groups](VkCommandBuffer commands) {
                                 vkCmdDispatch(commands, groups, 1, 1);
                               });
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kStepComp}}; },
    "fixtures",
    nullptr,
    true};

#undef FL_LAMP_CONSTANT

}  // namespace footlight::render
