#version 460
// Draws bodies, a workgroup for each FL_ROUND_TRIANGLES triangles of a body, a thread a triangle. Of pixels a first pass
// finds the nearest depth, a second the first triangle at that depth: the picture does not depend on the order of
// threads. The rasteriser itself takes 1 ns a triangle on an H200, where a thirtieth of the GPU serves it.
// FL_DRAWS_EDGES: draws the samples of pixels with an edge.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"
#include "render/shaders/lib/triangles.glsl"
#ifdef FL_DRAWS_EDGES
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/edge_surfaces.glsl"
#include "render/shaders/lib/triangle_samples.glsl"
#else
#include "render/shaders/lib/triangle_pixels.glsl"
#endif
#include "render/shaders/lib/triangle_rounds.glsl"

layout(local_size_x = FL_GROUP_TRIANGLES) in;
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };

shared bool in_rows[4];  // for each number of joints: whether what they move may be in the rows that are drawn

bool may_be_in_rows(vec4 sphere, Placed at) {
  vec3 centre = at.origin + at.x_axis * sphere.x + at.y_axis * sphere.y + at.z_axis * sphere.z;
  float radius_m = sphere.w * stretch(at) * 1.001 + 1e-5 + 2e-6 * (length(centre) + length(params.position.xyz));
  float z = dot(centre, params.forward.xyz);
  if (!(z > 2.0 * radius_m)) return true;
  float up = length(params.up.xyz);
  float middle = dot(centre, params.up.xyz) / (up * up * z);  // -1 to 1 in the picture
  float reach = radius_m * (1.0 + abs(middle) * up) / (up * (z - radius_m));
  float at_px = (0.5 - 0.5 * middle) * float(params.height);
  float reach_px = 0.5 * reach * float(params.height) + 2.0;
  return at_px + reach_px >= float(rows.first) && at_px - reach_px <= float(rows.end);
}

void main() {
  uint slot = gl_WorkGroupID.y * FL_SLOTS_X + gl_WorkGroupID.x;
  if (slot >= uint(slots.length())) return;
  uint choice = choices[slot];
  if (choice == FL_CHOICE_NONE) return;
  BodyLevelRow level = levels[choice & FL_CHOICE_LEVEL];
  uint base = gl_WorkGroupID.z * FL_ROUND_TRIANGLES;
  if (base >= level.index_count / 3u) return;
  BodySlotRow body = slots[slot];
  uint thread = gl_LocalInvocationIndex;
  if (thread < 4u) {
    vec4 sphere = meshes[body.mesh].sphere[thread];
    in_rows[thread] = false;
    if (sphere.w >= 0.0) {  // so many joints move some vertex
      HeadRow row = heads[body.head];
      Placed at = place(row, types[row.type], states[body.head], thread);
      set_space(thread, at);
      in_rows[thread] = may_be_in_rows(sphere, at);
    }
  }
  barrier();
  if (!in_rows[0] && !in_rows[1] && !in_rows[2] && !in_rows[3]) return;
  draw_rounds(level, slot, body.head, body.triangle_first, base, (choice & FL_CHOICE_WIDE) != 0u);
}
