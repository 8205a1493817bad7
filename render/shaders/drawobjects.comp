#version 460
// Draws the objects of the scene, a workgroup for each FL_OBJECT_TRIANGLES triangles. They are few and large, so a
// workgroup has more threads than triangles. FL_DRAWS_EDGES: as drawbodies.comp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef FL_JOINED
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#define FL_THREADS FL_GROUP_OBJECTS
#define FL_TRIANGLES FL_OBJECT_TRIANGLES
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

void main() {
  BodyLevelRow level = levels[params.object_level];
  uint base = (gl_WorkGroupID.y * FL_SLOTS_X + gl_WorkGroupID.x) * FL_OBJECT_TRIANGLES;
  if (base >= level.index_count / 3u) return;
  begin_space(FL_NONE);
  barrier();
  draw_triangles(level, FL_NONE, 0u, level.triangle_first, base, true);
}
