// The table of haze that is not even (haze.comp): along rays through a grid over the picture, the integral of the
// density of haze minus 1 from where the table begins. So the mean density of any piece of any ray is a difference of
// two values, however long the piece is and however small the clouds are. Distances lie closer near the camera, as the
// grid's rays do. Beyond the table haze counts as even.
//
// A pass that reads it says for which ray: haze_begin(), before any of beam.h.
#include "render/shaders/shared/haze_field.h"
#ifdef FL_HAZE_PLUMES
#include "render/shaders/shared/haze_plume.h"
layout(set = 0, binding = FL_BINDING_HAZE, std430) readonly buffer HazeBuffer {
  HazeField haze_field;
  HazePlumes haze_plumes;
  HazePuff haze_puffs[];
};
#else
layout(set = 0, binding = FL_BINDING_HAZE, std430) readonly buffer HazeBuffer { HazeField haze_field; };
#endif
// A texel a ray and a layer a slice: the integral, m, where the slice begins and where it ends. With plumes, whose
// densities change within a slice, also its slope at both, over a slice.
#ifdef FL_HAZE_NO_TABLE
#elif defined(FL_HAZE_WRITE)
#ifdef FL_HAZE_PLUMES
#define FL_HAZE_FORMAT rgba32f
#else
#define FL_HAZE_FORMAT rg32f
#endif
layout(set = 0, binding = FL_BINDING_HAZE_TABLE_OUT, FL_HAZE_FORMAT) uniform writeonly image2DArray haze_table;
#else
layout(set = 0, binding = FL_BINDING_HAZE_TABLE) uniform sampler2DArray haze_table;
#endif

// Distances are length x c u / (1 + c - u): at u = 0 a slice is c / (1 + c) of what an even one is.
const float kHazeCurve = 0.5;
float haze_distance(float u) {
  return haze_field.from_m + haze_field.length_m * kHazeCurve * u / (1.0 + kHazeCurve - u);
}

// Its slope at the end of slice k, over a slice.
float haze_slope(uint k) {
  float rest = 1.0 + kHazeCurve - float(k) / float(FL_HAZE_SLICES);
  return haze_field.length_m * kHazeCurve * (1.0 + kHazeCurve) / (rest * rest * float(FL_HAZE_SLICES));
}

#ifndef FL_HAZE_WRITE
#define FL_HAZE_FIELD
layout(constant_id = FL_SPEC_PLUMES) const bool kPlumes = false;
vec2 haze_texel;  // of the ray, in the table

// px: place in the picture, pixels. Outside of it the haze is that of its border.
void haze_begin(vec2 px) {
  vec2 nodes = vec2(FL_HAZE_X, FL_HAZE_Y);
  haze_texel = (px / vec2(float(params.width), float(params.height)) * (nodes - 1.0) + 0.5) / nodes;
}

// The integral up to a distance along the ray.
float haze_until(float t_m) {
  float past_m = max(t_m - haze_field.from_m, 0.0);
  float u = past_m * (1.0 + kHazeCurve) / (past_m + kHazeCurve * haze_field.length_m);
  float at = min(u, 1.0) * float(FL_HAZE_SLICES);
  float slice = min(floor(at), float(FL_HAZE_SLICES - 1));
  vec4 ends = textureLod(haze_table, vec3(haze_texel, slice), 0.0);
  float t = at - slice;
  if (!kPlumes) return mix(ends.x, ends.y, t);
  return mix(ends.x, ends.y, t * t * (3.0 - 2.0 * t)) + t * (1.0 - t) * ((1.0 - t) * ends.z - t * ends.w);
}
#endif
