#version 460
// Where a display is that moves with a head: behind a joint of it, as the head's bodies are. The light of one that has
// that of a head.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = FL_BINDING_DISPLAYS, std430) buffer DisplaysBuffer { DisplayRow displays[]; };
// DisplayMove in render/display_tables.h.
layout(push_constant) uniform Push {
  float middle_x, middle_y, middle_z;  // m, in the space behind the joint
  float right_x, right_y, right_z;
  float up_x, up_y, up_z;
  uint display;
  uint head;
  uint depth;
  float light_r, light_g, light_b;  // cd/m^2 where the head's light is 1
  uint lit;
} move;

vec3 to_stage(vec3 v, float is_point) {
  HeadRow row = heads[move.head];
  vec3 in_fixture = chain_to_fixture(types[row.type], states[move.head], move.depth, v, is_point);
  return is_point > 0.0 ? fixture_to_stage_point(row, in_fixture) : fixture_to_stage_direction(row, in_fixture);
}

void main() {
  if (move.lit != 0u) {
    HeadState state = states[move.head];
    displays[move.display].light.rgb = vec3(move.light_r, move.light_g, move.light_b) *
                                       vec3(state.red, state.green, state.blue);
  }
  if (move.depth == 0u) return;
  vec3 up = normalize(to_stage(vec3(move.up_x, move.up_y, move.up_z), 0.0));
  vec3 right = to_stage(vec3(move.right_x, move.right_y, move.right_z), 0.0);
  right = normalize(right - up * dot(right, up));
  displays[move.display].center.xyz = to_stage(vec3(move.middle_x, move.middle_y, move.middle_z), 1.0);
  displays[move.display].right.xyz = right;
  displays[move.display].down.xyz = -up;
  displays[move.display].front.xyz = cross(right, up);
}
