#version 460
// A rival: a volume of froxels (Wronski, "Volumetric Fog", SIGGRAPH 2014; Hillaire, "Physically Based and Unified
// Volumetric Rendering in Frostbite", SIGGRAPH 2015). First pass: the light that the haze in the middle of each froxel
// sends to the eye, of every beam that the supertile behind it has.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#include "render/rivals/shaders/lib/rival_light.glsl"
#include "render/rivals/shaders/lib/froxel.glsl"

layout(local_size_x = FL_GROUP_FROXELS, local_size_y = FL_GROUP_FROXELS) in;
layout(constant_id = FL_SPEC_FROXEL_SAMPLES) const uint kSamples = 1;

// Of all beams at a place in the picture and its depth.
vec3 light_there(vec2 pixel, float depth_m) {
  vec3 ray = ray_through(pixel);
  float per_depth = length(ray);  // metres along the ray for one of depth
  vec3 d = ray / per_depth;
  uvec2 cell = uvec2(pixel) / uint(FL_SUPERTILE_PX);
  uint first = (cell.y * params.supertiles_x + cell.x) * params.mask_words;
  vec3 total = vec3(0.0);
  for (uint w = 0u; w < (counts.live_count + 31u) / 32u; ++w) {
    for (uint rest = masks[first + w]; rest != 0u; rest &= rest - 1u) {
      uint index = w * 32u + uint(findLSB(rest));
      BeamRow row = beams[index];
      BeamShape shape = begin_beam(row, index);
      total += scattered_at(row, index, shape, to_light(row, d), depth_m * per_depth);
    }
  }
  return total;
}

void main() {
  uvec2 column = gl_GlobalInvocationID.xy;
  uint slice = gl_WorkGroupID.z;
  if (column.x >= kAcross || column.y >= kDown) return;
  vec2 froxel_px = vec2(params.width, params.height) / vec2(kAcross, kDown);
  vec3 total = vec3(0.0);
  for (uint i = 0u; i < kSamples; ++i) {
    // Places that fill the froxel evenly (Roberts 2018, in three dimensions), moved from froxel to froxel.
    vec3 place = vec3(0.0);
    if (kSamples > 1u) {
      uint number = i + kSamples * (column.x + 61u * column.y + 3571u * slice);
      place = fract(float(number & 0xfffffu) * vec3(0.8191725, 0.6710436, 0.5497005)) - 0.5;
    }
    total += light_there(froxel_pixel(column) + place.xy * froxel_px, froxel_depth_m(float(slice) + 0.5 + place.z));
  }
  froxels[froxel_at(column, slice)] = vec4(total / float(kSamples), 0.0);
}
