#version 460
// A rival: clusters in the world (z3y, ClusteredBIRP, MIT). A cube about the camera is cut into slabs along X, Y and Z;
// each slab has one bit a light. A place's lights are those of its three slabs, X & Y & Z. This pass fills the slabs:
// one thread a slab and 32 lights.
//
// As published it has 127 lights, and a slab has a light when one of the slab's two faces cuts its box, so that a light
// that fits between two faces is lost. Here any number of lights fits, and both losses are constants of the pipeline.
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

layout(local_size_x = FL_GROUP_CLUSTERS) in;
layout(constant_id = FL_SPEC_CLUSTER_LIGHTS) const uint kLights = 0;
layout(constant_id = FL_SPEC_CLUSTER_EDGES) const bool kEdges = false;
layout(set = 0, binding = FL_BINDING_CLUSTERS, std430) writeonly buffer ClustersBuffer { uint clusters[]; };

void main() {
  uint slab = gl_GlobalInvocationID.x;
  uint word = gl_WorkGroupID.y;
  uint axis = gl_WorkGroupID.z;
  const float kSlabM = 2.0 * FL_CLUSTER_REACH_M / float(FL_CLUSTER_SLABS);
  float low = float(slab) * kSlabM - FL_CLUSTER_REACH_M;
  float high = low + kSlabM;
  // Without its losses the outermost slabs have what is outside the cube.
  if (!kEdges && slab == 0u) low = -FL_FAR_M;
  if (!kEdges && slab == uint(FL_CLUSTER_SLABS) - 1u) high = FL_FAR_M;
  uint lights = kLights > 0u ? min(counts.live_count, kLights) : counts.live_count;
  uint bits = 0u;
  for (uint b = 0u; b < min(lights - min(lights, word * 32u), 32u); ++b) {
    BeamRow row = beams[word * 32u + b];
    BeamEnds ends = beam_ends(row);
    float reach = disc_reach(row.axis.xyz)[axis];
    float from = min(ends.lens_m[axis] - reach * ends.lens_radius_m, ends.end_m[axis] - reach * ends.end_radius_m);
    float to = max(ends.lens_m[axis] + reach * ends.lens_radius_m, ends.end_m[axis] + reach * ends.end_radius_m);
    bool touches = kEdges ? (low > from && low < to) || (high > from && high < to) : low <= to && high >= from;
    if (touches) bits |= 1u << b;
  }
  clusters[(axis * uint(FL_CLUSTER_SLABS) + slab) * params.mask_words + word] = bits;
}
