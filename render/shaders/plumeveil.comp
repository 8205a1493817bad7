#version 460
// What is seen through plumes of haze gets darker. Before light in the air is added: the radiance is that of surfaces.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HAZE
#define FL_HAZE_NO_TABLE
#define FL_HAZE_WRITE
#define FL_HAZE_PLUMES
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/mirror.glsl"
#include "render/shaders/lib/plume.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= params.width || pixel.y >= params.height) return;
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  if (behind.r + behind.g + behind.b == 0.0) return;
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  float begin_m = ray_begin(ray);
  if (begin_m >= behind.a) return;
  float sum = 0.0;
  for (uint i = 0u; i < min(haze_plumes.count, uint(FL_PUFFS_MAX)); ++i) {
    PuffChord chord = puff_chord(haze_puffs[i], params.position.xyz, ray, 0.0);
    if (chord.scale == 0.0) continue;
    float before = plume_erf(chord.per_m * (begin_m - chord.middle));
    sum += chord.scale * (plume_erf(chord.per_m * (behind.a - chord.middle)) - before);
  }
  if (sum == 0.0) return;
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb * exp(-haze_plumes.scattering_per_m * sum), behind.a));
}
