#version 460
// Finds the shadows in a beam: a workgroup goes through all that hides light, in its order. The first time the bodies
// that may have a shadow in it are counted, the second time their shadows are written to where places.comp has made
// room.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
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
#include "render/shaders/lib/tile_test.glsl"

layout(set = 0, binding = FL_BINDING_SHADOWS, std430) writeonly buffer ShadowsBuffer { ShadowRow shadows[]; };
uint emit_slot;
void emit_plane(uint index, vec3 normal, float offset) { shadows[emit_slot].planes[index] = vec4(normal, offset); }
#define FL_SHADOW_EMIT emit_plane
#include "render/shaders/shared/shadow.h"

layout(local_size_x = FL_GROUP_SHADOWS) in;
layout(constant_id = FL_SPEC_WRITE) const bool kWrite = false;
// Whether anything beside the stage boxes, which come first, hides light.
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = false;
#include "render/shaders/lib/solid.glsl"
layout(constant_id = FL_SPEC_PENUMBRA) const uint kLensPoints = 1u;
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) buffer ShadowListsBuffer { ShadowListRow shadow_lists[]; };

const uint kWords = uint(FL_GROUP_SHADOWS / 32);
shared uint found_bits[kWords];

// Nothing is inside the only plane.
void write_nothing(uint point) {
  for (uint k = 0u; k < uint(FL_SHADOW_PLANES); ++k) emit_plane(k, vec3(0.0), -1.0);
  shadows[emit_slot].count = 1u | point << FL_SHADOW_POINT_SHIFT;
  shadows[emit_slot].occluder = 0u;
  shadows[emit_slot].fixture = FL_NONE;
  shadows[emit_slot].slack_m = 0.0;
}

void write_shadow(uint which, uint point, BeamRow row, BeamShape beam) {
  OccluderRow occluder = occluders[which];
  ShadowSolid solid = solid_of(occluder, row);
  ShadowPrism prism;
  bool has_shadow = kLensPoints > 1u
                        ? shadow_prism_from(lens_point(kLensPoints, point, shadow_lens_m(row)), solid, prism)
                        : shadow_prism(beam.lens_radius_m, beam.spread, solid, prism);
  has_shadow = has_shadow && prism.z_min_m < beam.range_m;
  // Nothing is inside the only plane of a body without a shadow. Everything is inside those that fill up a round.
  uint count = has_shadow ? prism.count : 0u;
  for (uint k = count; k < uint(FL_SHADOW_PLANES); ++k) emit_plane(k, vec3(0.0), has_shadow ? 1.0 : -1.0);
  // From a point there are 9 at most. What is left holds the place of the axis where the body begins (shadow_near()).
  if (kLensPoints > 1u && has_shadow) emit_plane(uint(FL_SHADOW_PLANES - 1), vec3(0.0), 1.0 + prism.z_min_m);
  shadows[emit_slot].count =
      max(count, 1u) | (has_shadow ? prism.fronts : 0u) << 8 | point << FL_SHADOW_POINT_SHIFT;
  shadows[emit_slot].occluder = which;
  shadows[emit_slot].fixture = occluder.fixture;
  shadows[emit_slot].slack_m = occluder.half_edge_1.w;
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
  uint room = kWrite ? shadow_lists[beam_index].count / kLensPoints : 0u;  // from each point of the lens
  uint all = uint(occluders.length());
  if (!kBodies) all = min(all, params.box_count);
  for (uint at = 0u; at < all; at += uint(FL_GROUP_SHADOWS)) {
    barrier();  // the bits have been read
    if (lane < kWords) found_bits[lane] = 0u;
    barrier();
    bool found = at + lane < all && may_hide(occluders[at + lane], row, beam, fixture);
    if (found) atomicOr(found_bits[lane >> 5], 1u << (lane & 31u));
    barrier();
    uint rank = count + bitCount(found_bits[lane >> 5] & ((1u << (lane & 31u)) - 1u));
    for (uint w = 0u; w < kWords; ++w) {
      uint here = bitCount(found_bits[w]);
      count += here;
      if (w < lane >> 5) rank += here;
    }
    if (kWrite && found && rank < room) {
      for (uint point = 0u; point < kLensPoints; ++point) {
        emit_slot = first + point * room + rank;
        write_shadow(at + lane, point, row, beam);
      }
    }
  }
  // Two pipelines need not compute the last bit alike: no row that was not written is read.
  if (kWrite && kLensPoints > 1u) {
    for (uint own = lane; own < kLensPoints * (room - min(count, room)); own += uint(FL_GROUP_SHADOWS)) {
      uint rest = room - count;
      emit_slot = first + own / rest * room + count + own % rest;
      write_nothing(own / rest);
    }
    return;
  }
  if (lane == 0u) shadow_lists[beam_index].count = kWrite ? min(count, room) : count;
}
