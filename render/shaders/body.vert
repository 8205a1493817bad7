#version 460
// Fixture bodies: one instance a fixture; base, yoke, head and lens are parts of one mesh, each in its own space.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/project.glsl"
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "fixtures/shared/state.h"
#include "fixtures/shared/pose.h"

layout(set = 0, binding = FL_BINDING_TYPES, std430) readonly buffer TypesBuffer { TypeRow types[]; };
layout(set = 0, binding = FL_BINDING_FIXTURES, std430) readonly buffer FixturesBuffer { FixtureRow fixtures[]; };
layout(set = 0, binding = FL_BINDING_STATES, std430) readonly buffer StatesBuffer { FixtureState states[]; };
layout(set = 0, binding = FL_BINDING_INSTANCES, std430) readonly buffer InstancesBuffer { uint instances[]; };

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint part;  // 0 base, 1 yoke, 2 head, 3 lens
layout(location = 0) out vec3 out_normal;
layout(location = 1) flat out uint out_id;

void main() {
  uint index = instances[gl_InstanceIndex];
  FixtureRow row = fixtures[index];
  TypeRow type = types[row.type];
  FixtureState state = states[index];
  vec3 p = position_m;
  vec3 n = normal;
  if (part >= 2u) {
    p = head_to_yoke(p, state.tilt.position) + vec3(0.0, 0.0, -type.pivot_drop_m);
    n = head_to_yoke(n, state.tilt.position);
  }
  if (part >= 1u) {
    p = yoke_to_fixture(p, state.pan.position);
    n = yoke_to_fixture(n, state.pan.position);
  }
  out_normal = fixture_to_stage_direction(row, n);
  gl_Position = project(fixture_to_stage_point(row, p) - params.position.xyz);
  out_id = 1u + ((index << 3) | part);
}
