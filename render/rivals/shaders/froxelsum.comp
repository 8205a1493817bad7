#version 460
// Froxels, second pass: front to back, what the eye sees of a column up to the end of each slice. Light is constant in
// a slice; extinction is integrated over it (Hillaire 2015).
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/rivals/shaders/lib/froxel.glsl"

layout(local_size_x = FL_GROUP_FROXELS, local_size_y = FL_GROUP_FROXELS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

void main() {
  uvec2 column = gl_GlobalInvocationID.xy;
  if (column.x >= kAcross || column.y >= kDown) return;
  float per_depth = length(ray_through(froxel_pixel(column)));
  vec3 seen = vec3(0.0);
  float from_m = froxel_depth_m(0.0) * per_depth;
  for (uint slice = 0u; slice < kSlices; ++slice) {
    float to_m = froxel_depth_m(float(slice + 1u)) * per_depth;
    float through_m = to_m - from_m;
    if (kExtinction) {
      float loss = params.position.w * through_m;
      // (1 - exp(-x)) / x without cancellation.
      float share = loss > 1e-2 ? (1.0 - exp(-loss)) / loss : 1.0 - loss * (0.5 - loss / 6.0);
      through_m *= exp(-params.position.w * from_m) * share;
    }
    uint at = froxel_at(column, slice);
    seen += froxels[at].rgb * through_m;
    froxels[at] = vec4(seen, 0.0);
    from_m = to_m;
  }
}
