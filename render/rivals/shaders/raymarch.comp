#version 460
// A rival: a ray march with equal steps from the eye to the surface, or to where nothing is lit any more. Every step
// takes the light of its middle.
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

vec3 air_light(BeamRow row, uint index, BeamShape shape, vec3 ray, float t_max_m, uvec2 pixel) {
  vec3 total = vec3(0.0);
  float step_m = t_max_m / float(kNodes);
  for (uint i = 0u; i < kNodes; ++i) {
    float t_m = (float(i) + 0.5) * step_m;
    total += scattered_at(row, index, shape, ray, t_m) * to_eye(t_m);
  }
  return total * step_m;
}
