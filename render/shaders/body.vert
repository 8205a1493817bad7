#version 460
// Fixture bodies: one instance a head; each vertex is behind so many joints of the head's chain. FL_SHEEN: some have
// materials with sheen.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/project.glsl"

layout(set = 0, binding = FL_BINDING_BODY_DRAWN, std430) readonly buffer DrawnBuffer { uint drawn[]; };

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint part;  // FL_PART_...
layout(location = 0) out vec3 out_normal;
layout(location = 1) flat out uint out_id;
layout(location = 2) out vec3 out_offset_m;  // from the camera

void main() {
  uint index = drawn[gl_InstanceIndex];
  HeadRow row = heads[index];
  TypeRow type = types[row.type];
  HeadState state = states[index];
  uint depth = part & uint(FL_PART_DEPTH);
  out_normal = fixture_to_stage_direction(row, chain_to_fixture(type, state, depth, normal, 0.0));
  vec3 p = chain_to_fixture(type, state, depth, position_m, 1.0);
  out_offset_m = fixture_to_stage_point(row, p) - params.position.xyz;
  gl_Position = project(out_offset_m);
#ifdef FL_SHEEN
  uint sheen = part >> FL_PART_SHEEN_SHIFT;
  out_id = 1u + ((index << 3) | (part & 7u));
  if (sheen != 0u) out_id |= FL_BODY_SHEEN | sheen << FL_BODY_SHEEN_SHIFT;
#else
  out_id = 1u + ((index << 3) | part);
#endif
}
