#version 460
// Marks shadows of a beam that hide nothing more in the air: those of bodies that are wholly in the shadow of another
// one. On surfaces they count, since those of a fixture ignore its own body. A workgroup a beam.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/solid.glsl"

layout(local_size_x = FL_GROUP_SHADOWS) in;
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) buffer ShadowsBuffer { ShadowRow shadows[]; };
#include "render/shaders/lib/shadow_row.glsl"
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) readonly buffer ShadowListsBuffer {
  ShadowListRow shadow_lists[];
};

layout(constant_id = FL_SPEC_PENUMBRA) const uint kLensPoints = 1u;

// Fewer bodies take less time than this search.
#define FL_PRUNE_MIN 24u

shared uint hidden[FL_BEAM_SHADOWS_MAX / 32];

// Whether a body is wholly in a shadow; at its fronts by as much as a surface may lie inside what throws it. A loop
// that Mesa ends early would be wrong here, so there is none.
bool is_behind(ShadowSolid solid, uint shadow, float slack_m) {
  uint count = shadow_planes(shadow);
  uint outline = shadow_outline(shadow);
  bool inside = true;
  [[unroll]] for (uint k = 0u; k < uint(FL_SHADOW_PLANES); ++k) {
    vec4 plane = shadows[shadow].planes[k];
    float reach = dot(plane.xyz, solid.center);
    [[unroll]] for (int i = 0; i < 3; ++i) reach += abs(dot(plane.xyz, solid.half_edge[i]));
    float most = plane.w + slack_m - (k < outline ? 0.0 : shadows[shadow].slack_m);
    inside = inside && (k >= count || reach <= most);
  }
  return inside;
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint beam_index = gl_WorkGroupID.y * uint(FL_SHADOWS_X) + gl_WorkGroupID.x;
  if (beam_index >= counts.live_count) return;
  ShadowListRow list = shadow_lists[beam_index];
  uint bodies = list.count / kLensPoints;
  if (bodies < FL_PRUNE_MIN) return;
  BeamRow row = beams[beam_index];
  for (uint w = lane; w < uint(FL_BEAM_SHADOWS_MAX / 32); w += uint(FL_GROUP_SHADOWS)) hidden[w] = 0u;
  barrier();
  for (uint own = lane; own < list.count; own += uint(FL_GROUP_SHADOWS)) {
    ShadowSolid solid = solid_of(occluders[shadows[list.first + own].occluder], row);
    bool is_hidden = false;
    uint begin = own / bodies * bodies;  // of the shadows from the same point of the lens
    for (uint other = begin; other < begin + bodies && !is_hidden; ++other) {
      if (other == own || !is_behind(solid, list.first + other, 0.0)) continue;
      // Of two that hide each other the first one stays, also where rounding has a say.
      is_hidden = other < own;
      if (!is_hidden) {
        float rounding_m = 1e-5 * (1.0 + length(solid.center));
        ShadowSolid there = solid_of(occluders[shadows[list.first + other].occluder], row);
        is_hidden = !is_behind(there, list.first + own, rounding_m);
      }
    }
    if (is_hidden) atomicOr(hidden[own / 32u], 1u << (own & 31u));
  }
  barrier();
  for (uint own = lane; own < list.count; own += uint(FL_GROUP_SHADOWS)) {
    if ((hidden[own / 32u] >> (own & 31u) & 1u) == 0u) continue;
    shadows[list.first + own].count |= FL_SHADOW_HIDDEN;
  }
}
