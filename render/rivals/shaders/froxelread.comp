#version 460
// Froxels, last pass: each pixel adds what the volume has in front of its surface, read with trilinear weights.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/rivals/shaders/lib/froxel.glsl"

layout(local_size_x = FL_GROUP_FROXELS, local_size_y = FL_GROUP_FROXELS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

// What a column has seen at a place in slices; 0 at the beginning of the first.
vec3 column_light(ivec2 column, float slice) {
  uvec2 at = uvec2(clamp(column, ivec2(0), ivec2(kAcross, kDown) - 1));
  int below = int(floor(slice));
  vec3 before = below > 0 ? froxels[froxel_at(at, uint(min(below, int(kSlices)) - 1))].rgb : vec3(0.0);
  if (below >= int(kSlices)) return before;
  return mix(before, froxels[froxel_at(at, uint(below))].rgb, slice - float(below));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec4 behind = imageLoad(radiance, pixel);
  float depth_m = behind.a / length(ray_through(vec2(pixel) + 0.5));
  float slice = clamp(froxel_slice(max(depth_m, bounds.low.w)), 0.0, float(kSlices));
  vec2 place = (vec2(pixel) + 0.5) / vec2(params.width, params.height) * vec2(kAcross, kDown) - 0.5;
  ivec2 corner = ivec2(floor(place));
  vec2 share = place - vec2(corner);
  vec3 light = mix(mix(column_light(corner, slice), column_light(corner + ivec2(1, 0), slice), share.x),
                   mix(column_light(corner + ivec2(0, 1), slice), column_light(corner + ivec2(1, 1), slice), share.x),
                   share.y);
  imageStore(radiance, pixel, vec4(behind.rgb + params.forward.w * light, behind.a));
}
