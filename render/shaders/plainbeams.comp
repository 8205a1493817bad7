#version 460
// Light in the haze, pixel by pixel, of plain beams (lib/plain_beams.glsl): nothing stands in them, and light along a
// chord with shadows is one polynomial. There is no code for others here, so more of a GPU's threads run at a time.
// beams.comp comes after it and has what it leaves. FL_CUT_BEAMS: cutbeams.comp, where shadows are exact.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS readonly
#define FL_SERIES_TWICE
#define FL_UNROLL [[unroll]]
#ifndef FL_CUT_BEAMS
#define FL_SERIES_NODES_MAX 6
#endif
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
#include "render/shaders/lib/mirror.glsl"
#define FL_DEPTHS_ACCESS
#include "render/shaders/lib/air_tile.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
#include "render/shaders/lib/air_nodes.glsl"
#include "render/shaders/lib/shadow_row_light.glsl"
#include "render/shaders/lib/alike.glsl"

shared uint walk_leaves;  // the tile has other beams

bool tile_takes(uint beam, uint number) {
  BeamRow row = beams[beam];
  if (!touches_tile(row)) return false;
  if (!is_plain_beam(row)) {
    atomicOr(walk_leaves, 1u);
    return false;
  }
  if (kShadows) walk_pairs[number] = picks_here(beam).count;
  return true;
}

// A beam as it is drawn, with what is constant here.
struct PlainBeam {
  BeamRow row;
  BeamShape shape;
  Medium medium;
  uint nodes;
  bool thin;
};
PlainBeam plain_beam(uint index) {
  PlainBeam beam;
  beam.row = beams[index];
  beam.shape = beam_shape(beam.row);
  beam.shape.profile_power = drawn_profile(beam.shape.profile_power);
  beam.shape.squeeze = 0.0;
  beam.shape.measured = 0u;
  beam.shape.hidden = 0.0;
  beam.medium = Medium(params.anisotropy, params.position.w);
  beam.nodes = air_nodes(beam.shape.profile_power);
  beam.thin = thin_in_haze_applies(beam.row);
  if (beam.thin) beam.nodes = min(max(beam.nodes, kNodes + 1u), 8u);  // (1 - rho^2)^3
  return beam;
}

// A beam's chord of a pixel's ray.
struct AirChord {
  bool seen;
  vec3 ray;  // in light space
  BeamShape shape;
  float gain;
  Chord chord;
};
AirChord air_chord(PlainBeam beam, AirRay ray) {
  AirChord at;
  at.ray = to_light(beam.row, ray.d);
  at.shape = beam.shape;
  at.gain = 1.0;
  vec3 eye = beam.row.eye.xyz;
  float depth = dot(ray.d, params.forward.xyz);
  if (beam.thin) at.gain = thin_in_haze(at.shape, beam.row, eye, at.ray, depth, ray.t_max_m, true);
  at.seen = beam_chord(at.shape, eye, at.ray, ray_begin(ray.d), ray.t_max_m, at.chord);
  return at;
}

// Nodes of the polynomial of a chord that exact shadows cut. Six are exact for profiles of a degree up to 5 in s. A
// number that is known here makes shorter code.
const uint kCutNodes = kProfile ? 8u : 6u;
// Light of such a chord: of its lit parts, or of its dark ones where those are subtracted. They do not touch each
// other, so they need no order. Called by all threads of a subgroup.
float cut_light(AirChord at, ShadowParts parts, Medium medium, bool subtracts) {
  ShadowSeries series;
  shadow_series(at.shape, medium, at.chord, at.ray, kCutNodes, kExtinction, series);
  float dark = 0.0;
  [[unroll]] for (int i = 0; i < FL_SHADOW_PARTS; ++i) {
    if (subgroupAny(parts.from[i] < 1.5)) {
      dark += shadow_series_until(series, parts.to[i]) - shadow_series_until(series, parts.from[i]);
    }
  }
  return clamp(subtracts ? dark : series.whole - dark, 0.0, max(series.whole, 0.0));
}
ShadowParts cut_parts(WalkShadows shadows_of, ShadowChord ends) {
  ShadowParts parts;
  shadow_parts_clear(parts);
  for (uint k = 0u; k < shadows_of.count; ++k) shadow_parts_join(parts, walk_shadow(shadows_of, k), ends);
  return parts;
}
// Of all chords of the thread: planes are read once for all of them. A GPU has no registers for so much.
void cut_parts_alike(WalkShadows shadows_of, ShadowChord ends[FL_ROWS], out ShadowParts parts[FL_ROWS]) {
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) shadow_parts_clear(parts[i]);
  for (uint k = 0u; k < shadows_of.count; ++k) {
    uint entry = walk_shadow(shadows_of, k);
    uint planes = entry_planes(entry);
    uint rounds = plane_rounds(planes);
    vec2 part[FL_ROWS];
    bool dark[FL_ROWS];
    [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
      part[i] = vec2(0.0, 1.0);
      dark[i] = true;
    }
    for (uint round_of = 0u; round_of < rounds; ++round_of) {
      FourPlanes four = next_planes_alike(entry, planes);
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        [[unroll]] for (int j = 0; j < 4; ++j) {
          bool inside = shadow_cut(dot(four.of[j], ends[i].from), dot(four.of[j], ends[i].to), part[i].x, part[i].y);
          dark[i] = inside && dark[i];
        }
      }
    }
    [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
      if (dark[i]) shadow_parts_add(parts[i], part[i].x, part[i].y);
    }
  }
}

