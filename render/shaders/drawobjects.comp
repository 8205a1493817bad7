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
layout(set = 0, binding = FL_BINDING_OBJECT_SHELLS, std430) readonly buffer ShellsBuffer { ObjectShellsRow shells[]; };

// Whether the camera is certainly outside the shells of a workgroup's triangles. Places in float, m, are off by 1e-6 of
// their distance from the stage's origin.
bool is_outside_shells(ObjectShellsRow row) {
  vec3 eye = params.position.xyz;
  float margin_m = near_reach_m() + 1e-5 + 2e-6 * length(eye);
  return any(lessThan(eye, row.low.xyz - margin_m)) || any(greaterThan(eye, row.high.xyz + margin_m));
}

void main() {
  BodyLevelRow level = levels[params.object_level];
  uint base = (gl_WorkGroupID.y * FL_SLOTS_X + gl_WorkGroupID.x) * FL_OBJECT_TRIANGLES;
  if (base >= level.index_count / 3u) return;
  begin_space(FL_NONE);
  if (gl_LocalInvocationIndex == 0u && base < level.closed_count &&
      is_outside_shells(shells[base / FL_OBJECT_TRIANGLES])) {
    away = away_in(space_of(stage_space()));
  }
  barrier();
  draw_triangles(level, FL_NONE, 0u, level.triangle_first, base, true);
}
