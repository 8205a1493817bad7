#version 460
// For each supertile of 64 x 64 pixels one bit a live beam: can it touch the supertile? Bits keep the patch order, so
// the passes that walk them sum in a fixed order, and no list can overflow.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS writeonly
#include "render/shaders/lib/frame.glsl"
layout(constant_id = FL_SPEC_RECTANGLE) const bool kRectangle = false;
#define FL_NEED_RECTANGLE kRectangle
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"

layout(local_size_x = FL_GROUP_MASK) in;

// On a surface a thin beam is drawn up to so much wider than in the haze (surfaces.comp).
bool touches(BeamRow row, vec2 low, vec2 high) {
  return beam_touches(row, beam_bound(row, FL_THIN_ON_SURFACE), low, high);
}

shared uint bits[FL_GROUP_MASK / 32];

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint beam = gl_GlobalInvocationID.x;
  uint supertile = gl_WorkGroupID.y;
  if (lane < uint(FL_GROUP_MASK) / 32u) bits[lane] = 0u;
  barrier();
  uvec2 cell = uvec2(supertile % params.supertiles_x, supertile / params.supertiles_x);
  vec2 low = vec2(cell * uint(FL_SUPERTILE_PX));
  vec2 high = min(low + float(FL_SUPERTILE_PX), vec2(float(params.width), float(params.height)));
  if (beam < counts.live_count && touches(beams[beam], low, high)) atomicOr(bits[lane >> 5], 1u << (lane & 31u));
  barrier();
  uint word = gl_WorkGroupID.x * (uint(FL_GROUP_MASK) / 32u) + lane;
  if (lane < uint(FL_GROUP_MASK) / 32u && word < params.mask_words) {
    masks[supertile * params.mask_words + word] = bits[lane];
  }
}
