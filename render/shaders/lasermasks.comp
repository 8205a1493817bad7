#version 460
// For each supertile one bit a row of the lasers: may it touch the supertile? One workgroup a row, which goes through
// the supertiles of the row's box. Bits and numbers begin as 0; bits keep the order of the rows, so that sums have one
// order.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"

layout(local_size_x = FL_GROUP_LASERS) in;
#include "render/shaders/lib/laser_strip.glsl"
#define FL_LASER_MASKS_ACCESS
#include "render/shaders/lib/laser_masks.glsl"
#define FL_STRIPS_ACCESS readonly
#define FL_LISTS_ACCESS
#include "render/shaders/lib/laser_lists.glsl"

void main() {
  uint row = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  if (row >= uint(lasers.length())) return;
  vec4 box = lasers[row].box;  // a dark row has only a box
  vec2 size = vec2(params.width, params.height);
  if (!(box.x <= box.z) || any(greaterThan(box.xy, size)) || any(lessThan(box.zw, vec2(0.0)))) return;
  // Where a box ends at the end of a supertile, it may touch both.
  uvec2 first = uvec2(max(box.xy / float(FL_SUPERTILE_PX) - 1e-3, 0.0));
  uvec2 last = uvec2(min(box.zw, size) / float(FL_SUPERTILE_PX) + 1e-3);
  uint rows_of_supertiles = (params.height + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
  last = min(last, uvec2(params.supertiles_x, rows_of_supertiles) - 1u);
  uvec2 span = last - min(first, last) + 1u;
  first = min(first, last);
  uint words = laser_words();
  for (uint i = gl_LocalInvocationIndex; i < span.x * span.y; i += uint(FL_GROUP_LASERS)) {
    uvec2 at = first + uvec2(i % span.x, i / span.x);
    vec2 low = vec2(at) * float(FL_SUPERTILE_PX);
    if (!laser_touches(lasers[row], low, min(low + float(FL_SUPERTILE_PX), size))) continue;
    // Once more, by how wide the light is there.
    const float half_square = 0.5 * float(FL_SUPERTILE_PX);
    if (laser_strip(lasers[row], laser_sheet(lasers[row]), low + half_square, half_square).size.x == 0.0) continue;
    uint supertile = at.y * params.supertiles_x + at.x;
    atomicOr(laser_masks[supertile * words + row / 32u], 1u << (row % 32u));
    atomicAdd(laser_lists[supertile].rows, 1u);
  }
}
