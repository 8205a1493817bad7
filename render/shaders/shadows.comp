#version 460
// Finds the shadows in a beam: a workgroup goes through all that hides light, in its order. The first time they are
// counted, the second time they are written to where places.comp has made room.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"

layout(local_size_x = FL_GROUP_SHADOWS) in;
layout(constant_id = FL_SPEC_WRITE) const bool kWrite = false;
// Whether anything beside the stage boxes, which come first, hides light.
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = false;
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) buffer ShadowListsBuffer { ShadowListRow shadow_lists[]; };
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) writeonly buffer ShadowsBuffer { ShadowRow shadows[]; };

const uint kWords = uint(FL_GROUP_SHADOWS / 32);
shared uint found_bits[kWords];

// Whether a sphere touches the beam's cone; light space, m.
bool sphere_touches(BeamShape beam, vec3 center, float radius_m) {
  if (center.z < -radius_m || center.z > beam.range_m + radius_m) return false;
  // The distance from the cone's side, and not less than it is beyond the lens plane.
  float slant = inversesqrt(1.0 + beam.spread * beam.spread);
  float aside = (length(center.xy) - beam.lens_radius_m - beam.spread * max(center.z, 0.0)) * slant;
  return aside <= radius_m;
}

bool find(uint index, BeamRow row, BeamShape beam, uint fixture, out ShadowPrism prism) {
  OccluderRow occluder = occluders[index];
  prism.count = 0u;
  if (occluder.half_edge_0.w < 0.0 || occluder.fixture == fixture) return false;
  ShadowSolid solid;
  vec3 center = vec3(occluder.center_x, occluder.center_y, occluder.center_z);
  solid.center = row.eye.xyz + to_light(row, center - params.position.xyz);
  if (!sphere_touches(beam, solid.center, occluder.half_edge_0.w * beam_stretch(row.squeeze))) return false;
  solid.half_edge[0] = to_light(row, occluder.half_edge_0.xyz);
  solid.half_edge[1] = to_light(row, occluder.half_edge_1.xyz);
  solid.half_edge[2] = to_light(row, occluder.half_edge_2.xyz);
  return shadow_prism(beam.lens_radius_m, beam.spread, solid, prism) && prism.z_min_m < beam.range_m;
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint beam_index = gl_WorkGroupID.y * uint(FL_SHADOWS_X) + gl_WorkGroupID.x;
  if (beam_index >= counts.live_count) return;
  BeamRow row = beams[beam_index];
  BeamShape beam = beam_shape(row);
  uint fixture = heads[row.head].fixture;
  uint count = 0u;
  uint first = kWrite ? shadow_lists[beam_index].first : 0u;
  uint room = kWrite ? shadow_lists[beam_index].count : 0u;
  uint all = uint(occluders.length());
  if (!kBodies) all = min(all, params.box_count);
  for (uint at = 0u; at < all; at += uint(FL_GROUP_SHADOWS)) {
    barrier();  // the bits have been read
    if (lane < kWords) found_bits[lane] = 0u;
    barrier();
    ShadowPrism prism;
    bool found = false;
    if (at + lane < all) found = find(at + lane, row, beam, fixture, prism);
    if (found) atomicOr(found_bits[lane >> 5], 1u << (lane & 31u));
    barrier();
    uint rank = count + bitCount(found_bits[lane >> 5] & ((1u << (lane & 31u)) - 1u));
    for (uint w = 0u; w < kWords; ++w) {
      uint here = bitCount(found_bits[w]);
      count += here;
      if (w < lane >> 5) rank += here;
    }
    if (kWrite && found && rank < room) {
      uint slot = first + rank;
      shadows[slot].count = prism.count;
      shadows[slot].fronts = prism.fronts;
      shadows[slot].fixture = occluders[at + lane].fixture;
      shadows[slot].slack_m = occluders[at + lane].half_edge_1.w;
      for (uint k = 0u; k < uint(FL_SHADOW_PLANES); ++k) {
        // Everything is inside those that fill up a round.
        vec4 plane = vec4(0.0, 0.0, 0.0, 1.0);
        if (k < prism.count) plane = vec4(prism.planes[k].normal, prism.planes[k].offset);
        shadows[slot].planes[k] = plane;
      }
    }
  }
  // Two pipelines need not compute the last bit alike: no row that was not written is read.
  if (lane == 0u) shadow_lists[beam_index].count = kWrite ? min(count, room) : count;
}
