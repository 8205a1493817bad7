#version 460
// Gives the shadows of each beam their rows, in the order of the beams: one workgroup adds up their counts. What does
// not fit into the table is lost, and counted.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_PLACES) in;
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) buffer ShadowListsBuffer { ShadowListRow shadow_lists[]; };
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) readonly buffer ShadowsBuffer { ShadowRow shadows[]; };

layout(constant_id = FL_SPEC_MAP_PX) const uint kMapPx = 0u;
const bool kMaps = kMapPx > 0u;
// Rows that a pair of a beam and a body has.
layout(constant_id = FL_SPEC_PENUMBRA) const uint kLensPoints = 1u;
const uint kPairsMax = uint(FL_BEAM_SHADOWS_MAX) / kLensPoints;  // of one beam

shared uint sums[FL_GROUP_PLACES];
shared uint lost[FL_GROUP_PLACES];

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint live = counts.live_count;
  uint share = (live + uint(FL_GROUP_PLACES) - 1u) / uint(FL_GROUP_PLACES);
  uint begin = min(lane * share, live);
  uint end = min(begin + share, live);
  uint sum = 0u;
  for (uint b = begin; b < end; ++b) sum += kLensPoints * min(shadow_lists[b].count, kPairsMax);
  sums[lane] = sum;
  barrier();
  uint at = 0u;
  for (uint l = 0u; l < lane; ++l) at += sums[l];
  uint rows = uint(shadows.length());
  uint found = 0u;
  uint kept = 0u;
  for (uint b = begin; b < end; ++b) {
    uint count = shadow_lists[b].count;
    uint fits = min(min(count, kPairsMax), (rows - min(at, rows)) / kLensPoints);
    if (kMaps) fits = count;  // maps have no rows
    shadow_lists[b].first = min(at, rows);
    shadow_lists[b].count = kLensPoints * fits;
    at += kLensPoints * min(count, kPairsMax);
    found += count;
    kept += fits;
  }
  barrier();
  sums[lane] = found;
  lost[lane] = found - kept;
  barrier();
  if (lane != 0u) return;
  for (uint l = 1u; l < uint(FL_GROUP_PLACES); ++l) {
    found += sums[l];
    kept += sums[l] - lost[l];
  }
  counts.shadows = found;
  counts.shadows_lost = found - kept;
}
