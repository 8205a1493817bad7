#version 460
// Light in the haze, pixel by pixel: adds the in-scattered light of every beam along the pixel's ray, up to the surface
// it shows. With tile classes, of the beams that the fine pass has left. FL_GOBO_BEAMS: beams may have gobos.
// FL_USE_HAZE: haze is not even. Beams that plainbeams.comp has are left out.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo.glsl"
#else
#include "render/shaders/lib/blades.glsl"
#endif
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_SERIES_NODES_MAX 6
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo_chord.glsl"
#endif
#include "render/shaders/lib/mirror.glsl"

// FL_ONE_ROW: a thread has one pixel, where gobos have tables. On an H200 at 3840 x 2160 10,000 beams with gobos take
// 106 ms with four, 104 with two and 98 with one (`footlight report --pictures --quick --no-judge --gobos --beams 10000
// --shadows off`); without gobos 3.6 with four and 5.6 with one. On lavapipe one takes twice the time of four: 440
// instead of 230 ms (`footlight render --demo --from 12s --until 12.2s --every 40ms --size 640x360 --json`).
#ifdef FL_ONE_ROW
#define FL_ROWS 1
#endif
#define FL_DEPTHS_ACCESS readonly
#include "render/shaders/lib/air_tile.glsl"

layout(constant_id = FL_SPEC_METHOD) const uint kMethod = FL_METHOD_GAUSS;

// Whether samples of the beam's gobo are taken once a chord, in a loop of their own. In haze that is not even each lit
// part has its own densities.
bool is_sampled(BeamRow row) {
#ifdef FL_HAZE_FIELD
  const bool once = !kShadows;
#else
  const bool once = kLensPoints == 1u;
#endif
#ifdef FL_GOBO_BEAMS
  return once && kMethod == uint(FL_METHOD_GAUSS) && has_gobo(row) && gobo_is_sampled(row);
#else
  return false;
#endif
}

bool tile_takes(uint beam, uint number) {
  BeamRow row = beams[beam];
  if (is_plain_beam(row) || !touches_tile(row)) return false;
  if (kShadows) walk_pairs[number] = picks_here(beam).count;
  if (is_sampled(row)) atomicOr(walk_kind[number >> 5], 1u << (number & 31u));
  return true;
}

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
#include "render/shaders/lib/air_nodes.glsl"
#include "render/shaders/lib/shadow_row_light.glsl"

// The code of gobos is long: once in the shader, and not once a row. Without them a loop over rows would take rounds
// from Mesa, which ends the loops of a thread after 65,535 of them.
#if defined(FL_GOBO_BEAMS) && !defined(FL_ONE_ROW)
#define FL_EACH_ROW [[dont_unroll]]
#else
#define FL_EACH_ROW [[unroll]]
#endif

// Light of a part of a chord, over J0 and sigma_s.
vec3 part_light(BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray, uint nodes, bool gobo) {
#ifdef FL_GOBO_BEAMS
  if (gobo) {
    if (kMethod == uint(FL_METHOD_MARCH)) {
      gobo_sample = 0u;
      const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
      return chord_inscatter_march_gobo(beam, medium, chord, ray, kNodes, kExtinction, row.gobo, as_it_is);
    }
    return gobo_inscatter(beam, medium, chord, ray, kExtinction);
  }
#endif
  if (kMethod == uint(FL_METHOD_MARCH)) {
    return vec3(chord_inscatter_march(beam, medium, chord, ray, kNodes, kExtinction));
  }
  if (kMeasured && row.measured != 0u) {
    return vec3(chord_inscatter_measured(beam, medium, chord, ray, kNodes, kExtinction));
  }
  if (kWide && beam.spread > kWideSpread) {
    return vec3(chord_inscatter_wide(beam, medium, chord, ray, kNodes > 3u ? 2u : 1u, kExtinction));
  }
  return vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
}

