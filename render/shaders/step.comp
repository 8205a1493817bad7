#version 460
// One thread a fixture: raw levels -> what is asked -> motors, shutter, phases after dt. Counts the lit ones of its
// group.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_FIXTURES) in;
layout(constant_id = FL_SPEC_MOTION) const bool kMotion = true;
layout(constant_id = FL_SPEC_STROBE) const bool kStrobe = true;
layout(push_constant) uniform Push { uint dt_ns_low; uint dt_ns_high; uint new_exposure; } push;

layout(set = 0, binding = FL_BINDING_LEVELS, std430) readonly buffer LevelsBuffer { uint levels[]; };
layout(set = 0, binding = FL_BINDING_TYPES, std430) readonly buffer TypesBuffer { TypeRow types[]; };
layout(set = 0, binding = FL_BINDING_CHANNELS, std430) readonly buffer ChannelsBuffer { ChannelRow channels[]; };
layout(set = 0, binding = FL_BINDING_FUNCTIONS, std430) readonly buffer FunctionsBuffer { FunctionRow functions[]; };
layout(set = 0, binding = FL_BINDING_FIXTURES, std430) readonly buffer FixturesBuffer { FixtureRow fixtures[]; };

uint fl_level(uint slot) { return (levels[slot >> 2] >> ((slot & 3u) * 8u)) & 255u; }
FunctionRow fl_function(uint index) { return functions[index]; }
ChannelRow fl_channel(uint index) { return channels[index]; }

#define FL_NEED_MOTION kMotion
#define FL_NEED_STROBE kStrobe
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/filter.h"
#include "sim/shared/shutter.h"
#include "fixtures/shared/state.h"
#include "fixtures/shared/decode.h"
#include "render/shaders/lib/lit.glsl"

layout(set = 0, binding = FL_BINDING_STATES, std430) buffer StatesBuffer { FixtureState states[]; };

shared uint live_here;

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (gl_LocalInvocationIndex == 0u) live_here = 0u;
  barrier();
  if (index < params.fixture_count) {
    FixtureRow row = fixtures[index];
    TypeRow type = types[row.type];
    FixtureState state =
        fixture_step(states[index], type, decode_fixture(type, row.slot_first), Turns(push.dt_ns_low, push.dt_ns_high),
                     push.new_exposure != 0u);
    states[index] = state;
    if (is_lit(state, type)) atomicAdd(live_here, 1u);
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) group_live[gl_WorkGroupID.x] = live_here;
}
