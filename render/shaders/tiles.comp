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

// A workgroup has FL_GROUP_MASK beams and a block of supertiles. A thread reads its beam once, and tests it against the
// whole block first: most beams touch few blocks.
const uint kBlock = uint(FL_BLOCK_SUPERTILES);
shared uint bits[kBlock * kBlock * FL_GROUP_MASK / 32];

void main() {
  const uint kWords = uint(FL_GROUP_MASK) / 32u;
  uint lane = gl_LocalInvocationIndex;
  uint beam = gl_GlobalInvocationID.x;
  uvec2 size = uvec2(params.width, params.height);
  uvec2 supertiles = (size + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
  uint blocks_across = (supertiles.x + kBlock - 1u) / kBlock;
  uvec2 first = uvec2(gl_WorkGroupID.y % blocks_across, gl_WorkGroupID.y / blocks_across) * kBlock;
  uvec2 end = min(first + kBlock, supertiles);
  for (uint w = lane; w < kBlock * kBlock * kWords; w += uint(FL_GROUP_MASK)) bits[w] = 0u;
  barrier();
  if (beam < counts.live_count) {
    BeamRow row = beams[beam];
    // On a surface a thin beam is drawn up to so much wider than in the haze (surfaces.comp).
    BeamShape bound = beam_bound(row, FL_THIN_ON_SURFACE);
    vec2 picture = vec2(size);
    vec2 low = vec2(first * uint(FL_SUPERTILE_PX));
    if (beam_touches(row, bound, low, min(vec2(end * uint(FL_SUPERTILE_PX)), picture))) {
      for (uint y = first.y; y < end.y; ++y) {
        for (uint x = first.x; x < end.x; ++x) {
          low = vec2(uvec2(x, y) * uint(FL_SUPERTILE_PX));
          if (!beam_touches(row, bound, low, min(low + float(FL_SUPERTILE_PX), picture))) continue;
          uint cell = (y - first.y) * kBlock + x - first.x;
          atomicOr(bits[cell * kWords + (lane >> 5)], 1u << (lane & 31u));
        }
      }
    }
  }
  barrier();
  for (uint w = lane; w < kBlock * kBlock * kWords; w += uint(FL_GROUP_MASK)) {
    uint cell = w / kWords;
    uvec2 at = first + uvec2(cell % kBlock, cell / kBlock);
    uint word = gl_WorkGroupID.x * kWords + w % kWords;
    if (at.x < end.x && at.y < end.y && word < params.mask_words) {
      masks[(at.y * params.supertiles_x + at.x) * params.mask_words + word] = bits[w];
    }
  }
}
