#version 460
// A rival's shadow maps: for each beam a square of texels over its lens, which hold how far along the axis the light
// through their middle gets. A real one rasterises the scene from the lens; this one asks the same shadows as the
// product, so that rivals differ in their resolution and not in what hides light.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"

layout(local_size_x = FL_GROUP_MAPS, local_size_y = FL_GROUP_MAPS) in;
layout(constant_id = FL_SPEC_MAP_TEXELS) const uint kTexels = 256;
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) readonly buffer ShadowListsBuffer {
  ShadowListRow shadow_lists[];
};
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) readonly buffer ShadowsBuffer { ShadowRow shadows[]; };
#include "render/shaders/lib/shadow_row.glsl"
layout(set = 0, binding = FL_BINDING_SHADOW_MAPS, std430) writeonly buffer ShadowMapsBuffer { float shadow_maps[]; };

// Where the light enters a shadow, m along the axis; FL_FAR_M: nowhere.
float enters_m(uint shadow, vec2 rho, float lens_radius_m, float spread) {
  uint outline = shadow_outline(shadow);
  float from_m = 0.0;
  float to_m = FL_FAR_M;
  for (uint k = 0u; k < shadow_planes(shadow) && from_m <= to_m; ++k) {
    vec4 plane = shadows[shadow].planes[k];
    float at_lens = dot(plane.xy, rho * lens_radius_m) - plane.w;
    float slope = dot(plane.xy, rho * spread) + plane.z;
    if (k < outline) {
      // Through the apex: the sign is that at any place in front of it.
      if (at_lens + slope > 0.0) return FL_FAR_M;
    } else if (slope < 0.0) {
      from_m = max(from_m, -at_lens / slope);
    } else if (slope > 0.0) {
      to_m = min(to_m, -at_lens / slope);
    } else if (at_lens > 0.0) {
      return FL_FAR_M;
    }
  }
  return from_m <= to_m ? from_m : FL_FAR_M;
}

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  uint beam = gl_WorkGroupID.z;
  if (beam >= counts.live_count || texel.x >= kTexels || texel.y >= kTexels) return;
  vec2 rho = (vec2(texel) + 0.5) * (2.0 / float(kTexels)) - 1.0;
  float lens_radius_m = beams[beam].x_axis.w;
  float spread = beams[beam].y_axis.w;
  uint first = shadow_lists[beam].first;
  uint count = shadow_lists[beam].count;
  float nearest_m = FL_FAR_M;
  for (uint s = first; s < first + count; ++s) nearest_m = min(nearest_m, enters_m(s, rho, lens_radius_m, spread));
  shadow_maps[(beam * kTexels + texel.y) * kTexels + texel.x] = nearest_m;
}
