#version 460
// Boxes that hide light in place of the bodies of fixtures: one around what each number of joints moves.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(set = 0, binding = FL_BINDING_BODY_BOXES, std430) readonly buffer BodyBoxesBuffer { BodyBoxRow body_boxes[]; };
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) writeonly buffer OccludersBuffer { OccluderRow occluders[]; };

void main() {
  uint number = gl_GlobalInvocationID.x;
  uint slot = number / uint(FL_BODY_BOXES);
  uint depth = number % uint(FL_BODY_BOXES);
  uint body_count = uint(slots.length());
  if (slot >= body_count) return;
  BodySlotRow body = slots[slot];
  BodyBoxRow box = body_boxes[body.mesh * uint(FL_BODY_BOXES) + depth];
  HeadRow row = heads[body.head];
  TypeRow type = types[row.type];
  HeadState state = states[body.head];
  uint joints = min(depth, type.joint_count);
  OccluderRow occluder;
  vec3 center = fixture_to_stage_point(row, chain_to_fixture(type, state, joints, box.center.xyz, 1.0));
  vec3 half_edge[3];
  [[unroll]] for (int i = 0; i < 3; ++i) {
    vec3 v = vec3(0.0);
    v[i] = box.half_size[i];
    half_edge[i] = fixture_to_stage_direction(row, chain_to_fixture(type, state, joints, v, 0.0));
  }
  occluder.center_x = center.x;
  occluder.center_y = center.y;
  occluder.center_z = center.z;
  occluder.fixture = row.fixture;
  // A corner is no farther from the centre than the sum of the half edges.
  float radius_m = length(half_edge[0]) + length(half_edge[1]) + length(half_edge[2]);
  occluder.half_edge_0 = vec4(half_edge[0], box.center.w < 0.0 ? -1.0 : radius_m);
  occluder.half_edge_1 = vec4(half_edge[1], 0.0);
  occluder.half_edge_2 = vec4(half_edge[2], 0.0);
  uint first = uint(occluders.length()) - body_count * uint(FL_BODY_BOXES);
  occluders[first + body.occluder * uint(FL_BODY_BOXES) + depth] = occluder;
}