// Of the lit parts of a chord, or of its dark ones where those are subtracted.
vec3 parts_light(ShadowParts parts, BeamShape beam, BeamRow row, Medium medium, Chord whole, vec3 ray, uint nodes,
                 bool gobo, uint found, bool subtracts) {
  Chord chord = whole;
  vec3 value = vec3(0.0);
  // The parts, one after the other. Without shadows there is one.
  float at = 0.0;
  bool more = true;
  while (more) {
    float from = 0.0;
    float to = 1.0;
    more = false;
    if (kShadows) {
      float dark_from;
      float dark_to;
      more = shadow_parts_next(parts, at, dark_from, dark_to);
      if (subtracts && !more) break;
      from = subtracts ? dark_from : at;
      to = subtracts ? dark_to : min(dark_from, 1.0);
      at = dark_to;
      if (found != 0u) chord = chord_part(whole, from, to);
    }
    vec3 part = part_light(beam, row, medium, chord, ray, nodes, gobo);
    value += to > from ? part : vec3(0.0);
  }
  return value;
}

// Of a chord: the mean over the points of the lens from which shadows are cast. Where light is computed at nodes alone,
// they only change the weights of the whole chord's nodes; else each point has its own parts.
const uint kTurns = kLensPoints > 1u ? kLensPoints + 1u : 1u;
vec3 chord_light(uint index, uint number, uint begin, BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray,
                 uint nodes, bool gobo, uint found, bool subtracts) {
  WalkShadows shadows_of;
  ShadowChord ends;
  if (found != 0u) {
    shadows_of = walk_shadows_of(number, begin);
    ends = shadow_chord(row, beam, chord, ray);
  }
  bool by_nodes = found != 0u && !gobo && kMethod == uint(FL_METHOD_GAUSS) &&
                  !(kMeasured && row.measured != 0u) && !(kWide && beam.spread > kWideSpread);
  if (by_nodes && has_series(row, ends.line)) {
    return vec3(row_light(index, beam, medium, chord, ray, ends.line, subtracts));
  }
  bool weighs = kLensPoints > 1u && by_nodes;
  ShadowWeights weights;
  if (kLensPoints > 1u) shadow_weights_clear(weights);
  vec3 value = vec3(0.0);
  uint at = 0u;
  float rest = 1.0;  // share of the points without shadows: of those that are not met
  for (uint turn = 0u; turn < kTurns; ++turn) {
    ShadowParts parts;
    shadow_parts_clear(parts);
    float share = rest;
    if (found != 0u && (kLensPoints == 1u || at < shadows_of.count)) {
      uint point;
      parts = chord_shadows(index, shadows_of, ends, at, point);
      share = point_share(point);
    }
    if (weighs) shadow_parts_weigh(parts, share, weights);
    else if (kLensPoints == 1u || share > 0.0) {
      vec3 here = parts_light(parts, beam, row, medium, chord, ray, nodes, gobo, found, subtracts);
      value += kLensPoints == 1u ? here : share * here;
    }
    rest -= share;
  }
  if (weighs) {
    if (!subtracts) shadow_weights_invert(weights);
    value = vec3(chord_inscatter_shaded(beam, medium, chord, ray, soft_nodes(nodes), weights, kExtinction));
  }
  return value;
}

// The chord of a pixel's ray in a beam, and the beam as it is drawn there. False: there is none.
bool beam_at(uint index, BeamRow row, AirRay from, bool thin, bool plain, inout BeamShape beam,
             out float gain, out vec3 ray, out Chord chord) {
  vec3 eye = row.eye.xyz;
  ray = to_light(row, from.d);
  gain = 1.0;
  if (thin) gain = thin_in_haze(beam, row, eye, ray, dot(from.d, params.forward.xyz), from.t_max_m, plain);
  bool seen = beam_chord(beam, eye, ray, ray_begin(from.d), from.t_max_m, chord);
  if (kRectangle && row.squeeze > 0.0 && seen) seen = chord_in_rectangle(chord);
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u && seen) {
    for (int e = 0; e < 4; ++e) {
      seen = chord_cut(chord, blades[index].edge[e].xy, blades[index].edge[e].z) && seen;
    }
    chord_close(chord);
  }
  return seen;
}

