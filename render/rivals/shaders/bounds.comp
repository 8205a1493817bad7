#version 460
// The box of all live beams and their depths: where a march along the whole ray may end, and what froxels divide.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/rivals/shaders/lib/beam_ends.glsl"

layout(local_size_x = FL_GROUP_BOUNDS) in;
layout(set = 0, binding = FL_BINDING_BOUNDS, std430) writeonly buffer BoundsBuffer { BoundsRow bounds; };

shared vec4 lows[FL_GROUP_BOUNDS];
shared vec4 highs[FL_GROUP_BOUNDS];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 low = vec4(FL_FAR_M);
  vec4 high = vec4(-FL_FAR_M);
  for (uint i = lane; i < counts.live_count; i += uint(FL_GROUP_BOUNDS)) {
    BeamRow row = beams[i];
    BeamEnds ends = beam_ends(row);
    float aside = dot(row.axis.xyz, params.forward.xyz);
    vec4 reach = vec4(disc_reach(row.axis.xyz), sqrt(max(1.0 - aside * aside, 0.0)));
    vec4 lens = vec4(ends.lens_m, dot(ends.lens_m, params.forward.xyz));
    vec4 end = vec4(ends.end_m, dot(ends.end_m, params.forward.xyz));
    low = min(low, min(lens - reach * ends.lens_radius_m, end - reach * ends.end_radius_m));
    high = max(high, max(lens + reach * ends.lens_radius_m, end + reach * ends.end_radius_m));
  }
  lows[lane] = low;
  highs[lane] = high;
  barrier();
  for (uint half_way = uint(FL_GROUP_BOUNDS) / 2u; half_way > 0u; half_way /= 2u) {
    if (lane < half_way) {
      lows[lane] = min(lows[lane], lows[lane + half_way]);
      highs[lane] = max(highs[lane], highs[lane + half_way]);
    }
    barrier();
  }
  if (lane == 0u) {
    low = lows[0];
    high = highs[0];
    low.w = max(low.w, FL_LEAST_DEPTH_M);
    high.w = max(high.w, 2.0 * low.w);
    bounds = BoundsRow(low, high);
  }
}
