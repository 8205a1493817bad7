// Bindings and small access functions that every pass may use. A pass declares what it needs with FL_USE_... first, so
// that nothing else is in its interface.
#include "sim/shared/real.h"
#include "fixtures/shared/tables.h"
#include "render/shaders/shared/frame_io.h"

// A uniform buffer: the same for all threads, which drivers then read once, without a loop over lanes or a register.
layout(set = 0, binding = FL_BINDING_PARAMS, std140) uniform ParamsBuffer { FrameParams params; };
// For a condition, or a number of rounds, that depends on `params` alone, in compute shaders. Mesa's lavapipe 22.3 puts
// such values into the code: it compiles the shader again for each dispatch, and keeps the code until the device ends.
// It does not do so with what it cannot compute from uniform buffers.
#define FL_NOT_IN_CODE(value) (gl_NumWorkGroups.x == 0u ? 0u : (value))

#ifdef FL_USE_HEADS
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/filter.h"
#include "sim/shared/shutter.h"
#include "fixtures/shared/state.h"
layout(set = 0, binding = FL_BINDING_TYPES, std430) readonly buffer TypesBuffer { TypeRow types[]; };
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_STATES, std430) FL_STATES_ACCESS buffer StatesBuffer { HeadState states[]; };
#endif
#ifdef FL_USE_POSE
layout(set = 0, binding = FL_BINDING_JOINTS, std430) readonly buffer JointsBuffer { JointRow joints[]; };
JointRow fl_joint(uint index) { return joints[index]; }
#include "fixtures/shared/pose.h"
#endif
#ifdef FL_USE_BEAMS
layout(set = 0, binding = FL_BINDING_BEAMS, std430) FL_BEAMS_ACCESS buffer BeamsBuffer { BeamRow beams[]; };
#endif
#ifdef FL_USE_COUNTS
layout(set = 0, binding = FL_BINDING_COUNTS, std430) FL_COUNTS_ACCESS buffer CountsBuffer {
  CountsRow counts;
  uint group_live[];  // of each workgroup of the step pass: its beams, then its lit heads
};
#endif
#ifdef FL_USE_MASKS
layout(set = 0, binding = FL_BINDING_MASKS, std430) FL_MASKS_ACCESS buffer MasksBuffer { uint masks[]; };
#endif
#ifdef FL_USE_FINE_MASKS
layout(set = 0, binding = FL_BINDING_FINE_MASKS, std430) FL_FINE_MASKS_ACCESS buffer FineMasksBuffer {
  uint fine_masks[];
};
#endif
#ifdef FL_USE_HAZE
#include "render/shaders/lib/haze.glsl"
#endif

// The ray through picture position p (pixels, (0, 0) at the top left corner), not normalised.
vec3 ray_through(vec2 p) {
  vec2 ndc = vec2(2.0 * p.x / float(params.width) - 1.0, 1.0 - 2.0 * p.y / float(params.height));
  return params.forward.xyz + params.right.xyz * ndc.x + params.up.xyz * ndc.y;
}
