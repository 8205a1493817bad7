#version 460
// Draws what stands in a gate as one image, a layer of one colour or of three. A thread has one texel.
#extension GL_GOOGLE_include_directive : require
#define FL_GATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/gobo_wheel.glsl"
#include "render/shaders/lib/gobo_queue.glsl"
#include "render/shaders/lib/gates.glsl"
#include "render/shaders/lib/gate_steps.glsl"

layout(local_size_x = FL_GROUP_GATE_PX, local_size_y = FL_GROUP_GATE_PX) in;
layout(set = 0, binding = FL_BINDING_GATE_IMAGES_OUT, r16f) uniform writeonly image2DArray gates_out;

void main() {
  uint layer = gobo_jobs[2u * gobo_queue.capacity + gl_WorkGroupID.z];
  GateRow gate = gates[layer];
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  vec2 p = (vec2(texel) + 0.5) * (2.0 / float(FL_GATE_PX)) - 1.0;
  vec3 through = gobo_wheel(gate.key[0] & 0xffffu, gate.key[0] >> 16, gate_offset(gate.key[4] >> 16),
                            gate_turn(gate.key[3]), p, 0.0);
  through *= gobo_wheel(gate.key[1] & 0xffffu, gate.key[1] >> 16, gate_offset(gate.key[5]),
                        gate_turn(gate.key[3] >> 16), p, 0.0);
  uint animation = gate.key[2] & 0xffffu;
  if (animation != 0u) through *= gobo_animation(animation, gate_turn(gate.key[4]), p, 0.0);
  for (uint plane = 0u; plane < gate.planes; ++plane) {
    imageStore(gates_out, ivec3(texel, layer * gobo_queue.gate_planes + plane), vec4(through[plane]));
  }
}
