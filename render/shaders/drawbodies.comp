#version 460
// Draws bodies, a workgroup for each FL_GROUP_TRIANGLES triangles of a body (place.comp), a thread a triangle. A pixel
// keeps the nearest depth, and of the triangles there the first one: the picture does not depend on the order of
// threads. FL_JOINED: in one round, with atomics of 64 bits; else a first round finds depths, a second triangles. The
// rasteriser itself takes 1 ns a triangle on an H200, where a thirtieth of the GPU serves it. FL_DRAWS_EDGES: draws the
// samples of pixels with an edge.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef FL_JOINED
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define FL_THREADS FL_GROUP_TRIANGLES
#define FL_TRIANGLES FL_GROUP_TRIANGLES
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"
#include "render/shaders/lib/triangles.glsl"
#include "render/shaders/lib/triangle_blocks.glsl"
#ifdef FL_DRAWS_EDGES
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/edge_surfaces.glsl"
#include "render/shaders/lib/triangle_samples.glsl"
#else
#include "render/shaders/lib/triangle_pixels.glsl"
#endif
#include "render/shaders/lib/triangle_groups.glsl"

layout(local_size_x = FL_THREADS) in;
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };

layout(set = 0, binding = FL_BINDING_BODY_ROUNDS, std430) readonly buffer RoundsBuffer {
  BodyRoundsHead rounds_head;
  BodyRoundRow rounds[];
};

void main() {
  uint number = gl_WorkGroupID.y * FL_ROUNDS_X + gl_WorkGroupID.x;
  if (number >= rounds_head.count) return;
  BodyRoundRow round_row = rounds[number];
  uint slot = round_row.slot;
  if (spaces[slot].last_px < float(first_row()) || spaces[slot].first_px > float(end_row())) return;
  uint choice = choices[slot];
  begin_space(slot);
  barrier();
  draw_triangles(levels[choice & FL_CHOICE_LEVEL], slot, slots[slot].head, slots[slot].triangle_first,
                 round_row.triangle, (choice & FL_CHOICE_WIDE) != 0u);
}
