// The visibility buffer: what solid thing a pixel shows, and how far away it is.
layout(set = 0, binding = FL_BINDING_SURFACE_ID, rg32ui) uniform readonly uimage2D surface_id;
layout(set = 0, binding = FL_BINDING_DEPTH) uniform sampler2D depth_image;

layout(constant_id = FL_SPEC_SOLIDS) const bool kSolids = true;

// Distance along the unit ray to what the pixel shows; the range of light where it shows nothing.
float surface_distance(ivec2 pixel, vec3 unit_ray) {
  float range_m = params.up.w;
  if (!kSolids) return range_m;
  float depth = texelFetch(depth_image, pixel, 0).x;
  if (!(depth > 0.0)) return range_m;
  return min(params.right.w / (depth * dot(unit_ray, params.forward.xyz)), range_m);
}

#include "render/shaders/lib/normal.glsl"
