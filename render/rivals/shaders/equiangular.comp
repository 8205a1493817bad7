#version 460
// A rival: equi-angular sampling (Kulla & Fajardo, "Importance Sampling Techniques for Path Tracing in Participating
// Media", EGSR 2012). Places on the ray are drawn evenly in the angle that a point of light sees, so that the light's
// inverse square is in the density and not in the samples. The point is the one that the cone's light seems to come
// from, behind the lens. One random place in each of n equal parts of the angle, or its middle.
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

layout(constant_id = FL_SPEC_JITTER) const bool kJitter = true;

// The point of a beam that hardly spreads is far behind it, where floats have no angles left. Any point is right; its
// distance only decides how good the samples are.
const float kPoleMostM = 200.0;

// PCG of three words (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020), 0 to 1.
float random_at(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  return float(v.x >> 8u) * (1.0 / 16777216.0);
}

vec3 air_light(BeamRow row, uint index, BeamShape shape, vec3 ray, float t_max_m, uvec2 pixel) {
  float from_m = 0.0;
  float to_m = t_max_m;
  if (!kWholeRay) {
    Chord chord;
    if (!beam_chord(shape, row.eye.xyz, ray, 0.0, t_max_m, chord)) return vec3(0.0);
    from_m = chord.t_base_m + chord.t_from_m;
    to_m = chord.t_base_m + chord.t_to_m;
  }
  float behind_m = min(shape.lens_radius_m / max(shape.spread, 1e-9), kPoleMostM);
  vec3 from_pole = row.eye.xyz + vec3(0.0, 0.0, behind_m);
  float nearest_m = -dot(from_pole, ray) / dot(ray, ray);
  float away_m = max(length(from_pole + ray * nearest_m), 1e-4);
  float angle_from = atan((from_m - nearest_m) / away_m);
  float angle = atan((to_m - nearest_m) / away_m) - angle_from;
  vec3 total = vec3(0.0);
  for (uint i = 0u; i < kNodes; ++i) {
    float place = kJitter ? random_at(uvec3(pixel, index * 64u + i)) : 0.5;
    float tangent = tan(angle_from + angle * (float(i) + place) / float(kNodes));
    float t_m = clamp(nearest_m + away_m * tangent, from_m, to_m);
    total += scattered_at(row, index, shape, ray, t_m) * (to_eye(t_m) * (1.0 + tangent * tangent));
  }
  return total * (angle * away_m / float(kNodes));
}
