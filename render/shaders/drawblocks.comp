#version 460
// Draws the parts of large triangles, a workgroup for each block of pixels. FL_DRAWS_EDGES: as drawbodies.comp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef FL_JOINED
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define FL_THREADS FL_GROUP_TRIANGLES
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

layout(local_size_x = FL_THREADS) in;
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };

void main() {
  DrawBlockRow row = blocks[gl_WorkGroupID.x];
  bool is_object = row.slot == FL_NONE;
  BodyLevelRow level = levels[is_object ? params.object_level : choices[row.slot] & FL_CHOICE_LEVEL];
  uint head = 0u;
  uint first_number = level.triangle_first;
  if (!is_object) {
    head = slots[row.slot].head;
    first_number = slots[row.slot].triangle_first;
  }
  begin_space(row.slot);
  barrier();
  Triangle it = triangle_of(level, row.triangle);
  draw_block(it, first_number + row.triangle, ivec2(row.x, row.y), head);
}
