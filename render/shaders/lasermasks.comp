#version 460
// For each supertile one bit a row of the lasers: may it touch the supertile? One thread a word. Bits keep the order of
// the rows, so that sums have one order.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"

layout(local_size_x = FL_GROUP_LASERS) in;
layout(set = 0, binding = FL_BINDING_LASER_MASKS, std430) writeonly buffer LaserMasksBuffer { uint laser_masks[]; };

void main() {
  uint rows = uint(lasers.length());
  uint words = (rows + 31u) / 32u;
  uint word = gl_GlobalInvocationID.x;
  if (word >= words) return;
  uint supertile = gl_WorkGroupID.y;
  vec2 low = vec2(supertile % params.supertiles_x, supertile / params.supertiles_x) * float(FL_SUPERTILE_PX);
  vec2 high = min(low + float(FL_SUPERTILE_PX), vec2(params.width, params.height));
  uint bits = 0u;
  for (uint i = 0u; i < min(32u, rows - 32u * word); ++i) {
    // A dark row has only a box.
    uint index = 32u * word + i;
    vec4 box = lasers[index].box;
    if (box.x > box.z || any(greaterThan(box.xy, high)) || any(lessThan(box.zw, low))) continue;
    if (laser_touches(lasers[index], low, high)) bits |= 1u << i;
  }
  laser_masks[supertile * words + word] = bits;
}