// What the pixels of a thread share of a beam.
struct AirBeam {
  BeamRow row;
  BeamShape shape;
  uint found;      // its shadows in the tile
  bool subtracts;  // what is in them: the beam was added as a whole
  bool thin;
};
AirBeam air_beam(uint index, uint number) {
  AirBeam beam;
  beam.row = beams[index];
  beam.shape = beam_shape(beam.row);
  beam.shape.profile_power = drawn_profile(beam.shape.profile_power);
  beam.found = kShadows ? subgroupBroadcastFirst(walk_found[number]) : 0u;
  beam.subtracts = beam.found != 0u && !is_left(index);
  beam.thin = thin_in_haze_applies(beam.row);
  return beam;
}
void add_value(AirBeam beam, vec3 value, inout vec3 total) {
  if (!kShowsClasses) total += beam.row.j0.rgb * (beam.subtracts ? -value : value);
  else if (!beam.subtracts) total += kClassPixel;
}

void add_beams(uint begin, AirRay rays[FL_ROWS], inout vec3 total[FL_ROWS]) {
  Medium medium = Medium(params.anisotropy, params.position.w);
  FL_WALK_BEGIN(number, index, (walk_lit(walk_w) | walk_cut(walk_w)) & ~walk_kind[walk_w])
    AirBeam beam = air_beam(index, number);
    uint nodes = air_nodes(beam.shape.profile_power);
    // A rectangle's profile is the product of two.
    if (kRectangle && beam.row.squeeze > 0.0) nodes = min(kNodes + 5u, 8u);
#ifdef FL_GOBO_BEAMS
    gobo_begin(index);
    bool gobo = has_gobo(beam.row);
#else
    const bool gobo = false;
#endif
    bool plain = thin_is_plain(beam.row, gobo);
    if (beam.thin && plain) nodes = min(max(nodes, kNodes + 1u), 8u);  // (1 - rho^2)^3
    FL_EACH_ROW for (int i = 0; i < FL_ROWS; ++i) {
      BeamShape shape = beam.shape;
      float gain;
      vec3 ray;
      Chord chord;
#ifdef FL_HAZE_FIELD
      haze_begin(vec2(tile_pixel(i)) + 0.5);
#endif
      if (beam_at(index, beam.row, rays[i], beam.thin, plain, shape, gain, ray, chord)) {
        vec3 value = chord_light(index, number, begin, shape, beam.row, medium, chord, ray, nodes, gobo, beam.found,
                                 beam.subtracts);
        add_value(beam, gain * value, total[i]);
      }
    }
  FL_WALK_END
#ifdef FL_GOBO_BEAMS
  if (kGoboMethod != uint(FL_GOBO_TAPS)) return;
  FL_WALK_BEGIN(number, index, (walk_lit(walk_w) | walk_cut(walk_w)) & walk_kind[walk_w])
    AirBeam beam = air_beam(index, number);
    gobo_begin(index);
    FL_EACH_ROW for (int i = 0; i < FL_ROWS; ++i) {
      BeamShape shape = beam.shape;
      float gain;
      vec3 ray;
      Chord chord;
#ifdef FL_HAZE_FIELD
      haze_begin(vec2(tile_pixel(i)) + 0.5);
#endif
      if (beam_at(index, beam.row, rays[i], beam.thin, false, shape, gain, ray, chord)) {
        ShadowParts parts;
        shadow_parts_clear(parts);
        if (beam.found != 0u) {
          uint at = 0u;
          uint point;
          WalkShadows shadows_of = walk_shadows_of(number, begin);
          parts = chord_shadows(index, shadows_of, shadow_chord(beam.row, shape, chord, ray), at, point);
        }
        vec3 value = gobo_sampled(shape, medium, chord, ray, kExtinction, parts, beam.subtracts);
        add_value(beam, gain * value, total[i]);
      }
    }
  FL_WALK_END
#endif
}

void main() {
  uint tile = gl_WorkGroupID.y * tiles_across() + gl_WorkGroupID.x;
  if (kPlainBeams && marks_tiles() && tile_depths[tile].beams_left == 0u) return;
  FL_AIR_WALK
}
