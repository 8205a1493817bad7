#version 460
// Compacts the lit heads into beam rows, in patch order: each group finds its place from the counts of those before
// it. The last group writes the totals and the indirect arguments of the passes that follow.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS writeonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(constant_id = FL_SPEC_GOBO) const bool kGobo = false;

#include "render/shaders/lib/lit.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"

shared uint live_before;
shared uint live_bits[2];

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint group = gl_WorkGroupID.x;
  uint index = gl_GlobalInvocationID.x;
  if (lane == 0u) live_before = 0u;
  if (lane < 2u) live_bits[lane] = 0u;
  barrier();
  uint sum = 0u;
  for (uint g = lane; g < group; g += uint(FL_GROUP_HEADS)) sum += group_live[g];
  if (sum > 0u) atomicAdd(live_before, sum);

  bool lit = false;
  if (index < params.head_count) lit = is_lit(states[index], types[heads[index].type]);
  if (lit) atomicOr(live_bits[lane >> 5], 1u << (lane & 31u));
  barrier();

  uint before_in_word = live_bits[lane >> 5] & ((1u << (lane & 31u)) - 1u);
  uint rank = uint(bitCount(before_in_word)) + (lane >= 32u ? uint(bitCount(live_bits[0])) : 0u);
  if (lit) {
    HeadRow row = heads[index];
    TypeRow type = types[row.type];
    HeadState state = states[index];
    BeamPose pose = beam_pose(row, type, state);
    float spread = tan(state.zoom);
    vec3 eye = params.position.xyz - pose.lens_m;
    float j0 = type.flux_lm / beam_flux_factor(spread, type.profile_m);

    BeamRow beam;
    beam.x_axis = vec4(pose.x_axis, type.lens_radius_m);
    beam.y_axis = vec4(pose.y_axis, spread);
    beam.axis = vec4(pose.axis, params.up.w);
    beam.eye = vec4(dot(pose.x_axis, eye), dot(pose.y_axis, eye), dot(pose.axis, eye), type.profile_m);
    beam.j0 = vec4(vec3(state.red, state.green, state.blue) * j0, 0.0);
    beam.gobo = kGobo ? state.gobo_image : 0u;
    beam.gobo_cos = kGobo ? cos(state.gobo_angle) : 1.0;
    beam.gobo_sin = kGobo ? sin(state.gobo_angle) : 0.0;
    beam.head = index;
    beams[live_before + rank] = beam;
  }

  if (lane == 0u && group == gl_NumWorkGroups.x - 1u) {
    uint live = live_before + bitCount(live_bits[0]) + bitCount(live_bits[1]);
    uint supertiles_y = (params.height + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
    counts.live_count = live;
    counts.dark_count = params.head_count - live;
    counts.tiles_groups[0] = (live + uint(FL_GROUP_MASK) - 1u) / uint(FL_GROUP_MASK);
    counts.tiles_groups[1] = params.supertiles_x * supertiles_y;
    counts.tiles_groups[2] = 1u;
    bool any = live > 0u;
    counts.beams_groups[0] = any ? (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
    counts.beams_groups[1] = any ? (params.height + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
    counts.beams_groups[2] = 1u;
  }
}
