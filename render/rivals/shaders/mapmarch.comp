#version 460
// A rival: equal steps over the part of the ray in the beam, each lit where the beam's shadow map says so. Four texels
// are compared and their results mixed (percentage closer filtering, Reeves, Salesin and Cook, SIGGRAPH 1987).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#include "render/rivals/shaders/lib/rival_light.glsl"
#include "render/rivals/shaders/lib/pixel_walk.glsl"

layout(constant_id = FL_SPEC_MAP_TEXELS) const uint kTexels = 256;
layout(set = 0, binding = FL_BINDING_SHADOW_MAPS, std430) readonly buffer ShadowMapsBuffer { float shadow_maps[]; };

float is_lit(uint map, ivec2 texel, float z_m) {
  uvec2 at = uvec2(clamp(texel, ivec2(0), ivec2(kTexels) - 1));
  return z_m <= shadow_maps[(map * kTexels + at.y) * kTexels + at.x] ? 1.0 : 0.0;
}

// The share of the light that arrives. Beams behind the last map have no shadow.
float lit_share(uint index, BeamShape shape, vec3 p) {
  if (index >= uint(shadow_maps.length()) / (kTexels * kTexels)) return 1.0;
  vec2 rho = p.xy / (shape.lens_radius_m + shape.spread * p.z);
  vec2 place = (rho * 0.5 + 0.5) * float(kTexels) - 0.5;
  ivec2 low = ivec2(floor(place));
  vec2 part = place - vec2(low);
  float below = mix(is_lit(index, low, p.z), is_lit(index, low + ivec2(1, 0), p.z), part.x);
  float above = mix(is_lit(index, low + ivec2(0, 1), p.z), is_lit(index, low + 1, p.z), part.x);
  return mix(below, above, part.y);
}

vec3 air_light(BeamRow row, uint index, BeamShape shape, vec3 ray, float t_max_m, uvec2 pixel) {
  Chord chord;
  if (!beam_chord(shape, row.eye.xyz, ray, 0.0, t_max_m, chord)) return vec3(0.0);
  float from_m = chord.t_base_m + chord.t_from_m;
  float step_m = (chord.t_base_m + chord.t_to_m - from_m) / float(kNodes);
  vec3 total = vec3(0.0);
  for (uint i = 0u; i < kNodes; ++i) {
    float t_m = from_m + (float(i) + 0.5) * step_m;
    float lit = lit_share(index, shape, row.eye.xyz + ray * t_m);
    total += scattered_at(row, index, shape, ray, t_m) * (to_eye(t_m) * lit);
  }
  return total * step_m;
}