// The light of a beam without shadows in the tile (lit); else of its lit parts, or of its dark ones where those are
// subtracted, since all of it was added.
vec3 light_of(uint index, PlainBeam beam, bool lit, WalkShadows shadows_of, AirRay ray, bool subtracts) {
  AirChord at = air_chord(beam, ray);
  if (!subgroupAny(at.seen)) return vec3(0.0);
  float light = 0.0;
  if (lit) {
    if (at.seen) light = chord_inscatter_gauss(at.shape, beam.medium, at.chord, at.ray, beam.nodes, kExtinction);
  } else if (!kMaps) {
    ShadowParts parts = cut_parts(shadows_of, shadow_chord(beam.row, at.shape, at.chord, at.ray));
    light = cut_light(at, parts, beam.medium, subtracts);
  } else if (at.seen) {
    // That the eye is beside the beam was decided with the flag: a second test may decide otherwise by rounding.
    light = row_light(index, at.shape, beam.medium, at.chord, at.ray, row_line_of(at.chord, at.ray), subtracts);
  }
  return at.seen ? beam.row.j0.rgb * (at.gain * (subtracts ? -light : light)) : vec3(0.0);
}
// The same for all pixels of the thread, of a beam that exact shadows cut.
void add_cut_alike(PlainBeam beam, WalkShadows shadows_of, AirRay rays[FL_ROWS], bool subtracts,
                   inout vec3 total[FL_ROWS]) {
  AirChord at[FL_ROWS];
  ShadowChord ends[FL_ROWS];
  ShadowParts parts[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    at[i] = air_chord(beam, rays[i]);
    ends[i] = shadow_chord(beam.row, at[i].shape, at[i].chord, at[i].ray);
  }
  cut_parts_alike(shadows_of, ends, parts);
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    float light = cut_light(at[i], parts[i], beam.medium, subtracts);
    if (at[i].seen) total[i] += beam.row.j0.rgb * (at[i].gain * (subtracts ? -light : light));
  }
}

// A GPU has one loop for lit and shaded beams, since its caches hold no code of two: with 1,000 heads and rows of maps
// at 3840 x 2160 this pass takes 5.4 ms with one on an H200 and 8.2 with two.
void add_beams(uint begin, AirRay rays[FL_ROWS], inout vec3 total[FL_ROWS]) {
  WalkShadows shadows_of;
  FL_WALK_BEGIN(number, index, kAlikeReads ? walk_lit(walk_w) : walk_lit(walk_w) | walk_cut(walk_w))
    PlainBeam beam = plain_beam(index);
    bool lit = kAlikeReads || !kShadows || subgroupBroadcastFirst(walk_found[number]) == 0u;
    bool subtracts = !lit && !is_left(index);
    if (!lit && !kMaps) shadows_of = walk_shadows_of(number, begin);
    [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
      total[i] += light_of(index, beam, lit, shadows_of, rays[i], subtracts);
    }
  FL_WALK_END
  if (!kAlikeReads || !kShadows) return;
  FL_WALK_BEGIN(number, index, walk_cut(walk_w))
    PlainBeam beam = plain_beam(index);
    bool subtracts = !is_left(index);
    if (kMaps) {
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        total[i] += light_of(index, beam, false, shadows_of, rays[i], subtracts);
      }
    } else {
      add_cut_alike(beam, walk_shadows_of(number, begin), rays, subtracts, total);
    }
  FL_WALK_END
}

void main() {
  uint tile = gl_WorkGroupID.y * tiles_across() + gl_WorkGroupID.x;
  if (gl_LocalInvocationIndex == 0u) walk_leaves = 0u;
  barrier();
  FL_AIR_WALK
  barrier();
  if (marks_tiles() && gl_LocalInvocationIndex == 0u) tile_depths[tile].beams_left = walk_leaves;
}
